"""Unit quaternions (4, ...), components first, scalar last: (x, y, z, w) as scipy has them."""

from __future__ import annotations

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.components import batch_first, batch_last, cross, dot

# Below this angle the series of sin(x)/x is exact to the last bit with three terms.
_SMALL_RAD = 1e-2


def identity(shape: tuple[int, ...] = ()) -> FloatArray:
    """(4, *shape), no rotation."""
    out = np.zeros((4, *shape))
    out[3] = 1.0
    return out


def product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Compute the quaternion product a b, (4, ...).

    It is the rotation `b` followed by `a`, in the axes before `b`.
    """
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[0] = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1]
    out[1] = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0]
    out[2] = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3]
    out[3] = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]
    return out


def inverse(q: FloatArray) -> FloatArray:
    """Return the inverse rotation, (4, ...)."""
    out = -q
    out[3] = q[3]
    return out


def exponential(vector: FloatArray) -> FloatArray:
    """Quaternion (4, ...) of the rotation vector (3, ...), rad."""
    squared = vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]
    half = 0.5 * np.sqrt(squared)
    small = half < _SMALL_RAD
    # Both branches are computed everywhere; where the quotient is not taken, it may divide by zero.
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = np.where(
            small, 0.5 - squared / 48.0 + squared * squared / 3840.0, np.sin(half) / (2.0 * half)
        )
    out = np.empty((4, *vector.shape[1:]))
    out[:3] = scale * vector
    out[3] = np.cos(half)
    return out


def logarithm(q: FloatArray) -> FloatArray:
    """Rotation vector (3, ...) of the shorter way round, rad, at most pi long."""
    # q and -q are one rotation: the one with w >= 0 goes the shorter way round.
    sign = np.where(q[3] < 0.0, -1.0, 1.0)
    sine = np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2])
    # arctan2 keeps all digits near zero and near half a turn, where arccos and arcsin lose some.
    half = np.arctan2(sine, np.abs(q[3]))
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = np.where(sine < 1e-8, 2.0, 2.0 * half / sine)
    return np.asarray(scale * sign * q[:3])


def inverse_differential(turn: FloatArray, rate: FloatArray) -> FloatArray:
    """Derivatives (3, ...) of rotation vectors `turn` (3, ...) of R0 exp(turn) that turn at body rates (3, ...)."""
    # The coefficient (1 - x/2 cot(x/2)) / x^2, for small turns by its series, where digits cancel.
    squared = dot(turn, turn)
    small = squared < 1e-4
    half = 0.5 * np.sqrt(np.where(small, 1.0, squared))
    factor = np.where(
        small,
        1.0 / 12.0 + squared / 720.0 + squared * squared / 30240.0,
        (1.0 - half / np.tan(half)) / (4.0 * half * half),
    )
    around = cross(turn, rate)
    return np.asarray(rate + 0.5 * around + factor * cross(turn, around))


def angle(q: FloatArray) -> FloatArray:
    """Rotation angle (...), 0 to pi."""
    return np.asarray(2.0 * np.arctan2(np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]), np.abs(q[3])))


def to_matrix(q: FloatArray) -> FloatArray:
    """Rotation matrix (3, 3, ...) of a unit quaternion."""
    x, y, z, w = q
    out = np.empty((3, 3, *q.shape[1:]))
    out[0, 0], out[1, 1], out[2, 2] = (
        1 - 2 * (y * y + z * z),
        1 - 2 * (x * x + z * z),
        1 - 2 * (x * x + y * y),
    )
    out[0, 1], out[1, 0] = 2 * (x * y - z * w), 2 * (x * y + z * w)
    out[0, 2], out[2, 0] = 2 * (x * z + y * w), 2 * (x * z - y * w)
    out[1, 2], out[2, 1] = 2 * (y * z - x * w), 2 * (y * z + x * w)
    return out


def rotation_vector_rad(quaternion_xyzw: FloatArray) -> FloatArray:
    """Rotation vectors (..., 3), rad, of quaternions (..., 4), the shorter way round."""
    return batch_first(logarithm(batch_last(np.asarray(quaternion_xyzw, dtype=np.float64))))


def rotation_angle_rad(quaternion_xyzw: FloatArray) -> FloatArray:
    """Rotation angles (...), 0 to pi, of quaternions (..., 4)."""
    return angle(batch_last(np.asarray(quaternion_xyzw, dtype=np.float64)))
