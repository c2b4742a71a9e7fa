"""The first screen of `evaluate`: verdict, prediction, what to change, strokes; everything else by `--full`."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.evaluation.commanded import Said, evaluate, evaluate_to_json
from tests.evaluation.run_folder import run_folder

MAX_LINES = 40


@pytest.fixture
def screen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Said:
    """Evaluate a good drop on a terminal of 80 columns."""
    run_folder(tmp_path / "run")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    return evaluate("run", full=False)


def test_it_fits_and_the_verdict_is_first_and_last(screen: Said) -> None:
    lines = screen.out.splitlines()
    # On 80 columns everything important fits a screen.
    assert len(lines) <= MAX_LINES
    assert lines[0].startswith("GOOD:") and lines[-1].startswith("GOOD:")


def test_it_says_what_was_predicted_and_what_to_change(screen: Said) -> None:
    evaluation = evaluate_to_json("run")
    rows = {line.split("  ")[0].strip(): line for line in screen.out.splitlines()}
    assert f"{evaluation['reorientation_deg']:.3f} ± " in rows["measured"]
    for name, side in (("nominal model", "before"), ("fitted model", "after")):
        predicted_deg, error_deg = (float(word) for word in rows[name].split()[2:4])
        assert error_deg == pytest.approx(evaluation["attitude_error"][side]["final_norm_deg"], abs=1e-3)
        # The difference of two angles is no greater than that of the attitudes.
        assert abs(predicted_deg - evaluation["reorientation_deg"]) < error_deg + 1e-3
    change = screen.words.partition("Correction: ")[2].partition(" numbers in all")[0]
    # A tired team reads at most three numbers; the rest is written by --corrected-robot.
    assert "mm" in change and 1 <= change.count("±") <= 3


def test_each_stroke_is_a_line(screen: Said) -> None:
    rows = [line.split() for line in screen.out.splitlines() if ": joint" in line]
    assert [row[0] for row in rows] == ["1:", "2:", "3:", "4:"]
    assert np.array([float(row[3]) for row in rows]) == pytest.approx([59.0, 70.0, -59.0, -70.0])


def test_no_row_of_the_full_tables_is_split_at_80_columns(screen: Said) -> None:
    lines = evaluate("run").out.splitlines()
    # What a split row would show: a deviation below its value, or the joint's number below its stroke's.
    assert [line for line in lines if line.lstrip().startswith("± ")] == []
    rows = [line for line in lines if re.match(r" \d: joint", line)]
    assert len(rows) == 8 and all(re.match(r" \d: joint \d  ", row) for row in rows), "two tables of strokes"
    assert not re.search(r"\n\n\n", "\n".join(lines))


def test_the_rest_is_named_with_what_was_typed(screen: Said) -> None:
    assert "tfsat-host evaluate run --full" in screen.out
    assert "tfsat-host evaluate run --swarm --full" in evaluate("run", "--swarm", full=False).words
    assert len(evaluate("run").out.splitlines()) > 2 * MAX_LINES
