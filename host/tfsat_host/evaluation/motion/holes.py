"""Where no gyro has a sample, and how far something may have turned there beside what was carried over."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

GAP_PERIODS = 1.5
"""A step longer than so many sampling periods has samples missing in it."""
_NEAR_S = 0.1


@dataclass(frozen=True, eq=False)
class Holes:
    """Of one rate.

    Attributes:
        from_s: (h,) last sample before each.
        until_s: (h,) first sample after it.
        variance: (h,) of the turn in it, rad^2.
    """

    from_s: FloatArray
    until_s: FloatArray
    variance: FloatArray

    def variance_between(self, left_s: FloatArray, right_s: FloatArray) -> FloatArray:
        """(k,) of all holes between times (k,)."""
        within = (self.from_s >= left_s[:, None] - 1e-9) & (self.until_s <= right_s[:, None] + 1e-9)
        return np.asarray((within * self.variance).sum(axis=1))


def holes_of(t_s: FloatArray, rate_rad_s: FloatArray, rate_hz: float) -> Holes:
    """Of a rate (n,) or (n, 3) whose integral is by straight lines between its samples.

    A rate that bends once in a hole g by its acceleration a is missed by a g^2 / 12; one that jumps from one side's
    value to the other's anywhere in it by their difference times g / sqrt(12).
    """
    steps = np.diff(t_s)
    first = np.flatnonzero(steps > GAP_PERIODS / rate_hz)
    rate = rate_rad_s.reshape(len(t_s), -1)
    slope = np.linalg.norm(np.diff(rate, axis=0), axis=1) / steps
    variance = []
    for gap in first:
        near = np.abs(t_s[:-1] - t_s[gap]) < _NEAR_S + steps[gap]
        jumped = slope[gap] * steps[gap] ** 2 / np.sqrt(12.0)
        bent = slope[near].max() * steps[gap] ** 2 / 12.0
        variance.append(max(jumped, bent) ** 2)
    return Holes(t_s[first], t_s[first + 1], np.array(variance))
