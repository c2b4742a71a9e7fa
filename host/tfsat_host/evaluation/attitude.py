"""Attitude from angular rates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tfsat_host.dynamics import quaternion

FloatArray = NDArray[np.float64]


def integrate_rates(t_s: FloatArray, rate_rad_s: FloatArray) -> Rotation:
    """Attitudes relative to the first sample.

    Between two samples the rate is taken to change linearly; the step is the Magnus expansion to second order, so that
    its error is of the fifth order in the step.

    Args:
        t_s: (n,) sample times.
        rate_rad_s: (n, 3) rates in the frame that they were measured in.

    Returns:
        n rotations from that frame to where it was at the first sample.
    """
    before, after, steps_s = rate_rad_s[:-1], rate_rad_s[1:], np.diff(t_s)[:, None]
    turns = 0.5 * steps_s * (before + after) + steps_s**2 / 12.0 * np.cross(before, after)
    steps = Rotation.from_rotvec(np.concatenate([np.zeros((1, 3)), turns])).as_quat()
    return Rotation.from_quat(_products(steps))


def _products(quaternions: FloatArray) -> FloatArray:
    """(n, 4): the product of all up to each, by doubling the reach of every one in each round."""
    reach = 1
    total = quaternions.T.copy()
    while reach < total.shape[1]:
        total[:, reach:] = quaternion.product(total[:, :-reach], total[:, reach:])
        reach *= 2
    return np.ascontiguousarray(total.T)


def reorientation_deg(start: Rotation, end: Rotation) -> float:
    """Angle of the rotation that leads from one attitude to another."""
    return float(np.rad2deg((start.inv() * end).magnitude()))
