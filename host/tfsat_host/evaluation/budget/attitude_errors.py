"""How far a final attitude is off, from many ways of being wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.dynamics import quaternion

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Turned:
    """What errors do to the end of a drop, one standard deviation each.

    Attributes:
        attitude_deg: Of the final attitude: length of the rotation vector between wrong and right.
        reorientation_deg: Of the angle of reorientation.
    """

    attitude_deg: float
    reorientation_deg: float


def in_all(turned: list[Turned]) -> Turned:
    """Of independent errors together: roots of the sums of squares."""
    return Turned(
        float(np.linalg.norm([one.attitude_deg for one in turned])),
        float(np.linalg.norm([one.reorientation_deg for one in turned])),
    )


def to_first_order(turns_rad: FloatArray, true: FloatArray) -> Turned:
    """Of k independent errors that turn the final attitude by small rotation vectors.

    Of these, only what lies along the axis of the reorientation changes its angle.

    Args:
        turns_rad: (k, 3), axes at the release.
        true: (4,) final attitude, to axes at the release.
    """
    whole = quaternion.logarithm(true)
    along = turns_rad @ (whole / np.linalg.norm(whole))
    return Turned(float(np.degrees(np.linalg.norm(turns_rad))), float(np.degrees(np.linalg.norm(along))))


def exactly(wrong: FloatArray, true: FloatArray) -> Turned:
    """Of k independent errors, each tried d times.

    Args:
        wrong: (4, d, k) final attitudes; one error is tried in both senses, or by d random draws.
        true: (4,) final attitude.
    """
    right = true[:, None, None]
    apart = quaternion.angle(quaternion.product(wrong, quaternion.inverse(right)))
    longer = quaternion.angle(wrong) - quaternion.angle(right)
    attitude, reorientation = (float((error**2).mean(axis=0).sum()) ** 0.5 for error in (apart, longer))
    return Turned(float(np.degrees(attitude)), float(np.degrees(reorientation)))
