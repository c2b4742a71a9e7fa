"""The first answer after a drop: strokes, joint angles, reorientation of body 1; no calibration needed.

A gyro's mounting does not matter here: turning its frame leaves the angle of a rotation as it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.evaluation.motion.attitude import integrate_rates, reorientation_deg
from tfsat_host.evaluation.motion.samples import EvaluationError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog

BIAS_GUARD_S = 0.2
"""The bias is read up to this long before release."""
MIN_BIAS_S = 1.0
SMOOTHING = 9
"""Samples averaged before the largest excursion is looked for, so that noise is not taken for motion."""


@dataclass(frozen=True, eq=False)
class QuickLook:
    """What the log shows at first sight.

    Attributes:
        stroke_s: (m,) times of the stroke line's edges after release.
        joint_change_deg: (3,) largest change of each joint angle from its value before release.
        reorientation_deg: Rotation of body 1 from release to `until_s`.
        until_s: End of the integration, after release.
    """

    stroke_s: FloatArray
    joint_change_deg: FloatArray
    reorientation_deg: float
    until_s: float


def quick_look(log: DropLog, model: RobotModel, *, until_s: float) -> QuickLook:
    """Evaluates body 1 and the joints of `log` from the release to `until_s` after it, before the landing.

    Raises:
        EvaluationError: no release, too little rest before it, or body 1's gyro is missing.
    """
    if log.release_us is None:
        raise EvaluationError(
            what="The log holds no release.",
            meaning="Nothing can be said about the maneuver.",
            next_step=Advice(
                "Check that this is the recording of a drop: ", NextStep("decode"), " shows its events."
            ),
        )
    t_s = log.t_s
    rest = (t_s < -BIAS_GUARD_S) & log.imu_valid[:, 0]
    fall = (t_s >= 0.0) & (t_s <= until_s)
    if not rest.any() or np.ptp(t_s[rest]) < MIN_BIAS_S:
        raise EvaluationError(
            what=f"Less than {MIN_BIAS_S:g} s of body 1's gyro before the release.",
            meaning="Its bias cannot be taken from this log.",
            next_step="Evaluate with a calibration file, or start the recording earlier next time.",
        )
    # The quick look bridges no gaps; the full evaluation does.
    if not log.imu_valid[fall, 0].all():
        raise EvaluationError(
            what=f"{int((~log.imu_valid[fall, 0]).sum())} samples of body 1's gyro are missing in the fall.",
            meaning="Its attitude cannot be integrated across them.",
            next_step=Advice("Look at the gaps: ", NextStep("decode")),
        )
    rates = log.rate_rad_s[:, 0]
    bias = rates[rest].mean(axis=0)
    # In sensor axes: the angle of a rotation does not depend on the mounting.
    attitude = integrate_rates(t_s[fall], rates[fall] - bias)
    return QuickLook(
        stroke_s=np.array([log.seconds(event.t_us) for event in log.events if event.name == "stroke"]),
        joint_change_deg=_joint_changes(log, model, rest, fall),
        reorientation_deg=reorientation_deg(attitude[0], attitude[-1]),
        until_s=until_s,
    )


def _joint_changes(log: DropLog, model: RobotModel, rest: BoolArray, fall: BoolArray) -> FloatArray:
    """(3,) largest excursion of each joint in the fall, by its first angle sensor."""
    # Unwrap: a passage of the sensor's zero is no excursion of the joint.
    angles = np.unwrap(log.sensor_angle_rad, axis=0)
    changes = np.zeros(model.n_joints)
    for joint in range(model.n_joints):
        index = next(i for i, sensor in enumerate(model.angle_sensors) if sensor.joint == joint)
        moved = model.angle_sensors[index].direction * (angles[fall, index] - angles[rest, index].mean())
        # Whole windows only: partial ones at the ends would pull towards zero.
        moved = np.convolve(moved, np.full(SMOOTHING, 1 / SMOOTHING), mode="valid")
        changes[joint] = np.rad2deg(moved[np.argmax(np.abs(moved))])
    return changes


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
    """Format a sentence for each difference between the drop and its commands.

    Args:
        scheduled_s: m ascending times after release.
        logged_s: The stroke line's edges after release, in order: strokes that begin together have one.
        commanded_deg: m changes of a joint's angle.
        reached: m changes from `reached_deg`.
    """
    sentences = []
    starts_s, first_strokes = np.unique(scheduled_s, return_index=True)
    if len(logged_s) != len(starts_s):
        sentences.append(
            f"The log holds {len(logged_s)} starts of strokes, {len(starts_s)} were scheduled"
            f"{'' if len(starts_s) == len(scheduled_s) else ' (strokes that begin together have one)'}."
        )
    for first_stroke, planned_s, seen_s in zip(first_strokes, starts_s, logged_s, strict=False):
        # Negated, so that NaN counts as a difference.
        if not abs(seen_s - planned_s) <= TIME_TOLERANCE_S:
            sentences.append(
                f"Stroke {first_stroke + 1} began at {seen_s:.4f} s instead of {planned_s:.4f} s."
            )
    for number, (wanted_deg, got_deg) in enumerate(zip(commanded_deg, reached, strict=True), 1):
        if np.isnan(got_deg):
            sentences.append(f"Stroke {number}: the log lacks the joint's angles before or after it.")
        elif not abs(got_deg - wanted_deg) <= ANGLE_TOLERANCE_DEG:
            sentences.append(
                f"Stroke {number} moved its joint by {got_deg:+.1f} deg instead of {wanted_deg:+g} deg."
            )
    return sentences


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
        # Wrap the difference to half a turn: the two ends were unwrapped on their own.
        reached[i] = (after - before + 180.0) % 360.0 - 180.0
    return reached


def _joint_deg(log: DropLog, model: RobotModel, joint: int, t_s: float) -> float:
    """Compute the joint's angle just before `t_s` up to a constant, deg; NaN where samples are missing."""
    index = next(i for i, sensor in enumerate(model.angle_sensors) if sensor.joint == joint - 1)
    window = slice(*(np.searchsorted(log.t_s, t_s) + np.array((-WINDOW, 0))))
    is_complete = window.start >= 0 and log.angle_valid[window, index].all()
    # Lost samples stretch the window: at twice its length it may reach back into a motion.
    if not is_complete or t_s - log.t_s[window.start] > 2 * WINDOW / log.header.rate_hz:
        return float("nan")
    angles = np.unwrap(log.sensor_angle_rad[window, index])
    return float(np.rad2deg(model.angle_sensors[index].direction * angles.mean()))
