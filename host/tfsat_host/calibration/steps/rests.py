"""Where a motion from rest to rest rests."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SHORTEST_S = 0.35
SWEEP_SHARE = 0.08
"""A hand that rests trembles; at a sweep's rests gyro and angle sensors are averaged over the same samples."""
TURN_SHARE = 0.02
"""A turn's angle is known where it ends, not on the way there."""
_MARGIN_S = 0.1
"""Left out at either end: the low-pass settles."""


def find_rests(t_s: FloatArray, rate_rad_s: FloatArray, share: float = SWEEP_SHARE) -> list[slice]:
    """Stretches in which hardly anything turns, in order.

    Args:
        t_s: (n,) times.
        rate_rad_s: (n,) rate about the axis of the motion.
        share: Of the motion's speed; what is slower rests.
    """
    speed = np.abs(rate_rad_s)
    limit = max(np.deg2rad(1.5), share * float(np.quantile(speed, 0.95)))
    window = max(1, round(0.1 / float(np.median(np.diff(t_s)))))
    smooth = np.convolve(speed, np.full(window, 1.0 / window), mode="same")
    quiet = np.concatenate([[False], smooth < limit, [False]])
    edges = np.flatnonzero(np.diff(quiet.astype(np.int8)))
    rests = []
    for begin, end in zip(edges[::2], edges[1::2] - 1, strict=True):
        if t_s[end] - t_s[begin] >= SHORTEST_S + 2 * _MARGIN_S:
            inside = np.searchsorted(t_s, [t_s[begin] + _MARGIN_S, t_s[end] - _MARGIN_S])
            rests.append(slice(int(inside[0]), int(inside[1])))
    return rests
