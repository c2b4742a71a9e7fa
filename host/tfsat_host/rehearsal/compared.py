"""What an evaluation found beside the truth that it did not see."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.rehearsal.drop import Drop
from tfsat_host.rehearsal.truth import Truth
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

_AT_REST_S = 0.03
"""A stroke's size is the change between means over so long before it and before the next one."""
_AFTER_RELEASE_S = 0.05
_BEFORE_STROKE_S = 0.1
"""The rate at which the robot was let go is taken between these: nothing has moved yet."""
_JOINTS = slice(1, 4)


@dataclass(frozen=True, slots=True)
class Compared:
    """One number.

    Attributes:
        name: For people.
        unit: Of all three.
        found: By the evaluation.
        std: Its standard deviation, as the evaluation states it.
        true: What it was.
    """

    name: str
    unit: str
    found: float
    std: float
    true: float

    @property
    def deviations(self) -> float:
        """How far it is off, in standard deviations."""
        return (self.found - self.true) / self.std


def compared(found: Evaluation, drop: Drop, truth: Truth, filed: RobotModel) -> tuple[Compared, ...]:
    """Reorientation, initial rates, strokes, centers of mass; in that order."""
    if drop.released_s is None:
        return ()
    flown = drop.truth.copy()
    flown[:, 0] -= drop.released_s
    return (
        _reorientation(found, flown),
        *_rates(found, flown),
        *_strokes(found, flown),
        *_offsets(found, truth, filed),
    )


def _attitude(flown: FloatArray, body: int, t_s: float) -> Rotation:
    row = int(np.abs(flown[:, 0] - t_s).argmin())
    return Rotation.from_quat(flown[row, 4 * body : 4 * body + 4])


def _reorientation(found: Evaluation, flown: FloatArray) -> Compared:
    turn, until_s = found.reorientation, float(found.motion.bodies[0].t_s[-1])
    true = float((_attitude(flown, 1, 0.0).inv() * _attitude(flown, 1, until_s)).magnitude())
    return Compared("reorientation", "deg", *np.rad2deg([turn.angle_rad, turn.std_rad, true]).tolist())


def _rates(found: Evaluation, flown: FloatArray) -> Iterator[Compared]:
    first_s = min((stroke.scheduled_s for stroke in found.strokes), default=float(flown[-1, 0]))
    quiet = (flown[:, 0] > _AFTER_RELEASE_S) & (flown[:, 0] < first_s - _BEFORE_STROKE_S)
    true = np.rad2deg(flown[quiet, 20:23].mean(axis=0))
    initial = found.initial_rates[0]
    rate, std = np.rad2deg(initial.rate_rad_s), np.rad2deg(initial.std_rad_s)
    for axis, name in enumerate("xyz"):
        yield Compared(
            f"initial rate {name}, body 1", "deg/s", float(rate[axis]), float(std[axis]), float(true[axis])
        )


def _strokes(found: Evaluation, flown: FloatArray) -> Iterator[Compared]:
    begins = [
        stroke.logged_s if np.isfinite(stroke.logged_s) else stroke.scheduled_s for stroke in found.strokes
    ]
    for stroke, begin_s in zip(found.strokes, begins, strict=True):
        later = [
            other_s
            for other, other_s in zip(found.strokes, begins, strict=True)
            if other.joint == stroke.joint and other_s > begin_s
        ]
        until_s = min([*later, float(found.motion.t_s[-1])])
        if not stroke.moved or stroke.unfinished or not np.isfinite(stroke.size_std_rad):
            continue
        angle = np.rad2deg(flown[:, _JOINTS][:, stroke.joint - 1])
        true = _mean_before(flown[:, 0], angle, until_s) - _mean_before(flown[:, 0], angle, begin_s)
        size, std = np.rad2deg([stroke.size_rad, stroke.size_std_rad]).tolist()
        yield Compared(f"stroke {stroke.number}", "deg", size, std, true)


def _mean_before(t_s: FloatArray, values: FloatArray, until_s: float) -> float:
    return float(values[(t_s > until_s - _AT_REST_S) & (t_s <= until_s)].mean())


def _offsets(found: Evaluation, truth: Truth, filed: RobotModel) -> Iterator[Compared]:
    fit = found.explained.fit
    true = 1e3 * (truth.model.com_m - filed.com_m)
    for name, kind, value, std in zip(fit.offsets.names, fit.offsets.kinds, fit.values, fit.std, strict=True):
        if kind == "com":
            body, axis = int(name.split()[1]) - 1, "xyz".index(name[-1])
            yield Compared(name, "mm", float(value), float(std), float(true[body, axis]))
