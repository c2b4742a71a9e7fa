"""How much of what the gyros show is noise: at rest, and while a joint speeds up."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.evaluation.motion.lag import derivative

FloatArray = NDArray[np.float64]

BLOCK_S = 0.1
"""Longer than any low-pass remembers: means over blocks are as independent as those of white noise."""
_DENSITY_BLOCK_S = 0.25
"""Of a density: means over 0.1 s of what the 5 Hz low-pass lets through scatter by a sixth less than white noise's."""
LEAST_BLOCKS = 10
AGE_SHARE = 0.4
"""Ages of successive readings run evenly through the chip's output period, so in an integral they nearly cancel: over a
servo's ramp of a dozen samples this share of what independent ages would do is left."""
SHEET_DENSITY_RAD_S_RTHZ = np.deg2rad(0.005)
"""One-sided (PS-MPU-6000A rev. 3.4, section 6.1)."""


def noise_densities(t_s: FloatArray, rate_rad_s: FloatArray) -> FloatArray:
    """(4,) one-sided noise density of each gyro, rad/s/sqrt(Hz), from a rest; the data sheet's without one.

    By the differences of means over neighbouring blocks, so that a robot that sways slowly on its magnet does not
    count: the median tells, so that a knock does not either. The mean over T of white noise of density N has the
    variance N^2 / 2T.

    Args:
        t_s: (n,) samples of a rest.
        rate_rad_s: (n, 4, 3); NaN where a gyro did not answer.
    """
    if len(t_s) < 2:
        return np.full(rate_rad_s.shape[1], SHEET_DENSITY_RAD_S_RTHZ)
    blocks = np.floor((t_s - t_s[0]) / _DENSITY_BLOCK_S).astype(int)
    edges = np.flatnonzero(np.diff(blocks, prepend=-1))
    if len(edges) < LEAST_BLOCKS:
        return np.full(rate_rad_s.shape[1], SHEET_DENSITY_RAD_S_RTHZ)
    counts = np.diff(edges, append=len(t_s))
    means = np.add.reduceat(rate_rad_s, edges, axis=0) / counts[:, None, None]
    squares = (np.diff(means, axis=0) / np.sqrt(2.0)) ** 2
    return np.array([_density(squares[:, gyro]) for gyro in range(rate_rad_s.shape[1])])


def _density(squares: FloatArray) -> float:
    """From (blocks, 3) variances of a block's mean, one each; NaN where the gyro did not answer."""
    known = squares[np.isfinite(squares)]
    if len(known) < 3 * LEAST_BLOCKS or not known.any():
        return float(SHEET_DENSITY_RAD_S_RTHZ)
    # The median of a squared normal deviate is 0.4549 of its variance.
    return float(np.sqrt(2.0 * _DENSITY_BLOCK_S * np.median(known) / 0.4549))


def sample_variance(
    densities: FloatArray, t_s: FloatArray, rate_rad_s: FloatArray, rate_hz: float, low_pass: LowPass
) -> FloatArray:
    """(n, 4) variance of a gyro's sample that white noise of the same effect would have, (rad/s)^2.

    The noise itself, and that of the reading's age: a reading is between nothing and one output period of the chip old,
    which matters while the rate changes.

    Args:
        densities: (4,) one-sided.
        t_s: (n,).
        rate_rad_s: (n, 4, 3), no NaN.
        rate_hz: Sampling rate.
        low_pass: Of the gyros.
    """
    age_variance = (AGE_SHARE * low_pass.output_period_s) ** 2 / 12.0
    change = (derivative(t_s, rate_rad_s) ** 2).sum(axis=2) / 3.0
    return np.asarray(0.5 * rate_hz * densities**2 + age_variance * change)
