"""The last seconds in the releaser, before the release: what gyros show of a robot that hangs still.

That is their noise, and their biases for want of a calibration; `checks.hanging` holds all sensors against theirs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.motion.noise import noise_densities
from tfsat_host.sdlog import DropLog

FloatArray = NDArray[np.float64]

LONGEST_S = 30.0
"""Earlier, the crane and hands may still have been at the robot."""
LEAST_S = 1.0
GUARD_S = 0.3
"""So long before the release the burning wire and the hook may already move the robot."""
STILL_RAD_S = np.deg2rad(0.3)
"""A block whose mean is farther from the median of all saw something move: a servo that was armed, a knock."""
HANGING_STD_RAD_S = np.deg2rad(0.02)
"""A robot on a magnet is not bolted to the ground: slow swings leave so much in any mean."""
_BLOCK_S = 0.25
_LEAST_SHARE = 0.5
"""If more of the blocks moved, the robot swung, and its median is no bias."""


@dataclass(frozen=True, eq=False)
class Rest:
    """What the gyros showed.

    Attributes:
        duration_s: How long it was.
        rate_rad_s: (4, 3) mean of each gyro, sensor axes: its bias, if nothing moved. NaN where it did not rest.
        rate_std_rad_s: (4, 3) standard deviation of that mean.
        densities_rad_s_rthz: (4,) one-sided noise density.
    """

    duration_s: float
    rate_rad_s: FloatArray
    rate_std_rad_s: FloatArray
    densities_rad_s_rthz: FloatArray


def rest_before_release(log: DropLog) -> Rest:
    """Reads it from a drop; without a rest everything is NaN, and the noise is the data sheet's."""
    rows = np.flatnonzero((log.t_s >= -LONGEST_S) & (log.t_s < -GUARD_S))
    if log.release is None or len(rows) < 2:
        rows = np.zeros(0, np.int64)
    t_s, rates = log.t_s[rows], log.rate_rad_s[rows]
    means = _block_means(t_s, rates)
    still = np.full(rates.shape[1:], np.nan)
    spread = still.copy()
    for gyro in range(means.shape[1]):
        known = means[np.isfinite(means[:, gyro]).all(axis=1), gyro]
        if len(known) * _BLOCK_S < LEAST_S:
            continue
        kept = known[(np.abs(known - np.median(known, axis=0)) < STILL_RAD_S).all(axis=1)]
        if len(kept) >= _LEAST_SHARE * len(known):
            still[gyro] = kept.mean(axis=0)
            spread[gyro] = np.hypot(kept.std(axis=0, ddof=1) / np.sqrt(len(kept)), HANGING_STD_RAD_S)
    duration_s = float(t_s[-1] - t_s[0]) if len(t_s) else 0.0
    return Rest(duration_s, still, spread, noise_densities(t_s, rates))


def _block_means(t_s: FloatArray, rates: FloatArray) -> FloatArray:
    """(blocks, 4, 3)."""
    if not len(t_s):
        return np.zeros((0, *rates.shape[1:]))
    edges = np.flatnonzero(np.diff(np.floor((t_s - t_s[-1]) / _BLOCK_S), prepend=-np.inf))
    counts = np.diff(edges, append=len(t_s))
    return np.asarray(np.add.reduceat(rates, edges, axis=0) / counts[:, None, None])
