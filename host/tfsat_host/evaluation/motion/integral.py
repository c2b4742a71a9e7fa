"""Integrals over the samples of a drop, from the release on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def turned_from(t_s: FloatArray, rate_rad_s: FloatArray) -> FloatArray:
    """(n, ...) integral of rates by straight lines between samples, zero up to the first sample after the release.

    Servos hold the joints until then: no gyro, of another bias while it hangs, is asked whether they stand.
    """
    steps = 0.5 * (rate_rad_s[1:] + rate_rad_s[:-1]) * np.diff(t_s).reshape(-1, *[1] * (rate_rad_s.ndim - 1))
    total = np.concatenate([np.zeros((1, *rate_rad_s.shape[1:])), np.cumsum(steps, axis=0)])
    released = int(np.searchsorted(t_s, 0.0))
    total = total - total[released]
    total[:released] = 0.0
    return np.asarray(total)
