"""An evaluation's numbers against the truth, and the truth as files."""

from __future__ import annotations

import dataclasses
import io
import json
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.quantity import Column, Columns
from tfsat_host.rehearsal.rehearsed_drop import Drop
from tfsat_host.rehearsal.truth import Truth
from tfsat_host.robot import RobotModel

_AT_REST_S = 0.03
"""A stroke's size is the change between means over so long before it and before the next one."""
_AFTER_RELEASE_S = 0.05
_BEFORE_STROKE_S = 0.1
"""The rate at which the robot was let go is taken between these: nothing has moved yet."""
_HIDDEN = ("mass_kg", "com_m", "inertia_kg_m2", "joint_point_m", "joint_axis")
"""Of the robot that flew, whatever its file says."""
_T, _JOINTS, _RATES, _BODY_1_RATE = 0, slice(1, 4), slice(20, 32), slice(20, 23)
"""Columns of a row of truth; see `EmulatedRobot.truth`."""


@dataclass(frozen=True, slots=True)
class EstimateAndTruth:
    """One number.

    Attributes:
        name: For people.
        unit: Of all three.
        estimate: By the evaluation.
        std: Its standard deviation, as the evaluation states it.
        true: What it was.
    """

    name: str
    unit: str
    estimate: float
    std: float
    true: float

    @property
    def deviations(self) -> float:
        """Error in standard deviations."""
        return (self.estimate - self.true) / self.std


COMPARED: Columns = (
    Column("name", "number"),
    Column("found", "estimate", of="estimate"),
    Column("std", "±"),
    Column("true", "truth"),
    Column("unit", "unit"),
    Column("deviations", "error (σ)", form="+.1f"),
)


def compare_with_truth(evaluation: Evaluation, drop: Drop) -> tuple[EstimateAndTruth, ...]:
    """Reorientation, initial rates, strokes, centers of mass; in that order. Nothing of a robot that did not fall."""
    if drop.released_s is None:
        return ()
    truth_rows = drop.truth.copy()
    # From the rehearsal's clock to times after the release, as the evaluation has them.
    truth_rows[:, _T] -= drop.released_s
    return (
        _reorientation(evaluation, truth_rows),
        *_rates(evaluation, truth_rows),
        *_strokes(evaluation, truth_rows),
        *_offsets(evaluation, drop.robot),
    )


def turned_rad(truth_rows: FloatArray, first_s: float, last_s: float) -> float:
    """Angle by which body 1 turned between two times of rows of truth."""
    # Nearest rows: the truth has one each millisecond.
    rows = [int(np.abs(truth_rows[:, _T] - t_s).argmin()) for t_s in (first_s, last_s)]
    start, end = Rotation.from_quat(truth_rows[rows, 4:8])
    # Rotation from one attitude to the other, whatever its axis.
    return float((start.inv() * end).magnitude())


def _reorientation(evaluation: Evaluation, truth_rows: FloatArray) -> EstimateAndTruth:
    turn, true = (
        evaluation.reorientation,
        turned_rad(truth_rows, 0.0, float(evaluation.motion.bodies[0].t_s[-1])),
    )
    return EstimateAndTruth(
        "reorientation", "deg", *np.rad2deg([turn.angle_rad, turn.std_rad, true]).tolist()
    )


def _rates(evaluation: Evaluation, truth_rows: FloatArray) -> Iterator[EstimateAndTruth]:
    first_s = min((stroke.scheduled_s for stroke in evaluation.strokes), default=float(truth_rows[-1, _T]))
    # Between the release and the first stroke no joint moves: the mean is the rate that is evaluated.
    quiet = (truth_rows[:, _T] > _AFTER_RELEASE_S) & (truth_rows[:, _T] < first_s - _BEFORE_STROKE_S)
    initial = evaluation.initial_rates[0]
    numbers = np.rad2deg(
        [initial.rate_rad_s, initial.std_rad_s, truth_rows[quiet, _BODY_1_RATE].mean(axis=0)]
    )
    for axis, values in zip("xyz", numbers.T.tolist(), strict=True):
        yield EstimateAndTruth(f"initial rate {axis}, body 1", "deg/s", *values)


def _strokes(evaluation: Evaluation, truth_rows: FloatArray) -> Iterator[EstimateAndTruth]:
    # The log's time if it has one: that is when the sequencer began the stroke.
    begins = [
        (stroke, stroke.logged_s if np.isfinite(stroke.logged_s) else stroke.scheduled_s)
        for stroke in evaluation.strokes
    ]
    for stroke, begin_s in begins:
        # A stroke is over at the latest when the same joint begins its next one.
        later = [other_s for other, other_s in begins if other.joint == stroke.joint and other_s > begin_s]
        until_s = min([*later, float(evaluation.motion.t_s[-1])])
        # Without a size and its standard deviation there is nothing to compare.
        if not stroke.moved or stroke.unfinished or not np.isfinite(stroke.size_std_rad):
            continue
        angle = truth_rows[:, _JOINTS][:, stroke.joint - 1]
        before, after = (
            angle[(truth_rows[:, _T] > t_s - _AT_REST_S) & (truth_rows[:, _T] <= t_s)].mean()
            for t_s in (begin_s, until_s)
        )
        numbers = np.rad2deg([stroke.size_rad, stroke.size_std_rad, after - before]).tolist()
        yield EstimateAndTruth(f"stroke {stroke.number}", "deg", *numbers)


def _offsets(evaluation: Evaluation, truth: Truth) -> Iterator[EstimateAndTruth]:
    if not evaluation.is_given("offsets") or not evaluation.is_given():
        return
    fit = evaluation.explained.fit
    # In mm, as the fit's parameters; each is a direction onto which the true offset is projected.
    true = 1e3 * (truth.model.com_m - evaluation.model.com_m)
    for parameter, value, std in zip(fit.offsets.parameters, fit.values, fit.std, strict=True):
        if parameter.kind == "com":
            yield EstimateAndTruth(
                parameter.name, "mm", float(value), float(std), float(parameter.shape @ true[parameter.of])
            )


def truth_text(drop: Drop, filed: RobotModel) -> str:
    """`truth.json`: angles in rad, lengths in m, times in s of the rehearsal's clock."""
    truth, errors = drop.robot, drop.robot.imperfections
    values = {
        "format": 1,
        "seed": truth.seed,
        "faults": [fault.name for fault in drop.faults],
        "imu": truth.imu,
        "released_s": drop.released_s,
        "landed_s": drop.landed_s,
        "rate_rad_s": truth.rate_rad_s,
        "com_offset_m": truth.model.com_m - filed.com_m,
        "robot": {name: getattr(truth.model, name) for name in _HIDDEN},
        "imperfections": {field.name: getattr(errors, field.name) for field in dataclasses.fields(errors)},
    }
    plain = json.dumps(
        values, indent=1, default=lambda leaf: leaf.hex() if isinstance(leaf, bytes) else leaf.tolist()
    )
    return plain + "\n"


def truth_table(drop: Drop) -> str:
    """`truth.csv`: time after release, joint angles in deg, attitudes as quaternions, body rates in deg/s."""
    names = ["t_s", *(f"joint_{i}_deg" for i in range(1, 4))]
    names += [f"body_{i}_q{axis}" for i in range(1, 5) for axis in "xyzw"]
    names += [f"body_{i}_rate_{axis}_deg_s" for i in range(1, 5) for axis in "xyz"]
    rows = drop.truth.copy()
    rows[:, _T] -= drop.released_s or 0.0
    for angles in (_JOINTS, _RATES):
        rows[:, angles] = np.rad2deg(rows[:, angles])
    text = io.StringIO()
    np.savetxt(text, rows, fmt="%.9g", delimiter=",", header=",".join(names), comments="")
    return text.getvalue()
