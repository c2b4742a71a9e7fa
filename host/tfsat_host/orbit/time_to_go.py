"""How long it may take to turn by a given rotation: an estimate that leads the search.

Robots of this kind are fast about one axis and slow about the others: the drop tower robot turns about its long
axis some twenty times as fast as about any other. The angle that is left says little, then. A rotation is either
made of parts about three perpendicular axes, or the fast axis is turned into the right place for the second
fastest, and back: R = R_1(a) R_2(b) R_1(c), as with z-x-z Euler angles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.angles import wrapped
from tfsat_host.dynamics import quaternion
from tfsat_host.orbit.primitives import PrimitiveTable
from tfsat_host.robot.model import FloatArray

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
        """By the table's best primitives about each axis; what else they turn must be undone by the faster axes."""
        vectors, duration = quaternion.logarithm(table.rotation), table.duration_s
        first, fast = _fastest(vectors, duration)
        first = first / np.linalg.norm(first)
        repaid = duration + np.abs(first @ vectors) / fast
        across = vectors - first[:, None] * (first @ vectors)
        second, middle = _fastest(across, repaid)
        if middle < _SLOWEST_RAD_S:
            second, middle = _perpendicular(first), _SLOWEST_RAD_S
        second = second / np.linalg.norm(second)
        third = np.cross(first, second)
        repaid = repaid + np.abs(second @ vectors) / middle
        slow = max(float(np.max(np.abs(third @ vectors) / repaid)), _SLOWEST_RAD_S)
        return cls(np.stack([first, second, third]), np.array([fast, middle, slow]))

    def seconds(self, needed: FloatArray) -> FloatArray:
        """(...) for rotations (4, ...)."""
        fast, middle, slow = self.rate_rad_s
        a, b, c = np.abs(np.tensordot(self.axes, quaternion.logarithm(needed), 1))
        in_parts = a / fast + b / middle + c / slow
        x, y, z = np.tensordot(self.axes, needed[:3], 1)
        tilt = 2.0 * np.arctan2(np.hypot(y, z), np.hypot(needed[3], x))
        # Half the sum and half the difference of the two turns about the fast axis.
        half_sum, half_difference = np.arctan2(x, needed[3]), np.arctan2(z, y)
        turns = np.abs(wrapped(half_sum + half_difference)) + np.abs(wrapped(half_sum - half_difference))
        # The same with the tilt backwards: both turns half a turn further.
        far = np.abs(wrapped(half_sum + half_difference + np.pi)) + np.abs(
            wrapped(half_sum - half_difference + np.pi)
        )
        by_turns = np.minimum(turns, far) / fast + tilt / middle
        return np.asarray(np.minimum(in_parts, by_turns))


def _fastest(vectors: FloatArray, duration: FloatArray) -> tuple[FloatArray, float]:
    """The rotation vector (3,) of (3, m) that goes farthest in its time, and its rate."""
    rates = np.sqrt((vectors * vectors).sum(axis=0)) / duration
    best = int(np.argmax(rates))
    return vectors[:, best], float(rates[best])


def _perpendicular(axis: FloatArray) -> FloatArray:
    """Some vector (3,) perpendicular to `axis` (3,)."""
    return np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
