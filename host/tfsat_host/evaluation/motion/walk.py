"""How the integral of a joint's rate wanders off: the gyros' noise, holes, and where no gyro tells the rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.motion.holes import Holes

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

KNOT_S = 0.2
"""The random walk of an integrated rate is followed so finely."""


@dataclass(frozen=True, eq=False)
class Walk:
    """One joint's, as independent steps from knot to knot.

    Attributes:
        angle: (n, k) what a step of one standard deviation adds to the angle.
        rate: (n, k) and to the rate, where that follows from the angle sensors; else the noise of a sample counts.
    """

    angle: FloatArray
    rate: FloatArray


def walk_of(
    t_s: FloatArray,
    density_rad_s_rthz: float,
    untold: BoolArray,
    sensed_std_rad: float,
    fine_s: float,
    holes: Holes,
) -> Walk:
    """Of one joint.

    Args:
        t_s: (n,) after the release, where the walk begins.
        density_rad_s_rthz: One-sided noise density of the joint's rate by its gyros.
        untold: (n,) the rate is the angle sensors' slope.
        sensed_std_rad: How far the integral of that slope may be off, from one knot to the next.
        fine_s: The slope is smoothed over so long: knots are so far apart where it is used.
        holes: Where samples are missing, with what the joint may have turned in them beside what was carried over.
    """
    knots = _knots(t_s, untold, fine_s, holes)
    left, right = knots[:-1], knots[1:]
    angle = np.clip((t_s[:, None] - left) / (right - left), 0.0, 1.0)
    by_slope = np.interp(0.5 * (left + right), t_s, untold.astype(float)) > 0.5
    variance = 0.5 * density_rad_s_rthz**2 * (right - left)
    variance = variance + np.where(by_slope, sensed_std_rad**2, 0.0)
    variance = variance + holes.variance_between(left, right)
    step = np.sqrt(variance)
    inside = (t_s[:, None] >= left) & (t_s[:, None] < right) & by_slope
    return Walk(angle * step, np.where(inside, step / (right - left), 0.0))


def _knots(t_s: FloatArray, untold: BoolArray, fine_s: float, holes: Holes) -> FloatArray:
    coarse = np.arange(0.0, t_s[-1] + KNOT_S, KNOT_S)
    fine = np.arange(0.0, t_s[-1], fine_s)
    fine = fine[np.interp(fine, t_s, untold.astype(float)) > 0.0]
    inner = np.concatenate([coarse, fine])
    in_hole = (inner[:, None] > holes.from_s) & (inner[:, None] < holes.until_s)
    edges = np.concatenate([holes.from_s, holes.until_s])
    knots = np.unique(np.concatenate([[0.0], inner[~in_hole.any(axis=1)], edges[edges > 0.0]]))
    # A knot just beside another would make a step that no sample can tell from it.
    return np.asarray(knots[np.concatenate([[True], np.diff(knots) > 1e-6])])
