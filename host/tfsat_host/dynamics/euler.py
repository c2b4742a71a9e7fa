"""Euler angles z-y-x: about z first, then about the turned y, then about the twice turned x."""

from __future__ import annotations

import numpy as np

from tfsat_host.arrays import FloatArray

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
    # In gimbal lock z takes all of the sum that is still defined.
    locked = cosine < _LOCKED
    z = np.where(locked, np.arctan2(-r[..., 0, 1], r[..., 1, 1]), np.arctan2(r[..., 1, 0], r[..., 0, 0]))
    x = np.where(locked, 0.0, np.arctan2(r[..., 2, 1], r[..., 2, 2]))
    return np.stack([z, y, x], axis=-1)


def euler_zyx_by_turn(rotation: FloatArray) -> FloatArray:
    """(..., 3, 3) by how much `euler_zyx_rad` of (..., 3, 3) grows with a small rotation vector in outer axes.

    Of Exp(v) R with v to zero: the inverse of v = z' e_z + y' (turned e_y) + x' (twice turned e_x), in closed form.
    The closer y comes to +-pi/2, the more z and x turn against each other; there x stays zero.
    """
    r = np.asarray(rotation, dtype=np.float64)
    cosine = np.hypot(r[..., 0, 0], r[..., 1, 0])
    locked = cosine < _LOCKED
    z = euler_zyx_rad(r)[..., 0]
    sin_z, cos_z = np.sin(z), np.cos(z)
    # In gimbal lock z and x would grow without bounds: what divides by the cosine is left out.
    per_cosine = np.where(locked, 0.0, 1.0 / np.where(locked, 1.0, cosine))
    sine = -r[..., 2, 0]
    zero, ones = np.zeros_like(z), np.ones_like(z)
    rows = (
        (cos_z * sine * per_cosine, sin_z * sine * per_cosine, ones),
        (-sin_z, cos_z, zero),
        (cos_z * per_cosine, sin_z * per_cosine, zero),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
