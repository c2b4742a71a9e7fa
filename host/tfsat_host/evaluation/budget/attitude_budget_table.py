"""The budget of the attitude as a table for people."""

from __future__ import annotations

from collections.abc import Sequence

from tfsat_host.evaluation.budget.attitude_budget import CALIBRATED, UNCALIBRATED, Budget, attitude_budget
from tfsat_host.evaluation.budget.attitude_errors import Turned
from tfsat_host.maneuver import Schedule
from tfsat_host.robot import RobotModel

_HEAD = (
    "source",
    "before",
    "attitude, deg",
    "reorientation, deg",
    "calibrated",
    "attitude, deg",
    "reorientation, deg",
)


def budget_table(robot: RobotModel, schedule: Schedule, bodies: Sequence[int] = (1, 2, 3)) -> str:
    """Markdown: every source for the first body, then what all sources give for each; exact numbers.

    Args:
        robot, schedule: As `attitude_budget`.
        bodies: 1 to 4.
    """
    before, after = (
        [attitude_budget(robot, schedule, body, accuracies) for body in bodies]
        for accuracies in (UNCALIBRATED, CALIBRATED)
    )
    rows = [
        [was.source, was.size, *_angles(was.exact), now.size, *_angles(now.exact)]
        for was, now in zip(before[0].effects, after[0].effects, strict=True)
    ]
    for was_all, now_all in zip(before, after, strict=True):
        rows += _totals(was_all, now_all)
    lines = [_HEAD, ("---", *("--:",) * (len(_HEAD) - 1)), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def _totals(before: Budget, after: Budget) -> list[list[str]]:
    pairs = (
        ("gyro", before.of_gyro(), after.of_gyro()),
        ("prediction", before.of_prediction(), after.of_prediction()),
        ("their difference", before.of_difference(), after.of_difference()),
    )
    return [
        [f"**body {before.body}, {name}**", "", *_angles(was), "", *_angles(now)] for name, was, now in pairs
    ]


def _angles(turned: Turned) -> tuple[str, str]:
    return _angle(turned.attitude_deg), _angle(turned.reorientation_deg)


def _angle(value_deg: float) -> str:
    return f"{value_deg:.3f}" if value_deg < 1.0 else f"{value_deg:.2f}"
