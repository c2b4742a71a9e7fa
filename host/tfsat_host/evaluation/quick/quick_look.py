"""The first answer after a drop: strokes, joint angles, reorientation of body 1; no calibration needed.

A gyro's mounting does not matter here: turning its frame leaves the angle of a rotation as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.attitude import integrate_rates, reorientation_deg
from tfsat_host.evaluation.errors import EvaluationError
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog

FloatArray = NDArray[np.float64]

BIAS_GUARD_S = 0.2
"""The bias is read up to this long before release."""
LEAST_BIAS_S = 1.0
SMOOTHING = 9
"""Samples averaged before the largest excursion is looked for, so that noise is not taken for motion."""


@dataclass(frozen=True, eq=False)
class QuickLook:
    """What the log shows at first sight.

    Attributes:
        stroke_s: (m,) times of the stroke line's edges after release.
        joint_change_deg: (3,) largest change of each joint angle from its value before release.
        reorientation_deg: Rotation of body 1 from release to `until_s`.
        bias_std_deg_s: (3,) standard error of body 1's bias.
        until_s: End of the integration, after release.
    """

    stroke_s: FloatArray
    joint_change_deg: FloatArray
    reorientation_deg: float
    bias_std_deg_s: FloatArray
    until_s: float


def quick_look(log: DropLog, model: RobotModel, *, until_s: float) -> QuickLook:
    """Evaluates body 1 and the joints of `log` from release to `until_s`.

    Args:
        log: A decoded drop; its times count from the release.
        model: For the direction of the angle sensors.
        until_s: After release, before the landing.

    Raises:
        EvaluationError: no release, too little rest before it, or body 1's gyro is missing.
    """
    if log.release_us is None:
        raise EvaluationError(
            what="The log holds no release.",
            meaning="Nothing can be said about the maneuver.",
            next_step="Check that this is the recording of a drop: tfsat-host decode shows its events.",
        )
    t_s = log.t_s
    rest = (t_s < -BIAS_GUARD_S) & log.imu_valid[:, 0]
    fall = (t_s >= 0.0) & (t_s <= until_s)
    if not rest.any() or np.ptp(t_s[rest]) < LEAST_BIAS_S:
        raise EvaluationError(
            what=f"Less than {LEAST_BIAS_S:g} s of body 1's gyro before the release.",
            meaning="Its bias cannot be taken from this log.",
            next_step="Evaluate with a calibration file, or start the recording earlier next time.",
        )
    if not log.imu_valid[fall, 0].all():
        raise EvaluationError(
            what=f"{int((~log.imu_valid[fall, 0]).sum())} samples of body 1's gyro are missing in the fall.",
            meaning="Its attitude cannot be integrated across them.",
            next_step="Look at the gaps: tfsat-host decode",
        )
    rates = log.rate_rad_s[:, 0]
    bias = rates[rest].mean(axis=0)
    attitude = integrate_rates(t_s[fall], rates[fall] - bias)
    return QuickLook(
        stroke_s=np.array([log.seconds(event.t_us) for event in log.events if event.name == "stroke"]),
        joint_change_deg=_joint_changes(log, model, rest, fall),
        reorientation_deg=reorientation_deg(attitude[0], attitude[-1]),
        bias_std_deg_s=np.rad2deg(rates[rest].std(axis=0) / np.sqrt(rest.sum())),
        until_s=until_s,
    )


def _joint_changes(
    log: DropLog, model: RobotModel, rest: NDArray[np.bool_], fall: NDArray[np.bool_]
) -> FloatArray:
    """(3,) largest excursion of each joint in the fall, by its first angle sensor."""
    angles = np.unwrap(log.sensor_angle_rad, axis=0)
    changes = np.zeros(model.n_joints)
    for joint in range(model.n_joints):
        index = next(i for i, sensor in enumerate(model.angle_sensors) if sensor.joint == joint)
        moved = model.angle_sensors[index].direction * (angles[fall, index] - angles[rest, index].mean())
        moved = np.convolve(moved, np.full(SMOOTHING, 1 / SMOOTHING), mode="valid")
        changes[joint] = np.rad2deg(moved[np.argmax(np.abs(moved))])
    return changes
