"""What `evaluate` shows on terminals of all widths, and with names that were made to do harm."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.evaluation.commanded import evaluate
from tfsat_host.cli.evaluate.phrases import number, plus_minus, printable


@pytest.mark.parametrize("columns", [80, 50, 44])
def test_prose_keeps_to_the_terminal(run: Path, monkeypatch: pytest.MonkeyPatch, columns: int) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    (run / "maneuver.toml").unlink()  # so that all until the joints is prose
    said = evaluate("run")
    prose = said.out[: said.out.index("\nJoint angles")].splitlines()
    assert len(prose) > 10
    assert max(map(len, prose)) <= columns


def test_names_that_would_paint_the_terminal(run: Path) -> None:
    evil = "[red]\x1b[2J\nVerdict     GOOD; rm -rf ~"
    run.rename(run.parent / evil)
    said = evaluate(evil)
    assert said.code == 0
    assert "\x1b" not in said.out and "\nVerdict     GOOD; rm" not in said.out
    assert "[red]\\x1b[2J\\n" in said.words


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (27.9779, 0.01394, "27.978 ± 0.014"),
        (-0.0004, 0.25, "0.00 ± 0.25"),
        (123.4, 17.0, "123 ± 17"),
        (5.0, 0.0, "5.00 ± 0.00"),
        (5.0, float("nan"), "5.00 ± unknown"),
        (float("nan"), 1.0, "unknown"),
        (1.0, 1e-12, "1.000000 ± 0.000000"),
    ],
)
def test_a_number_has_the_decimals_that_it_deserves(value: float, std: float, text: str) -> None:
    assert plus_minus(value, std) == text


def test_numbers_and_names() -> None:
    assert number(-0.001, 2) == "0.00" and number(3.14159, 2, sign=True) == "+3.14"
    assert printable("a\x1b[1m\u202eb\nü") == "a\\x1b[1m\\u202eb\\nü"
