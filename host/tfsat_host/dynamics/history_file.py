"""Joint angles over time from a CSV file, as sensors or another program give them.

    t_s,theta1_deg,theta2_deg,theta3_deg
    0.000,0.0,0.0,0.0
    0.010,0.1,0.0,0.0

Times count from the release; rows before it say only where the joints then are. Other columns are ignored, so that
what `simulate --out` writes flies again. A rehearsal's truth.csv, whose joints are joint_1_deg and so on, flies too.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Literal, NoReturn

import numpy as np

from tfsat_host.dynamics.history import JointHistory, sampled
from tfsat_host.errors import TfsatError
from tfsat_host.robot.model import FloatArray

_OF_TRUTH = re.compile(r"^joint_(\d+)_deg$", re.ASCII)
_ANGLE = re.compile(r"theta\d+_deg", re.ASCII)
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# Beyond these nothing is measured: the numbers are of another unit, or damaged.
_LARGEST = {"t_s": 1e9, "deg": 1e5}
_CLOSEST_S = 1e-9


class HistoryFileError(TfsatError):
    """The file does not give the angle of every joint over time (exit code 1)."""


def read_history(
    path: Path, joint_count: int, *, between: Literal["cubic", "linear"] = "cubic"
) -> JointHistory:
    """The history of all joints in a file.

    Args:
        path: A CSV file with commas, points for decimals and the columns t_s and theta1_deg to thetaN_deg.
        joint_count: Number of joints of the robot.
        between: What lies between two samples, see `sampled`.

    Raises:
        HistoryFileError: the file cannot be read or understood; names file, line and cure.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            t_s, angles_deg = _samples(path, file, joint_count)
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is no text in UTF-8"
        _fail(f"The joint history {path} cannot be read: {reason}.", "Give the path of a CSV file.")
    except csv.Error as error:
        _fail(f"{path}: this is no CSV file: {error}.", f"Begin it with the line {_header(joint_count)}.")
    return sampled(t_s, np.radians(angles_deg), between=between)


def _samples(path: Path, file: Iterable[str], joint_count: int) -> tuple[FloatArray, FloatArray]:
    rows = csv.reader(file, strict=True)
    wanted = _header(joint_count).split(",")
    names = [_OF_TRUTH.sub(r"theta\1_deg", name.strip()) for name in next(rows, [])]
    missing = [name for name in wanted if name not in names]
    if missing:
        what = f"{path}:1: there is no column {missing[0]}."
        _fail(what, f"Begin the file with the line {_header(joint_count)}; separate columns by commas.")
    for name in wanted:
        if names.count(name) > 1:
            what = f"{path}:1: the column {name} is there {names.count(name)} times."
            _fail(what, "Keep the one that is meant, and rename or remove the other.")
    for name in names:
        if name.lower().startswith("theta") and _ANGLE.fullmatch(name) and name not in wanted:
            what = f"{path}:1: the column {name} is one too many: the robot has {joint_count} joints."
            _fail(what, "Remove the column, or name the robot that moved so.")
    columns = [names.index(name) for name in wanted]
    samples: list[list[float]] = []
    for row in rows:
        if row:
            line = rows.line_num
            sample = [_number(path, line, row, column, names) for column in columns]
            _check_time(path, line, sample[0], samples[-1][0] if samples else None)
            samples.append(sample)
    table = _from_release(np.array(samples).reshape(-1, len(wanted)))
    if len(table) < 2:
        _fail(
            f"{path}: a history needs two samples after the release at least; there are {len(table)}.",
            "Add rows.",
        )
    return table[:, 0], table[:, 1:]


def _from_release(table: FloatArray) -> FloatArray:
    """The rows (m, 1 + joints) from t = 0 on; between two rows the angles there lie on a straight line."""
    later = table[table[:, 0] >= 0.0]
    if len(later) == len(table) or len(later) == 0 or later[0, 0] == 0.0:
        return later
    before, after = table[len(table) - len(later) - 1], later[0]
    at_release = before + (after - before) * (0.0 - before[0]) / (after[0] - before[0])
    at_release[0] = 0.0
    return np.vstack([at_release, later])


def _number(path: Path, line: int, row: list[str], column: int, names: list[str]) -> float:
    text = row[column].strip() if column < len(row) else ""
    if not _NUMBER.fullmatch(text):
        shown = repr(text) if text else "missing"
        cure = "Write a number there, with a point for the decimals, or leave out the whole row."
        _fail(f"{path}:{line}: {names[column]} is {shown}.", cure)
    value = float(text)
    largest = _LARGEST.get(names[column], _LARGEST["deg"])
    if abs(value) > largest:
        what = f"{path}:{line}: {names[column]} is {value:g}, beyond {largest:g}: no joint was measured so."
        _fail(what, "Correct the number, or leave out the whole row.")
    return value


def _check_time(path: Path, line: int, t_s: float, before_s: float | None) -> None:
    if before_s is not None and t_s <= before_s:
        what = f"{path}:{line}: t_s is {t_s:g} after {before_s:g} in the row before: times must increase."
        _fail(what, "Sort the rows by t_s, and keep one row for each time.")
    if before_s is not None and t_s - before_s < 0.5 * _CLOSEST_S:
        what = (
            f"{path}:{line}: t_s is {t_s - before_s:.1g} s after the row before: no clock tells them apart."
        )
        _fail(what, "Leave out one of the two rows.")


def _header(joint_count: int) -> str:
    return ",".join(["t_s", *(f"theta{joint}_deg" for joint in range(1, joint_count + 1))])


def _fail(what: str, next_step: str) -> NoReturn:
    raise HistoryFileError(
        what=what, meaning="The motion of the joints is unknown; nothing was simulated.", next_step=next_step
    )
