"""The base's attitude at the end of the fall, by each body's own gyro: four answers that must be one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.checks.check import Check, judged, not_possible, z_limit
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

ATTITUDES = "attitude by each gyro"
ATTITUDE_FLOOR_RAD = np.deg2rad(0.1)
"""Of each axis: what frames give, and the 0.2 % by which a gyro's scale bends, over strokes of 70 deg and back."""


def attitude_check(motion: Motion, calibration: Calibration, model: RobotModel) -> Check:
    """The base's own gyro beside each of the others, carried through the joints."""
    if any(sensors.zero_taken is None for sensors in calibration.joints):
        why = "Without calibrated zero points of all joints no attitude can be carried from body to body."
        return not_possible(ATTITUDES, "deg", why)
    body = Multibody.of(model)
    angles = motion.angles_rad[motion.samples.fall]
    start, end = poses(body, angles[[0, -1]])[0]
    own = [b for b, one in enumerate(motion.bodies) if not one.bridged.all()]
    if body.base not in own or len(own) < 2:
        return not_possible(ATTITUDES, "deg", "Too few gyros answered for a second opinion on the attitude.")
    base = motion.bodies[body.base]
    worst: tuple[float, float, float, int] | None = None
    first = int(np.flatnonzero(motion.samples.fall)[0])
    bent = sum(joint.difference_std_rad(first, -1) ** 2 for joint in motion.joints) + ATTITUDE_FLOOR_RAD**2
    for b in (b for b in own if b != body.base):
        by = Rotation.from_matrix(start[b] @ motion.bodies[b].attitude[-1].as_matrix() @ end[b].T)
        apart = (by * base.attitude[-1].inv()).as_rotvec()
        covariance = (
            start[b] @ motion.bodies[b].covariance() @ start[b].T + base.covariance() + bent * np.eye(3)
        )
        angle = float(np.linalg.norm(apart))
        ratio = float(np.sqrt(apart @ np.linalg.solve(covariance, apart)))
        std = angle / ratio if ratio > 0.0 else float(np.sqrt(np.trace(covariance) / 3.0))
        if worst is None or ratio > worst[0]:
            worst = (ratio, angle, z_limit(3 * (len(own) - 1)) * std, b)
    if worst is None:
        return not_possible(ATTITUDES, "deg", "No gyro but the base's answered.")
    _, angle, limit, b = worst
    sentence = (
        f"At the end of the fall the gyros of bodies {b + 1} and {body.base + 1} differ by {np.rad2deg(angle):.3f} deg "
        "in the base's attitude."
    )
    return judged(ATTITUDES, float(np.rad2deg(angle)), float(np.rad2deg(limit)), "deg", sentence)
