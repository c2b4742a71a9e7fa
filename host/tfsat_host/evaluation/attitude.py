"""Attitude from angular rates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

FloatArray = NDArray[np.float64]


def integrate_rates(t_s: FloatArray, rate_rad_s: FloatArray) -> Rotation:
    """Attitudes relative to the first sample.

    Each interval turns by the mean of its two rates: second order, and exact for a constant axis with a
    rate that changes linearly.

    Args:
        t_s: (n,) sample times.
        rate_rad_s: (n, 3) rates in the frame that they were measured in.

    Returns:
        n rotations from that frame to where it was at the first sample.
    """
    steps = 0.5 * (rate_rad_s[1:] + rate_rad_s[:-1]) * np.diff(t_s)[:, None]
    attitude = Rotation.identity()
    attitudes = [attitude]
    for step in Rotation.from_rotvec(steps):
        attitude = attitude * step
        attitudes.append(attitude)
    return Rotation.concatenate(attitudes)


def reorientation_deg(start: Rotation, end: Rotation) -> float:
    """Angle of the rotation that leads from one attitude to another."""
    return float(np.rad2deg((start.inv() * end).magnitude()))
