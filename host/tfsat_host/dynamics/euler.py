"""Euler angles z-y-x: about z first, then about the turned y, then about the twice turned x."""

from __future__ import annotations

import numpy as np

from tfsat_host.dynamics.components import FloatArray

# With y this close to 90 deg, z and x turn about the same axis and rounding alone would divide them.
_LOCKED = 1e-9


def euler_zyx_rad(rotation: FloatArray) -> FloatArray:
    """Angles (..., 3) about z, y, x of rotation matrices (..., 3, 3): R = Rz Ry Rx.

    z and x lie in -pi to pi, y in -pi/2 to pi/2. At y = +-pi/2 only a sum of the other two is defined: then
    x is zero.
    """
    r = np.asarray(rotation, dtype=np.float64)
    cosine = np.hypot(r[..., 0, 0], r[..., 1, 0])
    y = np.arctan2(-r[..., 2, 0], cosine)
    locked = cosine < _LOCKED
    z = np.where(locked, np.arctan2(-r[..., 0, 1], r[..., 1, 1]), np.arctan2(r[..., 1, 0], r[..., 0, 0]))
    x = np.where(locked, 0.0, np.arctan2(r[..., 2, 1], r[..., 2, 2]))
    return np.stack([z, y, x], axis=-1)
