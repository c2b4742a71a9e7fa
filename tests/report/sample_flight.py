"""The motion behind the sample documents: strokes, attitude by the model, poses of the bodies."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tfsat_host.dynamics import Multibody, poses, propagate, sampled
from tfsat_host.robot import RobotModel

Array = NDArray[np.float64]

STROKES = ((0, 59.0, 0.70, 1.05), (1, 70.0, 1.05, 1.47), (0, -59.0, 1.47, 1.82), (1, -70.0, 1.82, 2.23))
"""Joint, angle in deg, start and end in s."""


def angles_rad(t_s: Array, scale: Array) -> Array:
    """(m, 3): each stroke an S-curve that overshoots a little; joint 3 stays shut."""
    angles = np.zeros((len(t_s), 3))
    for (joint, delta_deg, start_s, end_s), stretched in zip(STROKES, scale, strict=True):
        share = np.clip((t_s - start_s) / (end_s - start_s), 0, 1)
        late = np.clip(t_s - end_s, 0, None)
        ripple = 0.012 * np.sin(2 * np.pi * 9 * late) * np.exp(-12 * late)
        angles[:, joint] += np.radians(delta_deg) * (stretched * share**2 * (3 - 2 * share) + ripple)
    return angles


def flight(robot: RobotModel, t_s: Array, angles: Array, initial_rad_s: Array) -> tuple[Rotation, Array]:
    """Attitude of the base at each time, and its rate (m, 3)."""
    flown = propagate(
        Multibody.of(robot), sampled(t_s, angles, between="linear"), initial_rate_rad_s=initial_rad_s
    )
    attitude = Rotation.from_quat(flown.quaternion_xyzw)
    at = np.clip(np.searchsorted(flown.t_s, t_s), 0, len(flown.t_s) - 1)
    return attitude[at], flown.rate_rad_s[at]


def replay(
    robot: RobotModel,
    t_s: Array,
    angles: Array,
    measured: tuple[Rotation, Array],
    model: tuple[Rotation, Array],
) -> dict[str, Any]:
    bodies = [
        {"name": name, "boxes_m": [[c.min(0).tolist(), c.max(0).tolist()] for c in shape.reshape(-1, 8, 3)]}
        for name, shape in zip(robot.body_names, robot.shape_m, strict=True)
    ]
    return {
        "bodies": bodies,
        "t_s": t_s.tolist(),
        "measured": _poses(robot, angles, measured[0]),
        "model": _poses(robot, angles, model[0]),
    }


def _poses(robot: RobotModel, angles: Array, attitude: Rotation) -> list[list[list[float]]]:
    """(m, bodies, 7): positions about the robot's center of mass, which stays where it is."""
    rotation, translation = poses(Multibody.of(robot), angles)
    share = robot.mass_kg / robot.mass_kg.sum()
    centers = np.einsum("mbij,bj->mbi", rotation, robot.origin_m + robot.com_m) + translation
    origins = np.einsum("mbij,bj->mbi", rotation, robot.origin_m) + translation
    origins -= np.einsum("b,mbi->mi", share, centers)[:, None]
    base = attitude.as_matrix()
    count = len(share)
    quaternions = [(attitude * Rotation.from_matrix(rotation[:, body])).as_quat() for body in range(count)]
    placed = np.einsum("mij,mbj->mbi", base, origins)
    rows: list[list[list[float]]] = np.concatenate([placed, np.stack(quaternions, axis=1)], axis=2).tolist()
    return rows
