"""What a gyro reads beyond the motion of the body that was held: a hand never holds quite still."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.steps.patterns import MotionPattern
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]


def body_to_base(model: RobotModel, angles_rad: FloatArray) -> list[FloatArray]:
    """n_bodies arrays (n, 3, 3): from body axes to those of the base, at joint angles (n, n_joints)."""
    found: dict[int, FloatArray] = {model.base: np.tile(np.eye(3), (len(angles_rad), 1, 1))}
    while len(found) < model.n_bodies:
        for joint in range(model.n_joints):
            inner, outer = int(model.joint_inner[joint]), int(model.joint_outer[joint])
            opened = Rotation.from_rotvec(angles_rad[:, joint, None] * model.joint_axis[joint]).as_matrix()
            if inner in found and outer not in found:
                found[outer] = found[inner] @ opened
            elif outer in found and inner not in found:
                found[inner] = found[outer] @ opened.transpose(0, 2, 1)
    return [found[body] for body in range(model.n_bodies)]


def joints_between(model: RobotModel, first: int, second: int) -> list[int]:
    """Joints (from 0) on the way from one body (from 0) to another."""
    return [
        joint
        for joint in range(model.n_joints)
        if _on_outer_side(model, joint, first) != _on_outer_side(model, joint, second)
    ]


def _on_outer_side(model: RobotModel, joint: int, body: int) -> bool:
    side = {int(model.joint_outer[joint])}
    while True:
        more = {
            int(end)
            for j in range(model.n_joints)
            if j != joint
            for end, other in (
                (model.joint_inner[j], model.joint_outer[j]),
                (model.joint_outer[j], model.joint_inner[j]),
            )
            if int(other) in side
        } - side
        if not more:
            return body in side
        side |= more


def sense_of(model: RobotModel, joint: int, body: int) -> float:
    """+1 where a body (from 0) turns about a joint's axis (from 0) as it opens, -1 where it turns against it."""
    across = joints_between(model, int(model.joint_outer[joint]), body)
    return -1.0 if joint in across else 1.0


def reference_of(pattern: MotionPattern, model: RobotModel) -> int:
    """The held body (1 to 4) that the joint joins to the moved ones."""
    joint = pattern.joint - 1
    ends = (int(model.joint_inner[joint]) + 1, int(model.joint_outer[joint]) + 1)
    return next(body for body in ends if body in pattern.held)


def axis_in_body(
    model: RobotModel, joint: int, body: int, to_base: Sequence[FloatArray], weight: FloatArray
) -> FloatArray:
    """(3,) a joint's axis (joint from 0) in a body's axes (body from 0), mean over the recording by weights (n,)."""
    inner = int(model.joint_inner[joint])
    seen = _in_axes_of(to_base[body], to_base[inner] @ model.joint_axis[joint])
    mean = weight @ seen
    return np.asarray(mean / np.linalg.norm(mean))


def without_held_motion(
    readings_rad_s: FloatArray,
    body: int,
    held: int,
    gyros: Sequence[GyroCalibration],
    to_base: Sequence[FloatArray],
) -> FloatArray:
    """(n, 3) what the gyro of `body` reads, less bias and less what the motion of the body `held` makes of it.

    Args:
        readings_rad_s: (n, 4, 3) of all gyros, sensor axes.
        body, held: 1 to 4.
        gyros: What is known of them so far.
        to_base: From `body_to_base`.
    """
    held_rate = gyros[held - 1].body_rates(readings_rad_s[:, held - 1])
    in_base = (to_base[held - 1] @ held_rate[:, :, None])[:, :, 0]
    carried = _in_axes_of(to_base[body - 1], in_base)
    gyro = gyros[body - 1]
    return np.asarray(readings_rad_s[:, body - 1] - gyro.bias_rad_s - gyro.readings(carried))


def _in_axes_of(to_base: FloatArray, vectors: FloatArray) -> FloatArray:
    """(n, 3) vectors in axes of the base, in those of the body that `to_base` (n, 3, 3) belongs to."""
    return np.asarray((vectors[:, None, :] @ to_base)[:, 0])
