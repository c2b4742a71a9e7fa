"""Integrals over the samples of a drop, zero at the release."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def turned_from(t_s: FloatArray, rate_rad_s: FloatArray) -> FloatArray:
    """(n, ...) integral of rates by straight lines between samples, zero at the first sample after the release."""
    steps = 0.5 * (rate_rad_s[1:] + rate_rad_s[:-1]) * np.diff(t_s).reshape(-1, *[1] * (rate_rad_s.ndim - 1))
    total = np.concatenate([np.zeros((1, *rate_rad_s.shape[1:])), np.cumsum(steps, axis=0)])
    return np.asarray(total - total[int(np.searchsorted(t_s, 0.0))])
