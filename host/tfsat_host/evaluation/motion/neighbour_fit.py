"""The slow errors by the gyros among themselves: four measure twelve numbers of a motion that has six."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.motion.fusion import Fused

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_BLOCK_S = 0.1
"""Means over so long are compared with their noise."""
_LEAST_EXCESS = 4.0
"""Neighbours never count for more than with twice their noise: frames give, and what two moments leave of a low-pass
hangs together over a servo's ramp. Emulated robots without a calibration had their offsets' errors understated by 1.6
without it, and by 1.1 with it."""


def information_by_neighbours(
    t_s: FloatArray,
    fused: Fused,
    left_by_errors: FloatArray,
    variance: FloatArray,
    errors: FloatArray,
    learnt: BoolArray,
) -> tuple[FloatArray, FloatArray]:
    """(r, r) information on the errors in the fall, and (r,) the right-hand side to go with it.

    What no motion of the robot explains would be noise, were the errors right. Where more is left, frames that give or
    chips that are read at different times have their part in it, and all of it counts that much less.

    Args:
        t_s: (n,) after the release; what comes before it tells nothing.
        fused: Rates with the errors as believed.
        left_by_errors: (n, 4, 3, r) what more of them does to what is left over.
        variance: (n, 4) of each axis of a gyro's sample.
        errors: (r,) as believed.
        learnt: (r,) which ones may be told.
    """
    fall = t_s >= 0.0
    n, r = int(fall.sum()), len(errors)
    bridged = fused.bridged[fall]
    weights = np.where(bridged, 0.0, 1.0 / np.sqrt(variance[fall]))[..., None]
    left = (np.nan_to_num(fused.left_over_rad_s[fall]) * weights).reshape(n, -1)
    rows = (left_by_errors[fall] * weights[..., None]).reshape(n * left.shape[1], r) * learnt
    told = float((~bridged).sum(axis=1).mean()) * 3.0
    unexplained = max(told - fused.base_rate_rad_s.shape[1] - fused.joint_rate_rad_s.shape[1], 0.0)
    if unexplained == 0.0:
        return np.zeros((r, r)), np.zeros(r)
    excess = max(_LEAST_EXCESS, _block_squares(t_s[fall], left) / unexplained)
    information = rows.T @ rows / excess
    return information, information @ errors - rows.T @ left.ravel() / excess


def _block_squares(t_s: FloatArray, whitened: FloatArray) -> float:
    """What the squares of a block's sum come to, one sample's variance taken as one."""
    edges = np.flatnonzero(np.diff(np.floor(t_s / _BLOCK_S), prepend=-np.inf))
    counts = np.diff(edges, append=len(t_s))
    sums = np.add.reduceat(whitened, edges, axis=0) / np.sqrt(counts)[:, None]
    return float((sums**2).sum(axis=1).mean())
