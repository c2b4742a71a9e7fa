"""Which primitive is flown next, after every measurement: on with the chain, a new chain, back, or none.

A chain may lead away from the target before it leads there. Where it is given up on the way, the way back to the
attitude that was measured nearest is known exactly, whatever the robot: the same loops backwards.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from tfsat_host.dynamics import quaternion
from tfsat_host.orbit.planner import Chain, Planner, backwards, remainder
from tfsat_host.orbit.primitives import Primitive
from tfsat_host.robot.model import FloatArray

Outcome = Literal["within tolerance", "no progress", "given up", "primitives used up"]

# While more primitives are to come, a chain may lead so far beside the target: a short one mends it at the end.
_DRIFT_RAD = math.radians(1.0)
# Plans without progress before the flight gives up: noise may hide it once or twice.
_PATIENCE = 6
# One measurement in a thousand is farther off than so many standard deviations about each axis.
_BLUR_DEVIATIONS = 4.0


class Pilot:
    """Decides from measured attitudes.

    Args:
        planner: Makes the chains.
        target_xyzw: (4,) where to go.
        noise_rad: Standard deviation of the measurements about each axis. Nearer than four of these no chain
            leads away from the target first: what is left may be noise.

    Attributes:
        outcome: Why nothing more is flown, once that is so.
    """

    def __init__(self, planner: Planner, target_xyzw: FloatArray, noise_rad: float) -> None:
        self.outcome: Outcome = "within tolerance"
        self._planner = planner
        self._target = target_xyzw
        self._blur_rad = _BLUR_DEVIATIONS * noise_rad
        self._chain = Chain((), 0.0)
        self._returning = False
        self._nearest_to_go, self._patience = np.inf, _PATIENCE
        self._least_rad = np.inf
        self._since_least: tuple[Primitive, ...] = ()

    def next(self, measured_xyzw: FloatArray, left: int) -> Primitive | None:
        """What to fly from a measured attitude (4,), if up to `left` primitives may be; None ends the flight."""
        needed = quaternion.product(quaternion.inverse(measured_xyzw), self._target)
        error = float(quaternion.angle(needed))
        if error < self._least_rad:
            self._least_rad, self._since_least = error, ()
            if self._returning:
                self._chain = Chain((), error)
        if error <= self._planner.tolerance_rad:
            self.outcome = "within tolerance"
            return None
        if left == 0 and not self._has_returned:
            self.outcome = "primitives used up"
            return None
        if not self._returning and (not self._chain.primitives or self._astray(needed)):
            self._plan(needed, left)
        if not self._chain.primitives:
            return None
        first, self._chain = self._chain.primitives[0], self._chain.after_first()
        self._since_least = (*self._since_least, first)
        return first

    @property
    def _has_returned(self) -> bool:
        return self._returning and not self._chain.primitives

    def _plan(self, needed: FloatArray, left: int) -> None:
        near = quaternion.angle(needed) <= self._blur_rad
        self._chain, to_go = (
            self._planner.chain(needed, most=left, detour=not near),
            self._planner.to_go(needed),
        )
        if to_go < self._nearest_to_go:
            self._nearest_to_go, self._patience = to_go, _PATIENCE
        else:
            self._patience -= 1
        if not self._chain.primitives and not self._since_least:
            self.outcome = "no progress"
        elif not self._chain.primitives or self._patience == 0 or self._is_last_chance(left):
            self.outcome, self._returning = "given up", True
            self._chain = Chain(backwards(self._since_least), self._least_rad)

    def _is_last_chance(self, left: int) -> bool:
        """Whether the way back takes all primitives that are left, and the chain leads no nearer than it."""
        return 0 < left <= len(self._since_least) and self._chain.remaining_rad >= self._least_rad

    def _astray(self, needed: FloatArray) -> bool:
        """Whether the chain, flown from here, would no longer lead where it was meant to."""
        tolerance = self._planner.tolerance_rad
        more = len(self._chain.primitives) > 1
        allowed = max(tolerance, _DRIFT_RAD, self._blur_rad) if more else tolerance
        remaining = float(quaternion.angle(remainder(self._chain.primitives, needed)))
        return remaining > max(allowed, self._chain.remaining_rad * (1.0 + 1e-6) + 1e-9)
