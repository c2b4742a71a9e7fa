"""The hypothesis that remains: one sensor is wrong, nobody knows how, and all the others agree without it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.checks.hypothesis import Hypothesis
from tfsat_host.evaluation.checks.wrong_angles import sensor_name, with_one

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_LOOK = "Look at its samples: tfsat-host decode; leave the sensor out or repair it before the next drop"
STUCK_S = 0.15
"""No sensor with noise repeats one reading for so long."""


def one_left_out(of: Consistency) -> Iterator[Hypothesis]:
    """Each gyro, and each angle sensor."""
    for body in range(4):
        rows = np.zeros(of.size, dtype=bool)
        rows[of.at_rest(body)] = True
        for joint in range(of.joints):
            if body in (int(of.model.joint_inner[joint]), int(of.model.joint_outer[joint])):
                rows[of.off_axis(joint)] = True
                rows[of.along(joint, 0)] = rows[of.along(joint, 1)] = True
        name = f"gyro of body {body + 1}"
        stuck = _stuck_from_s(of.t_s, of.late_rad_s[:, body])
        yield _without(("gyro", str(body)), name, of.own_vector, rows, stuck)
    for joint, sensor in np.ndindex(of.joints, 2):
        shown = of.readings.shown_rad[:, of.sensors(joint)[sensor], None]
        rows = np.zeros(of.size, dtype=bool)
        rows[of.along(joint, sensor)] = True
        left = with_one(of, joint, sensor, np.full(len(of.t_s), np.nan))
        stuck = _stuck_from_s(of.t_s, shown)
        yield _without(("angle", str(joint), str(sensor)), sensor_name(joint, sensor), left, rows, stuck)


def _stuck_from_s(t_s: FloatArray, readings: FloatArray) -> float | None:
    """When the longest row of equal readings (n, k) begins, if it is long enough to be a fault."""
    changed = np.flatnonzero((np.diff(readings, axis=0) != 0.0).any(axis=1))
    edges = np.concatenate([[-1], changed, [len(t_s) - 1]])
    longest = int(np.diff(edges).argmax())
    first, last = edges[longest] + 1, edges[longest + 1]
    return float(t_s[first]) if t_s[last] - t_s[first] > STUCK_S else None


def _without(
    family: tuple[str, ...], name: str, left: FloatArray, rows: BoolArray, stuck_s: float | None
) -> Hypothesis:
    cause = f"unknown; it lies with the {name}, all the others agree without it"
    if stuck_s is not None:
        cause = f"{name} repeats one reading from {stuck_s:.2f} s on"
    return Hypothesis(family, left, np.eye(len(rows))[:, rows], lambda _: cause, _LOOK)
