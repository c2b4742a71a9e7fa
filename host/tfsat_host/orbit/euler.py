"""z-y-x Euler angles of quaternions and back: turn about z, then about the new y, then about the newest x."""

from __future__ import annotations

import numpy as np

from tfsat_host.dynamics import euler, quaternion
from tfsat_host.dynamics.components import FloatArray
from tfsat_host.dynamics.multibody import batch_first, batch_last


def euler_zyx_rad(quaternion_xyzw: FloatArray) -> FloatArray:
    """Angles (..., 3) about z, y and x, in this order, of quaternions (..., 4)."""
    matrix = quaternion.to_matrix(batch_last(np.asarray(quaternion_xyzw, dtype=np.float64)))
    return euler.euler_zyx_rad(batch_first(matrix, 2))


def quaternion_of_euler_zyx(angles_rad: FloatArray) -> FloatArray:
    """Quaternions (..., 4) of angles (..., 3) about z, y and x."""
    angles = batch_last(np.asarray(angles_rad, dtype=np.float64))
    about_z, about_y, about_x = (
        quaternion.exponential(np.multiply.outer(axis, angle))
        for axis, angle in zip(np.eye(3)[::-1], angles, strict=True)
    )
    return batch_first(quaternion.product(quaternion.product(about_z, about_y), about_x))
