"""Covariances and rotations of a certificate: in people's units, and checked for being what they are called."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.certificate.entries import Entry

FloatArray = NDArray[np.float64]

RAD_PER_DEG = np.pi / 180.0
ROUNDING = 1e-6
"""So far may a number that a person copied differ from what follows from another: more digits say nothing."""


def covariance(entry: Entry, key: str, to_si: FloatArray, std: FloatArray | None = None) -> FloatArray:
    """A covariance in SI units.

    Args:
        entry: Where it stands.
        key: Under which name.
        to_si: (n,) what one unit of each quantity is in SI.
        std: (n,) standard deviations that the file states for people, in the file's units: they must agree.

    Raises:
        CalibrationError: wrong shape, not symmetric, not positive, or it disagrees with `std`.
    """
    written = entry.array(key, (len(to_si), len(to_si)))
    variances = np.diag(written)
    if (variances < 0.0).any():
        entry.fail(key, f"the covariance in {entry.label} has a negative variance")
    size = np.sqrt(np.outer(variances, variances))
    if (np.abs(written - written.T) > ROUNDING * size).any():
        entry.fail(key, f"the covariance in {entry.label} is not symmetric")
    scaled = np.divide(written, size, out=np.zeros_like(written), where=size > 0.0)
    if (written[size == 0.0] != 0.0).any() or np.linalg.eigvalsh(scaled).min() < -ROUNDING:
        entry.fail(key, f"the covariance in {entry.label} is not positive: no errors can vary like that")
    if std is not None:
        check_std(entry, std, np.sqrt(variances))
    symmetric = (written + written.T) / 2.0
    return np.asarray(symmetric * np.outer(to_si, to_si))


def check_std(entry: Entry, stated: FloatArray, derived: FloatArray) -> None:
    """Refuses a std beside a value that is not the covariance's: one of them was changed by hand.

    Raises:
        CalibrationError: they differ.
    """
    if not np.allclose(stated, derived, rtol=ROUNDING, atol=0.0):
        entry.fail(
            "std",
            f"std of {entry.label} is not what its covariance says "
            f"({' '.join(f'{value:.6g}' for value in np.atleast_1d(derived))})",
        )


def rotation(entry: Entry, key: str) -> FloatArray:
    """(3, 3) proper rotation.

    Raises:
        CalibrationError: it is none: rows not orthogonal, not of length 1, or mirrored.
    """
    matrix = entry.array(key, (3, 3))
    if np.abs(matrix @ matrix.T - np.eye(3)).max() > ROUNDING:
        entry.fail(key, f"{entry.label} is no rotation: its rows are not perpendicular and of length 1")
    if np.linalg.det(matrix) < 0.0:
        entry.fail(key, f"{entry.label} is no rotation but a mirror: two of its rows may be exchanged")
    return matrix
