"""From the rotation that is needed to a chain of primitives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

from tfsat_host.dynamics import quaternion
from tfsat_host.orbit.primitives import Primitive, PrimitiveTable
from tfsat_host.orbit.search import lookup, search
from tfsat_host.orbit.time_to_go import TimeToGo
from tfsat_host.orbit.trim import trimmed
from tfsat_host.robot.model import FloatArray

Method = Literal["greedy", "search"]

# What the displacements of one loop can usually still mend.
_TRIM_REACH_RAD = math.radians(1.0)
# So near the target a detour would bring in more of the model's errors than it mends.
_NO_DETOUR_RAD = math.radians(1.0)


class Chain(NamedTuple):
    """Primitives one after another.

    Attributes:
        primitives: In the order they are flown.
        remaining_rad: What they leave of the rotation they were made for, by the model.
    """

    primitives: tuple[Primitive, ...]
    remaining_rad: float

    @property
    def duration_s(self) -> float:
        """Of all primitives."""
        return sum(primitive.duration_s for primitive in self.primitives)

    @property
    def backwards(self) -> Chain:
        """The chain for the inverse rotation: every primitive backwards, the last one first."""
        return Chain(backwards(self.primitives), self.remaining_rad)

    def after_first(self) -> Chain:
        """The chain without its first primitive."""
        return Chain(self.primitives[1:], self.remaining_rad)


@dataclass(frozen=True, eq=False)
class Planner:
    """Plans with the robot as its table has it.

    Attributes:
        table: The primitives.
        time_to_go: Estimates for the search and for its progress.
        method: `greedy` takes the primitive that leaves least, again and again; `search` looks for the
            fastest chain and allows detours.
        tolerance_rad: What may be left at the end.
        trim: Solve the displacements of the last primitive instead of taking them from the grid.
        most: Most primitives in a chain.
    """

    table: PrimitiveTable
    time_to_go: TimeToGo
    method: Method
    tolerance_rad: float
    trim: bool = True
    most: int = 150

    @classmethod
    def of(
        cls,
        table: PrimitiveTable,
        method: Method,
        tolerance_rad: float,
        *,
        trim: bool = True,
        most: int = 150,
    ) -> Planner:
        """A planner with the table's own estimates."""
        return cls(table, TimeToGo.of(table), method, tolerance_rad, trim, most)

    def chain(self, needed: FloatArray, *, most: int | None = None, detour: bool = True) -> Chain:
        """The chain for a rotation `needed` (4,), body axes; empty if no primitive brings it nearer.

        A chain that cannot reach the tolerance comes as near as was found; its `remaining_rad` says how near.
        The search looks for the inverse rotation, too: that chain backwards may be faster.

        Args:
            needed: The rotation.
            most: Most primitives; the planner's own number if None.
            detour: Whether a primitive may lead away from the target. Nearer than 1 deg none does.
        """
        most = self.most if most is None else most
        if self.method == "greedy" or not detour or quaternion.angle(needed) <= _NO_DETOUR_RAD:
            return self._chain(needed, most, direct=True)
        forth = self._chain(needed, most, direct=False)
        back = self._chain(quaternion.inverse(needed), most, direct=False).backwards
        return min(forth, back, key=self._order)

    def to_go(self, needed: FloatArray) -> float:
        """A measure of how far a rotation (4,) is away: the angle for the lookup, the time for the search."""
        if self.method == "greedy":
            return float(quaternion.angle(needed))
        return float(self.time_to_go.seconds(needed))

    def _order(self, chain: Chain) -> tuple[bool, float, float]:
        """Those that reach the tolerance come first, the fastest of them before; of the others the nearest."""
        missed = chain.remaining_rad > self.tolerance_rad
        return missed, chain.remaining_rad if missed else 0.0, chain.duration_s

    def _chain(self, needed: FloatArray, most: int, *, direct: bool) -> Chain:
        if not self.trim:
            return self._found(needed, self.tolerance_rad, most, direct=direct)
        coarse = max(self.tolerance_rad, _TRIM_REACH_RAD)
        chain = self._trimmed(self._found(needed, coarse, most, direct=direct), needed)
        if chain.remaining_rad > self.tolerance_rad and coarse > self.tolerance_rad:
            finer = self._trimmed(self._found(needed, self.tolerance_rad, most, direct=direct), needed)
            chain = min(chain, finer, key=lambda chain: chain.remaining_rad)
        return chain

    def _found(self, needed: FloatArray, goal_rad: float, most: int, *, direct: bool) -> Chain:
        if direct:
            route = lookup(self.table, needed, goal_rad, most)
        else:
            route = search(self.table, self.time_to_go, needed, goal_rad, most=most)
        return Chain(tuple(self.table.primitive(index) for index in route.primitives), route.remaining_rad)

    def _trimmed(self, chain: Chain, needed: FloatArray) -> Chain:
        """The chain with its last primitive solved for, if that leaves less."""
        before = chain.primitives[:-1]
        last, remaining = trimmed(self.table, remainder(before, needed), self.tolerance_rad)
        return Chain((*before, last), remaining) if remaining < chain.remaining_rad else chain


def backwards(primitives: tuple[Primitive, ...]) -> tuple[Primitive, ...]:
    """The primitives that undo these, in the order they are flown."""
    return tuple(primitive.backwards for primitive in reversed(primitives))


def remainder(primitives: tuple[Primitive, ...], needed: FloatArray) -> FloatArray:
    """What is left of a rotation (4,) after some primitives, by the model."""
    for primitive in primitives:
        needed = quaternion.product(quaternion.inverse(primitive.quaternion_xyzw), needed)
    return needed
