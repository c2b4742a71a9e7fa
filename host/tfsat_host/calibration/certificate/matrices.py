"""Covariances and rotations of a certificate, checked for being what they are called."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.config import Table

FloatArray = NDArray[np.float64]

ROUNDING = 1e-6
"""So far may a number that a person copied differ from what follows from another: more digits say nothing."""


def covariance(entry: Table, key: str, written: FloatArray) -> FloatArray:
    """The covariance (n, n) that `key` has, exactly symmetric.

    Raises:
        CalibrationError: it is not symmetric, or not positive.
    """
    variances = np.diag(written)
    if (variances < 0.0).any():
        entry.fail(key, "the covariance has a negative variance")
    size = np.sqrt(np.outer(variances, variances))
    if (np.abs(written - written.T) > ROUNDING * size).any():
        entry.fail(key, "the covariance is not symmetric")
    scaled = np.divide(written, size, out=np.zeros_like(written), where=size > 0.0)
    if (written[size == 0.0] != 0.0).any() or np.linalg.eigvalsh(scaled).min() < -ROUNDING:
        entry.fail(key, "the covariance is not positive: no errors can vary like that")
    return np.asarray((written + written.T) / 2.0)


def check_std(entry: Table, key: str, stated: FloatArray, derived: FloatArray) -> None:
    """Refuses a std that is not the covariance's: one of them was changed by hand; both in the file's units.

    Raises:
        CalibrationError: they differ.
    """
    if not np.allclose(stated, derived, rtol=ROUNDING, atol=0.0):
        shown = " ".join(f"{value:.6g}" for value in np.atleast_1d(derived))
        entry.fail(key, f"is not what its covariance says ({shown})")


def check_rotation(entry: Table, key: str, matrix: FloatArray) -> None:
    """Refuses a matrix (3, 3) that is no proper rotation.

    Raises:
        CalibrationError: its rows are not orthogonal, not of length 1, or mirrored.
    """
    if np.abs(matrix @ matrix.T - np.eye(3)).max() > ROUNDING:
        entry.fail(key, "is no rotation: its rows are not perpendicular and of length 1")
    if np.linalg.det(matrix) < 0.0:
        entry.fail(key, "is no rotation but a mirror: two of its rows may be exchanged")
