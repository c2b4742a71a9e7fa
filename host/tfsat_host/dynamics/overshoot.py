"""Where a spline through samples leaves them: what lies between two samples should not lie far beyond both."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tfsat_host.dynamics.components import FloatArray
from tfsat_host.dynamics.history import JointHistory


class Overshoot(NamedTuple):
    """How far a joint leaves the samples on both sides at most, and when.

    Attributes:
        joint: Index of the joint.
        excess_rad: Beyond the nearer of the two samples; 0 where it stays between them.
        t_s: When.
    """

    joint: int
    excess_rad: float
    t_s: float


def overshoots(history: JointHistory) -> list[Overshoot]:
    """The greatest excursion of each joint between two breaks, from the extrema of the pieces.

    Args:
        history: Of degree 3 at most.

    Raises:
        ValueError: the pieces are of a higher degree.
    """
    degree = len(history.coefficients) - 1
    if degree > 3:
        raise ValueError(f"pieces of degree {degree} are not searched for extrema")
    cubic, square, linear, start = np.concatenate(
        [np.zeros((3 - degree, *history.coefficients.shape[1:])), history.coefficients]
    )
    span = np.diff(history.breaks_s)[:, None]

    def at(since: FloatArray) -> FloatArray:
        return np.asarray(((cubic * since + square) * since + linear) * since + start)

    ends = np.sort([start, at(np.broadcast_to(span, start.shape))], axis=0)
    since = _stationary(3.0 * cubic, square, linear, span)
    values = at(since)
    excess = np.maximum(values - ends[1], ends[0] - values)  # (2, k, n - 1), -inf to 0 between the samples
    found = []
    for joint in range(start.shape[1]):
        root, piece = np.unravel_index(int(excess[:, :, joint].argmax()), excess.shape[:2])
        t_s = history.breaks_s[piece] + since[root, piece, joint]
        found.append(Overshoot(joint, max(0.0, float(excess[root, piece, joint])), float(t_s)))
    return found


def _stationary(a: FloatArray, b: FloatArray, c: FloatArray, span: FloatArray) -> FloatArray:
    """Both roots (2, ...) of a t^2 + 2 b t + c within (0, span); 0 where there is none."""
    with np.errstate(divide="ignore", invalid="ignore"):
        q = -(b + np.copysign(np.sqrt(b * b - a * c), b))
        roots = np.stack([q / a, c / q])
        return np.where((roots > 0.0) & (roots < span), roots, 0.0)
