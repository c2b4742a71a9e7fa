"""Strokes that overlap, as the servos carry them out, and the rotation by them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import JointHistory, Multibody
from tfsat_host.dynamics.history import ServoMotion, history_of, shortest_s
from tfsat_host.dynamics.propagate import Propagation
from tfsat_host.robot import RobotModel


def stroke_s(robot: RobotModel, joints: Sequence[int], angles_rad: FloatArray) -> FloatArray:
    """(k, ...) durations of strokes by angles (k, ...): at the average rate, or as fast as the servo can."""
    average, greatest, acceleration = _servos(robot, joints, angles_rad.ndim)
    size = np.abs(angles_rad)
    return np.asarray(np.maximum(size / average, shortest_s(size, greatest, acceleration)))


def stroke_history(
    robot: RobotModel,
    joints: Sequence[int],
    angles_rad: FloatArray,
    starts_s: FloatArray,
    edges_s: FloatArray | None = None,
) -> JointHistory:
    """Return the motion of strokes by angles (k, ...) with starts (k, ...), from the start pose.

    Its breaks include `edges_s` (m, ...), if there are any.
    """
    average, greatest, acceleration = _servos(robot, joints, angles_rad.ndim)
    motion = ServoMotion.of(
        joints, angles_rad, starts_s, np.abs(angles_rad) / average, greatest, acceleration
    )
    instants = motion.changes_s if edges_s is None else np.concatenate([motion.changes_s, edges_s])
    start_rad = np.array([servo.start_rad for servo in robot.servos])
    return history_of(motion, np.sort(instants, axis=0), start_rad)


def fly_history(body: Multibody, history: JointHistory, step_s: float = math.inf) -> FloatArray:
    """Return quaternions (m, 4, ...) of the base of `body` after each step of a motion, at zero angular momentum.

    With steps of any length there is one for each piece of the history, good to some 1e-4 deg.
    """
    return Propagation(body, history, None, None, step_s=step_s, order=6).attitudes()


def _servos(robot: RobotModel, joints: Sequence[int], ndim: int) -> FloatArray:
    """(3, k, 1 ...) average rate, greatest rate and acceleration of each stroke's servo."""
    servos = [robot.servos[joint] for joint in joints]
    rows = [[s.average_rate_rad_s, s.max_rate_rad_s, s.acceleration_rad_s2] for s in servos]
    return np.array(rows).T.reshape(3, -1, *(1,) * (ndim - 1))
