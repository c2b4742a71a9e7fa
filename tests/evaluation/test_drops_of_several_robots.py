"""Drops of different robots are never combined; drops of one robot that contradict each other are doubtful."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bundle.commands import command
from tests.evaluation.commanded import evaluate, evaluated
from tests.evaluation.run_folder import on_other_logger, run_folder
from tfsat_host.evaluation.model_fit import cross_validation

OTHER = bytes.fromhex("00c0ffee00c0ffee")


@pytest.fixture
def drops(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folders 1 and 2, in the current one."""
    monkeypatch.chdir(tmp_path)
    for seed in (1, 2):
        run_folder(tmp_path / str(seed), seed)
    return tmp_path


@pytest.mark.parametrize(
    "asked", [("evaluate", "1", "2"), ("report", "1", "2"), ("evaluate", "--robot", "drop_tower", "1", "2")]
)
def test_drops_of_other_loggers_are_refused(drops: Path, asked: tuple[str, ...]) -> None:
    on_other_logger(drops / "2", OTHER)
    said = command(*asked, expect=2)
    assert "not of one robot" in said.err and f"2: emulated robot with logger {OTHER.hex()}" in said.err
    assert said.out == "" and not Path("report.html").exists()
    command("evaluate", "2")


def test_drops_that_contradict_each_other_end_with_3(drops: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cross_validation, "CHANCE_LEAST", 1.0)
    found = evaluated("1", "2", expect=3)["comparison"]
    assert found["agreement"]["agree"] is False and "contradict each other" in found["remarks"][0]
    said = evaluate("1", "2")
    assert said.code == 3 and "DOUBTFUL" in said.out
    assert "contradict each other" in command("report", "1", "2", expect=3).err


def test_each_drop_s_own_offsets_have_their_uncertainty(drops: Path) -> None:
    said = evaluate("1", "2")
    assert said.code == 0
    (row,) = [line for line in said.out.splitlines() if line.strip().startswith("body 1 CoM x")][-1:]
    assert row.count("±") == 3
