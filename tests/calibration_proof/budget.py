"""The budget in docs/calibration.md: what each number of a calibration does to the final attitude."""

from __future__ import annotations

from pathlib import Path

from tfsat_host.evaluation.budget.attitude_budget_table import budget_table
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.robot import load_robot

BEGIN, END = "<!-- budget -->\n", "<!-- /budget -->"


def write_budget(file: Path) -> None:
    """Replaces the table between its markers."""
    text = file.read_text(encoding="utf-8")
    before, after = text.index(BEGIN) + len(BEGIN), text.index(END)
    table = budget_table(load_robot(), schedule_maneuver(four_stroke(59.0, 70.0)))
    file.write_text(text[:before] + table.rstrip("\n") + "\n" + text[after:], encoding="utf-8")
