"""The paper's objective: how far the averaged angular momentum strays from its first value.

The paper measures a model by how far the averaged angular momentum strays from its first value,

    J = sum over j of | hbar(t_j) - hbar(t_0) |        (paper, section Result)

with hbar the moving average of the momentum in inertial axes over N samples, a simple low-pass: 25 samples at 280 Hz
have the cutoff 5 Hz. Its cutoff is

    f_co = 0.443 f_s / sqrt(N^2 - 1),

where the average lets 1 / sqrt(2) of an amplitude pass (after S. W. Smith, The Scientist and Engineer's Guide to
Digital Signal Processing, 1997, chapter 15).

Samples are not quite even, and some are missing, so the average is one over time: a sample stands for the time up to
the middles between it and its neighbours, and the window is N mean sampling periods long. On an even grid that is the
mean of N samples, for odd N. Only whole windows count: the first and the last N / 2 samples have no average.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.evaluation.com_fit.momentum_residual import FallSamples, inertial_momentum

PAPER_SIZE = 25
# Of the cutoff f_co = 0.443 f_s / sqrt(N^2 - 1), see the text of this module.
_HALF_POWER = 0.443
_MIN_SHARE = 0.75
"""A window in which more than a quarter of the samples are missing has no average."""


@dataclass(frozen=True, eq=False)
class MovingAverage:
    """A moving average.

    Attributes:
        t_s: (k,) the sample times that have a whole window around them.
        values: (..., k, d).
        size: N.
        width_s: Of the window.
    """

    t_s: FloatArray
    values: FloatArray
    size: int
    width_s: float

    @property
    def cutoff_hz(self) -> float:
        """Where the average lets 1 / sqrt(2) pass; infinite for one sample."""
        return cutoff_hz(self.size, self.size / self.width_s)

    @property
    def strayed(self) -> FloatArray:
        """(..., k) distance from the first value."""
        return np.asarray(np.linalg.norm(self.values - self.values[..., :1, :], axis=-1))

    @property
    def objective(self) -> FloatArray:
        """(...) the paper's J: the sum of those, in the values' unit. It grows with the number of samples."""
        return np.asarray(self.strayed.sum(axis=-1))


def cutoff_hz(size: int, rate_hz: float) -> float:
    """Compute the cutoff frequency of the moving average over `size` samples; infinite for one.

    Raises:
        ValueError: `size` is below one.
    """
    if size < 1:
        raise ValueError(f"a moving average needs one sample or more, not {size}")
    return float("inf") if size == 1 else _HALF_POWER * rate_hz / float(np.sqrt(size**2 - 1.0))


def moving_average(t_s: FloatArray, values: FloatArray, size: int = PAPER_SIZE) -> MovingAverage:
    """Averages of values (..., m, d) at ascending times (m,), around every sample that has a whole window of `size`.

    Raises:
        ValueError: there are fewer than `size` samples, or `size` is below one.
    """
    if not 1 <= size <= len(t_s) or len(t_s) < 2:
        raise ValueError(f"an average over {size} samples needs as many, and two; there are {len(t_s)}")
    # The median step, which missing samples do not lengthen.
    period = float(np.median(np.diff(t_s)))
    middles = 0.5 * (t_s[1:] + t_s[:-1])
    edges = np.concatenate([[t_s[0] - 0.5 * period], middles, [t_s[-1] + 0.5 * period]])
    width = size * period
    low, high = t_s - 0.5 * width, t_s + 0.5 * width
    # Rounding must not cost the first and the last whole window.
    slack = 1e-6 * period
    is_full = (low >= edges[0] - slack) & (high <= edges[-1] + slack)
    # A whole window may still have too few samples in it.
    inside = np.searchsorted(t_s, high) - np.searchsorted(t_s, low)
    rows = np.flatnonzero(is_full & (inside >= _MIN_SHARE * size))
    # Sum up once: the integral over any window is then a difference of two interpolated sums.
    sums = np.concatenate(
        [np.zeros_like(values[..., :1, :]), np.cumsum(values * np.diff(edges)[:, None], axis=-2)], axis=-2
    )
    means = (_between(edges, sums, high[rows]) - _between(edges, sums, low[rows])) / width
    return MovingAverage(t_s[rows], means, size, width)


def averaged_momentum(body: Multibody, kinematics: FallSamples, size: int = PAPER_SIZE) -> MovingAverage:
    """Compute the moving average of the momentum by a model or a batch of models: kg m^2/s, inertial axes."""
    return moving_average(kinematics.t_s, inertial_momentum(body, kinematics), size)


def _between(edges: FloatArray, sums: FloatArray, at: FloatArray) -> FloatArray:
    """(..., k, d) of sums that grow in straight lines from edge to edge; beyond the ends by the last one's slope."""
    index = np.clip(np.searchsorted(edges, at, side="right") - 1, 0, len(edges) - 2)
    share = (at - edges[index]) / (edges[index + 1] - edges[index])
    return np.asarray(sums[..., index, :] + share[:, None] * (sums[..., index + 1, :] - sums[..., index, :]))
