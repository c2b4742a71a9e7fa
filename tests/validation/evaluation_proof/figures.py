"""Figures of many errors together."""

from __future__ import annotations

import numpy as np

from tests.validation.calibration_proof.robots import Errors
from tfsat_host.arrays import FloatArray

COVERED = (0.90, 0.99)
"""So often must a 95 % interval hold the truth."""
_NORMAL_95 = 1.959964


def rms(values: FloatArray) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def z_rms(errors: Errors) -> float:
    """Return the root mean square of the errors in their own standard deviations."""
    return rms(errors.error / errors.std)


def covered_share(errors: Errors) -> float:
    """Return the share of the values whose 95 % interval holds the truth."""
    return float((np.abs(errors.error) < _NORMAL_95 * errors.std).mean())


def percent(share: float) -> str:
    """Return a share in percent, to a tenth, without a sign."""
    return f"{100.0 * share:.1f}"


def figures(errors: Errors, digits: int = 4) -> tuple[str, ...]:
    """Return rms, largest, median of the stated std, z, and how often the interval holds the truth."""
    return (
        f"{rms(errors.error):.{digits}f}",
        f"{np.abs(errors.error).max():.{digits}f}",
        f"{np.median(errors.std):.{digits}f}",
        f"{z_rms(errors):.2f}",
        percent(covered_share(errors)),
    )
