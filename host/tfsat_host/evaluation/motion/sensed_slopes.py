"""Joint rates by the slopes of the sensed angles: less exact than the gyros', and used where those do not tell them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from tfsat_host.evaluation.motion.joint_fit import SensedJoint, sample_noise_rad
from tfsat_host.evaluation.motion.lag import derivative

FloatArray = NDArray[np.float64]

_SMOOTHING_ORDER = 3
SMOOTHED = 9
"""Over so many samples a cubic is laid through a joint's sensed angles: a servo's ramp takes a dozen."""
SMOOTHED_SHARE = 0.505
"""So much of a sample's noise that cubic leaves at its middle: the square root of its largest coefficient, 59 / 231."""
_UNSENSED_VARIANCE = np.deg2rad(200.0) ** 2
"""Of the rate of a joint that nothing tells: servos turn no faster."""


@dataclass(frozen=True, eq=False)
class Slopes:
    """Of each joint at n samples.

    Attributes:
        rate_rad_s: (n, 3); 0 where no sensor ever answered.
        variance: (3,) of those, (rad/s)^2.
        angle_std_rad: (3,) of one sample of the angle that the slope is of.
    """

    rate_rad_s: FloatArray
    variance: FloatArray
    angle_std_rad: FloatArray


def slopes_of(t_s: FloatArray, joints: Sequence[SensedJoint], rate_hz: float) -> Slopes:
    """Of one drop.

    Args:
        t_s: (n,).
        joints: Their sensors' samples.
        rate_hz: Sampling rate.
    """
    rates = np.zeros((len(t_s), len(joints)))
    variances = np.full(len(joints), _UNSENSED_VARIANCE)
    stds = np.full(len(joints), np.pi)
    for j, joint in enumerate(joints):
        angle = joint.mean_rad
        known = np.isfinite(angle)
        if known.sum() > SMOOTHED:
            smooth = smoothed(np.interp(t_s, t_s[known], angle[known]))
            rates[:, j] = derivative(t_s, smooth)
            stds[j] = sample_noise_rad(angle)
            # The slope between two samples m steps apart has the variance 2 (sigma / (m step))^2.
            variances[j] = 2.0 * (stds[j] * rate_hz / SMOOTHED) ** 2
    return Slopes(rates, variances, stds)


def smoothed(values: FloatArray) -> FloatArray:
    """(n,) each of n > SMOOTHED equidistant samples by the cubic through those around it (Savitzky and Golay, 1964).

    The first and the last few share the cubic of the first and the last window.
    """
    half = SMOOTHED // 2
    powers = np.vander(np.arange(-half, half + 1) / half, _SMOOTHING_ORDER + 1)
    fitted = powers @ np.linalg.pinv(powers)
    inner = sliding_window_view(values, SMOOTHED) @ fitted[half]
    return np.concatenate([fitted[:half] @ values[:SMOOTHED], inner, fitted[half + 1 :] @ values[-SMOOTHED:]])
