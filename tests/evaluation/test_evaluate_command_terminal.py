"""What `evaluate` shows on terminals of all widths, and with names that were made to do harm."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.evaluation.commanded import evaluate
from tfsat_host.present.terminal import printable


@pytest.mark.parametrize("columns", [80, 50, 44])
def test_prose_keeps_to_the_terminal(run: Path, monkeypatch: pytest.MonkeyPatch, columns: int) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    (run / "maneuver.toml").unlink()  # so that all until the joints is prose
    said = evaluate("run")
    prose = said.out[: said.out.index("\nJoints ")].splitlines()
    assert len(prose) > 10
    assert max(map(len, prose)) <= columns


def test_names_that_would_paint_the_terminal(run: Path) -> None:
    evil = "[red]\x1b[2J\nVerdict     GOOD; rm -rf ~"
    run.rename(run.parent / evil)
    said = evaluate(evil)
    assert said.code == 0
    assert "\x1b" not in said.out and "\nVerdict     GOOD; rm" not in said.out
    assert "[red]\\x1b[2J\\n" in said.words


def test_names_are_shown_as_they_can_be() -> None:
    assert printable("a\x1b[1m\u202eb\nü") == "a\\x1b[1m\\u202eb\\nü"
