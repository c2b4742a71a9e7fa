"""What the log says of each stroke: when it began, how far it moved its joint; and whether that was the plan."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog

FloatArray = NDArray[np.float64]

WINDOW = 4
"""Samples averaged for one reading of a joint: 14 ms at 280 Hz, too short for a joint to go 1 deg after arriving."""

ANGLE_TOLERANCE_DEG = 2.0
"""A calibrated servo's play and where it happens to stop come to more than a degree there and back."""
TIME_TOLERANCE_S = 5e-4
"""Two crystals differ by 0.03 %, over the 1.8 s of a maneuver."""


def disagreements(
    scheduled_s: Sequence[float],
    logged_s: Sequence[float] | FloatArray,
    commanded_deg: Sequence[float],
    reached: Sequence[float] | FloatArray,
) -> list[str]:
    """Where the drop was not what was commanded, one sentence each.

    Args:
        scheduled_s: m times after release.
        logged_s: The stroke line's edges after release, in order; not always m.
        commanded_deg: m changes of a joint's angle.
        reached: m changes from `reached_deg`.
    """
    found = []
    if len(logged_s) != len(scheduled_s):
        found.append(f"The log holds {len(logged_s)} strokes, {len(scheduled_s)} were scheduled.")
    for number, (planned_s, seen_s) in enumerate(zip(scheduled_s, logged_s, strict=False), 1):
        if not abs(seen_s - planned_s) <= TIME_TOLERANCE_S:
            found.append(f"Stroke {number} began at {seen_s:.4f} s instead of {planned_s:.4f} s.")
    for number, (wanted_deg, got_deg) in enumerate(zip(commanded_deg, reached, strict=True), 1):
        if np.isnan(got_deg):
            found.append(f"Stroke {number}: the log lacks the joint's angles before or after it.")
        elif not abs(got_deg - wanted_deg) <= ANGLE_TOLERANCE_DEG:
            found.append(
                f"Stroke {number} moved its joint by {got_deg:+.1f} deg instead of {wanted_deg:+g} deg."
            )
    return found


def reached_deg(
    log: DropLog, model: RobotModel, joints: Sequence[int], starts_s: Sequence[float], end_s: float
) -> FloatArray:
    """(m,) change of the moved joint in each of m strokes, deg.

    A stroke lasts until the same joint is moved again, or until `end_s`: a joint that arrives late has
    arrived, one that is turned back on its way has not. The first angle sensor of the joint is read; a
    change without enough samples at either end is NaN.

    Args:
        log: A decoded drop with a release.
        model: For the direction of the angle sensors.
        joints: m joints, 1 to 3.
        starts_s: m ascending times after the release.
        end_s: After the release; before the robot hits the ground.
    """
    reached = np.empty(len(joints))
    for i, (joint, start_s) in enumerate(zip(joints, starts_s, strict=True)):
        again = (starts_s[k] for k in range(i + 1, len(joints)) if joints[k] == joint)
        before, after = (_joint_deg(log, model, joint, t_s) for t_s in (start_s, next(again, end_s)))
        reached[i] = (after - before + 180.0) % 360.0 - 180.0
    return reached


def _joint_deg(log: DropLog, model: RobotModel, joint: int, t_s: float) -> float:
    """The joint's angle just before `t_s`, deg, but for a constant; NaN where samples are missing."""
    index = next(i for i, sensor in enumerate(model.angle_sensors) if sensor.joint == joint - 1)
    window = slice(*(np.searchsorted(log.t_s, t_s) + np.array((-WINDOW, 0))))
    known = window.start >= 0 and log.angle_valid[window, index].all()
    if not known or t_s - log.t_s[window.start] > 2 * WINDOW / log.header.rate_hz:
        return float("nan")
    angles = np.unwrap(log.sensor_angle_rad[window, index])
    return float(np.rad2deg(model.angle_sensors[index].direction * angles.mean()))
