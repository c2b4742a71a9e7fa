"""Begin and end of a motion: where the straight edges of its rate meet zero."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import FloatArray

FOOT, SHOULDER = 0.2, 0.8
"""Shares of the peak between which an edge is straight."""
_SMOOTHED = 3


@dataclass(frozen=True, slots=True)
class Edge:
    """Where the line through an edge meets zero.

    Attributes:
        t_s: On the samples' scale.
        std_s: Standard deviation by the scatter about the line; NaN with two samples on it.
        whole: The rate comes from below a fifth of its peak inside the samples; else it moved already at their end, and
            `t_s` is that end.
    """

    t_s: float
    std_s: float
    whole: bool


def average_neighbours(values: FloatArray) -> FloatArray:
    """(n,) means over three neighbours; the ends as they are."""
    if len(values) < _SMOOTHED:
        return values
    inner = np.convolve(values, np.full(_SMOOTHED, 1 / _SMOOTHED), mode="valid")
    return np.concatenate([values[:1], inner, values[-1:]])


def rising_edge(t_s: FloatArray, rate: FloatArray) -> Edge:
    """Find the first edge of a motion.

    Args:
        t_s: (n,) ascending.
        rate: (n,) of the motion, positive at its peak; any unit.
    """
    # Smooth only to find the edge; the line is fitted to raw samples, whose slope is not flattened.
    calm = average_neighbours(rate)
    peak = calm.max()
    shoulder = int(np.argmax(calm >= SHOULDER * peak))
    below = np.flatnonzero(calm[:shoulder] <= FOOT * peak)
    # In motion from the first sample on: the edge lies outside the data.
    if not len(below):
        return Edge(float(t_s[0]), float("nan"), whole=False)
    # Below the foot the low-pass has rounded the corner: those samples are not on the line.
    first = int(below[-1]) + 1
    if shoulder - first < 2:  # steeper than the samples lie: the foot helps
        first = int(below[-1])
    return _meets_zero(t_s[first : shoulder + 1], rate[first : shoulder + 1])


def falling_edge(t_s: FloatArray, rate: FloatArray) -> Edge:
    """Find the last edge of a motion; arguments as in `rising_edge`."""
    # Reversed in time, a falling edge is a rising one.
    mirrored = rising_edge(-t_s[::-1], rate[::-1])
    return Edge(-mirrored.t_s, mirrored.std_s, mirrored.whole)


def _meets_zero(t_s: FloatArray, rate: FloatArray) -> Edge:
    middle = float(t_s.mean())
    spread = float(((t_s - middle) ** 2).sum())
    slope = float((t_s - middle) @ rate) / spread
    if slope <= 0.0:  # a spike, of which the foot is as high as the shoulder
        return Edge(middle, float("nan"), whole=True)
    zero = -float(rate.mean()) / slope
    if len(t_s) < 3:
        return Edge(middle + zero, float("nan"), whole=True)
    off = rate - rate.mean() - slope * (t_s - middle)
    scatter = float(off @ off) / (len(t_s) - 2)
    # Variance of the zero crossing: that of the height, plus that of the slope over the distance.
    std = np.sqrt(scatter * (1.0 / len(t_s) + zero**2 / spread)) / abs(slope)
    return Edge(middle + zero, float(std), whole=True)
