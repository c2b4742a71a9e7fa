"""What the README tells people to type does what it says."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from tests.cli.process import RunCli

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("protocol/*.md")])


def shell_examples(document: Path) -> list[str]:
    """The lines of the document's `sh` blocks."""
    blocks = re.findall(r"```sh\n(.*?)```", document.read_text(encoding="utf-8"), flags=re.DOTALL)
    return [line for block in blocks for line in block.splitlines() if line.strip()]


def test_examples_of_the_readme_run_in_order(tfsat_host: RunCli) -> None:
    examples = shell_examples(ROOT / "README.md")
    assert len(examples) >= 5
    for example in examples:
        program, *arguments = shlex.split(example)
        assert program == "tfsat-host"
        tfsat_host(*arguments)
    assert (tfsat_host.folder / "run" / "SD.csv").stat().st_size > 0


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_links_lead_somewhere(document: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", document.read_text(encoding="utf-8")):
        if not target.startswith(("http:", "https:", "mailto:")):
            assert (document.parent / target).exists(), target


def test_commands_named_in_the_readme_exist(tfsat_host: RunCli) -> None:
    overview = tfsat_host("--help").stdout
    for command in set(
        re.findall(r"`tfsat-host ([a-z-]+)", (ROOT / "README.md").read_text(encoding="utf-8"))
    ):
        assert f"    {command}" in overview, command
