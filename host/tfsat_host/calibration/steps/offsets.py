"""Readings that were taken a little after their sample's time, told for that time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def at_sample_times(
    t_s: FloatArray,
    values: FloatArray,
    offset_s: FloatArray,
    valid: NDArray[np.bool_],
    *,
    angles: bool = False,
) -> FloatArray:
    """What each sensor showed at the samples' times: a reading less its offset times its slope.

    The slope is that between the neighbouring readings, so that the noise of a sample grows by (offset / period)^2 / 4
    of its variance at most. A sensor with fewer than two valid readings stays as it is.

    Args:
        t_s: (n,) the samples' times, increasing.
        values: (n, k, ...) of k sensors.
        offset_s: (k,) from a sample's time to each sensor's reading (LogHeader.imu_offset_us, angle_offset_us).
        valid: (n, k); others are left as they are, and no slope uses them.
        angles: The values are angles in [0, 2 pi), rad, and wrap.
    """
    moved = values.copy()
    for k in np.flatnonzero(offset_s):
        rows = np.flatnonzero(valid[:, k])
        if len(rows) > 1:
            shown = np.unwrap(values[rows, k], axis=0) if angles else values[rows, k]
            told = shown - offset_s[k] * np.gradient(shown, t_s[rows], axis=0)
            moved[rows, k] = told % (2 * np.pi) if angles else told
    return moved
