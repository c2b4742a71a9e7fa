"""An independent statement of the free-floating attitude: differentiate poses, conserve momentum.

Nothing is shared with the emulator's recursion of velocities: poses come from products of homogeneous
transforms, their derivatives from a complex step, the attitude from scipy's DOP853.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tests.dynamics.chain_driver import Robot
from tfsat_host.arrays import FloatArray

ComplexArray = NDArray[np.complex128]
_STEP = 1e-30


def _transform(axis: FloatArray, point: FloatArray, angle: complex) -> NDArray[Any]:
    """Rotation by `angle` about the line through `point` (Rodrigues), as a 4x4 matrix."""
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    # Rodrigues with a complex angle: its imaginary part is the derivative.
    rotation = np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)
    transform = np.eye(4, dtype=np.complex128)
    transform[:3, :3] = rotation
    transform[:3, 3] = point - rotation @ point
    return transform


def _poses(robot: Robot, angles: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Rotations (n, 3, 3) and CoM positions (n, 3), relative to the base as it lies in the global frame."""
    placed = {robot.base: np.eye(4, dtype=np.complex128)}
    while len(placed) < len(robot.mass):
        for j, (inner, outer) in enumerate(zip(robot.inner, robot.outer, strict=True)):
            if inner in placed and outer not in placed:
                placed[outer] = placed[inner] @ _transform(robot.axis[j], robot.point[j], angles[j])
            elif outer in placed and inner not in placed:
                # The inverse transform where the joint is passed the other way.
                placed[inner] = placed[outer] @ _transform(robot.axis[j], robot.point[j], -angles[j])
    transforms = np.array([placed[i] for i in range(len(robot.mass))])
    com = np.column_stack([robot.origin + robot.com, np.ones(len(robot.mass))])
    return transforms[:, :3, :3], np.einsum("nij,nj->ni", transforms, com)[:, :3]


def _unskew(m: FloatArray) -> FloatArray:
    return np.array([m[2, 1], m[0, 2], m[1, 0]])


def inertia_and_momentum(
    robot: Robot, angles: FloatArray, rates: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Total inertia (3, 3) about the CoM and the momentum (3,) of the joints' motion alone, base frame."""
    # A complex step of 1e-30: no difference is ever subtracted.
    rotated, moved = _poses(robot, angles + 1j * _STEP * rates)
    rotation, rotation_rate = rotated.real, rotated.imag / _STEP
    com, velocity = moved.real, moved.imag / _STEP
    weights = robot.mass / robot.mass.sum()
    r, v = com - weights @ com, velocity - weights @ velocity
    inertia, momentum = np.zeros((3, 3)), np.zeros(3)
    for i, mass in enumerate(robot.mass):
        local = rotation[i] @ robot.inertia[i] @ rotation[i].T
        inertia += local + mass * (r[i] @ r[i] * np.eye(3) - np.outer(r[i], r[i]))
        # Momentum of the joints' motion alone: the base stands still.
        momentum += local @ _unskew(rotation_rate[i] @ rotation[i].T) + mass * np.cross(r[i], v[i])
    return inertia, momentum


def rate_without_momentum(robot: Robot, angles: FloatArray, rates: FloatArray) -> FloatArray:
    """Base rate (3,), base axes, that cancels the momentum of the joints' motion."""
    inertia, joints = inertia_and_momentum(robot, angles, rates)
    return np.asarray(-np.linalg.solve(inertia, joints), dtype=np.float64)


def free_attitude(
    robot: Robot,
    history: Callable[[float], tuple[FloatArray, FloatArray]],
    duration_s: float,
    base_rate: FloatArray,
    rtol: float = 1e-11,
) -> Rotation:
    """Attitude of the base after `duration_s`, released at zero attitude turning at `base_rate`.

    `history(t)` gives joint angles and rates.
    """
    inertia, joints = inertia_and_momentum(robot, *history(0.0))
    total = inertia @ base_rate + joints

    def derivative(t: float, q: FloatArray) -> FloatArray:
        attitude = Rotation.from_quat(q)
        now, of_joints = inertia_and_momentum(robot, *history(t))
        x, y, z = np.linalg.solve(now, attitude.inv().apply(total) - of_joints)
        omega = np.array([[0, z, -y, x], [-z, 0, x, y], [y, -x, 0, z], [-x, -y, -z, 0]])
        return np.asarray(0.5 * omega @ q)

    solution = solve_ivp(
        # The attitude is compared to eleven digits.
        derivative,
        (0.0, duration_s),
        [0.0, 0.0, 0.0, 1.0],
        method="DOP853",
        rtol=rtol,
        atol=0.1 * rtol,
    )
    return Rotation.from_quat(solution.y[:, -1])
