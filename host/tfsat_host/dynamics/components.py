"""Linear algebra of very many very small vectors: components first, batch axes last.

A vector is an array (3, ...), a matrix (3, 3, ...): one pass of numpy over a component serves the whole
batch, which for thousands of 3 x 3 systems is many times faster than a loop of LAPACK calls.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tfsat_host.arrays import FloatArray


def batch_last(values: FloatArray, core_ndim: int = 1) -> FloatArray:
    """Moves the last `core_ndim` axes, in their order, to the front; the batch axes follow."""
    batch = values.ndim - core_ndim
    return values.transpose(*range(batch, values.ndim), *range(batch))


def batch_first(values: FloatArray, core_ndim: int = 1) -> FloatArray:
    """Move the batch axes to the front, the inverse of `batch_last`, in a new array."""
    return np.ascontiguousarray(values.transpose(*range(core_ndim, values.ndim), *range(core_ndim)))


def pad(values: FloatArray, core_ndim: int, batch_ndim: int) -> FloatArray:
    """Adds batch axes of length 1 behind the core axes, up to `batch_ndim`."""
    missing = batch_ndim - (values.ndim - core_ndim)
    return values.reshape(values.shape[:core_ndim] + (1,) * missing + values.shape[core_ndim:])


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Compute the cross product a x b: (3, ...)."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]
    return out


def dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Compute the dot product a . b: (...)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def matmul(a: FloatArray, b: FloatArray) -> FloatArray:
    """Compute the matrix product A B: (3, 3, ...)."""
    # Three outer products, each one pass over the whole batch.
    product = a[:, 0, None] * b[None, 0]
    product += a[:, 1, None] * b[None, 1]
    product += a[:, 2, None] * b[None, 2]
    return product


def matvec(a: FloatArray, v: FloatArray) -> FloatArray:
    """Compute the matrix-vector product A v: (3, ...)."""
    return np.asarray(a[:, 0] * v[0] + a[:, 1] * v[1] + a[:, 2] * v[2])


def transpose(a: FloatArray) -> FloatArray:
    """A^T: (3, 3, ...)."""
    return a.swapaxes(0, 1)


def rotated_tensor(rotation: FloatArray, tensor: FloatArray) -> FloatArray:
    """R T R^T: (3, 3, ...)."""
    return matmul(matmul(rotation, tensor), transpose(rotation))


def rotation_about(axis: FloatArray, angle: FloatArray) -> FloatArray:
    """Rotation (3, 3, ...) by `angle` (...) about the unit vector `axis` (3, ...): Rodrigues' formula."""
    sine, cosine = np.sin(angle), np.cos(angle)
    # (1 - cos) a a^T, then cos on the diagonal and sin off it, with the signs of the cross product.
    out = axis[:, None] * ((1.0 - cosine) * axis)[None, :]
    turn = sine * axis
    for i in range(3):
        out[i, i] += cosine
        k, m = (i + 1) % 3, (i + 2) % 3
        out[k, m] -= turn[i]
        out[m, k] += turn[i]
    return out


def point_tensor(offset: FloatArray) -> FloatArray:
    """Inertia (3, 3, ...) of a unit mass at `offset` (3, ...) about the origin: d.d 1 - d d^T."""
    out = -offset[:, None] * offset[None, :]
    squared = dot(offset, offset)
    for i in range(3):
        out[i, i] += squared
    return out


def solve_symmetric(
    tensor: Sequence[FloatArray] | FloatArray, vector: Sequence[FloatArray] | FloatArray
) -> FloatArray:
    """x (3, ...) of A x = v for a regular A, given as xx, xy, xz, yy, yz, zz: an inertia is never near singular."""
    xx, xy, xz, yy, yz, zz = tensor
    x, y, z = vector
    # Cramer's rule: a symmetric adjugate has six cofactors, and three of them give the determinant.
    cxx, cxy, cxz = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    scale = 1.0 / (xx * cxx + xy * cxy + xz * cxz)
    cyy, cyz, czz = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    out = np.empty((3, *np.broadcast_shapes(scale.shape, np.shape(x))))
    out[0] = (cxx * x + cxy * y + cxz * z) * scale
    out[1] = (cxy * x + cyy * y + cyz * z) * scale
    out[2] = (cxz * x + cyz * y + czz * z) * scale
    return out


def upper(tensor: FloatArray) -> tuple[FloatArray, ...]:
    """xx, xy, xz, yy, yz, zz of a symmetric (3, 3, ...)."""
    return tensor[0, 0], tensor[0, 1], tensor[0, 2], tensor[1, 1], tensor[1, 2], tensor[2, 2]
