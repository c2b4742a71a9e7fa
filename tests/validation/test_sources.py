"""The hash of a proof's code changes with what runs, and with nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.validation.sources import code_sha256

FILES = {
    "tests/run/campaign.py": "from tfsat_host.model import mass_kg\n",
    "tests/page.py": "print(1)\n",
    "host/tfsat_host/__init__.py": "",
    "host/tfsat_host/model.py": '"""Masses."""\n\nfrom tfsat_host import units\n\nmass_kg = 2.8 * units.KG\n',
    "host/tfsat_host/units.py": "KG = 1.0\n",
    "firmware/core.cpp": '// why\nint ticks() { return 2; }  /* "8" */\n',
    "robots/one.toml": "mass_kg = 1\n",
}


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.mark.parametrize(
    ("name", "text"),
    [
        (
            "host/tfsat_host/model.py",
            '"""Mass."""\n\nfrom tfsat_host import units\nmass_kg = 2.8 * units.KG  # kg\n"""So."""\n',
        ),
        ("firmware/core.cpp", "int ticks() {\n  return 2;\n}\n"),
        ("tests/page.py", "print(2)\n"),
    ],
)
def test_words_and_layout_cost_no_campaign(tree: Path, name: str, text: str) -> None:
    before = code_sha256("tests.run.campaign", tree)
    (tree / name).write_text(text)
    assert code_sha256("tests.run.campaign", tree) == before


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("tests/run/campaign.py", "from tfsat_host.model import mass_kg as mass\n"),
        ("host/tfsat_host/units.py", "KG = 1.1\n"),
        ("firmware/core.cpp", "int ticks() { return 3; }\n"),
        ("robots/one.toml", "mass_kg = 2\n"),
    ],
)
def test_what_runs_does(tree: Path, name: str, text: str) -> None:
    before = code_sha256("tests.run.campaign", tree)
    (tree / name).write_text(text)
    assert code_sha256("tests.run.campaign", tree) != before
