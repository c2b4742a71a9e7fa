"""An estimate of the time that a rotation takes: parts about three axes, each at its own rate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.plan.orbit.primitives import PrimitiveTable

# Slower than this is taken as this: a robot that cannot turn about an axis at all.
_SLOWEST_RAD_S = 1e-6


@dataclass(frozen=True, eq=False)
class TimeToGo:
    """Estimates times.

    Attributes:
        axes: (3, 3) one axis a row, the fastest first, right-handed.
        rate_rad_s: (3,) average rate about each.
    """

    axes: FloatArray
    rate_rad_s: FloatArray

    @classmethod
    def of(cls, table: PrimitiveTable) -> TimeToGo:
        """Estimate the time to go from the table's best primitives about each axis.

        A primitive's rotation about faster axes must be undone by those axes, which adds time.
        """
        vectors, duration = quaternion.logarithm(table.rotation), table.duration_s
        # The fastest axis is that of the primitive with the highest angle per second.
        first, fast = _fastest(vectors, duration)
        first = first / np.linalg.norm(first)
        # Undoing a component about the fast axis takes time as well: charge it to the primitive.
        repaid = duration + np.abs(first @ vectors) / fast
        # Take off the component along the first axis: the second is sought perpendicular to it.
        across = vectors - first[:, None] * (first @ vectors)
        second, middle = _fastest(across, repaid)
        # Where no loop turns about any other axis, take some perpendicular one with a nominal rate.
        if middle < _SLOWEST_RAD_S:
            second, middle = np.cross(first, np.eye(3)[np.argmin(np.abs(first))]), _SLOWEST_RAD_S
        second = second / np.linalg.norm(second)
        # The third axis completes a right-handed triad; its loops must pay for both other components.
        third = np.cross(first, second)
        repaid = repaid + np.abs(second @ vectors) / middle
        slow = max(float(np.max(np.abs(third @ vectors) / repaid)), _SLOWEST_RAD_S)
        return cls(np.stack([first, second, third]), np.array([fast, middle, slow]))

    def seconds(self, needed: FloatArray) -> FloatArray:
        """(...) for rotations (4, ...)."""
        fast, middle, slow = self.rate_rad_s
        # First estimate: the rotation vector's parts about the three axes, one after another.
        a, b, c = np.abs(np.tensordot(self.axes, quaternion.logarithm(needed), 1))
        in_parts = a / fast + b / middle + c / slow
        # Second: R_1(a) R_2(b) R_1(c); b is the tilt of the fast axis, whatever a and c are.
        x, y, z = np.tensordot(self.axes, needed[:3], 1)
        tilt = 2.0 * np.arctan2(np.hypot(y, z), np.hypot(needed[3], x))
        # Half the sum and half the difference of the two turns about the fast axis.
        half_sum, half_difference = np.arctan2(x, needed[3]), np.arctan2(z, y)
        turns = np.abs(wrap_angle(half_sum + half_difference)) + np.abs(
            wrap_angle(half_sum - half_difference)
        )
        # The same with the tilt backwards: both turns half a turn further.
        far = np.abs(wrap_angle(half_sum + half_difference + np.pi)) + np.abs(
            wrap_angle(half_sum - half_difference + np.pi)
        )
        by_turns = np.minimum(turns, far) / fast + tilt / middle
        # Both can be flown: the cheaper one counts, element by element.
        return np.asarray(np.minimum(in_parts, by_turns))


def _fastest(vectors: FloatArray, duration: FloatArray) -> tuple[FloatArray, float]:
    """Return the rotation vector (3,) of (3, m) with the highest rate, and that rate."""
    rates = np.sqrt((vectors * vectors).sum(axis=0)) / duration
    best = int(np.argmax(rates))
    return vectors[:, best], float(rates[best])
