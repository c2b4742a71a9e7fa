"""From the rotation that is needed to a chain of primitives: by lookup, or by a beam search for the shortest time.

Robots of this kind are fast about one axis and slow about the others: the drop tower robot turns about its long
axis some twenty times as fast as about any other. The angle that is left says little, then, and an estimate of the time
leads the search. A rotation is either made of parts about three perpendicular axes, or the fast axis is turned into the
right place for the second fastest, and back: R = R_1(a) R_2(b) R_1(c), as with z-x-z Euler angles. The last primitive
need not lie on the grid: its displacements are solved for the rotation that is left. At last the displacements of the
whole chain are optimized for its time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.plan.orbit.chain_polish import join_repeats, shorten_chain
from tfsat_host.plan.orbit.chain_search import lookup, search
from tfsat_host.plan.orbit.overlapping_loop import find_overlapping_primitive
from tfsat_host.plan.orbit.primitive_trim import SHARE_OF_TOLERANCE, trim_primitive
from tfsat_host.plan.orbit.primitives import Primitive, PrimitiveTable
from tfsat_host.plan.orbit.time_to_go import TimeToGo

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
        """Return the chain without its first primitive."""
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
        share: Of the tolerance, that a chain may leave to save time; 1 suits a robot that is exactly the model.
        moving_at_once: Greatest number of joints that the supply moves at the same time.
    """

    table: PrimitiveTable
    time_to_go: TimeToGo
    method: Method
    tolerance_rad: float
    trim: bool = True
    most: int = 150
    share: float = SHARE_OF_TOLERANCE
    moving_at_once: int = 1

    @classmethod
    def of(
        cls,
        table: PrimitiveTable,
        method: Method,
        tolerance_rad: float,
        *,
        trim: bool = True,
        most: int = 150,
        share: float = SHARE_OF_TOLERANCE,
        moving_at_once: int = 1,
    ) -> Planner:
        """Build a planner with the time-to-go estimates of the table; the lookup takes loops flown once."""
        table = table.single_loops if method == "greedy" else table
        return cls(table, TimeToGo.of(table), method, tolerance_rad, trim, most, share, moving_at_once)

    def chain(self, needed: FloatArray, *, most: int | None = None, detour: bool = True) -> Chain:
        """Plan the chain for a rotation `needed` (4,), body axes; empty if no primitive brings it nearer.

        A chain that cannot reach the tolerance comes as near as was found; its `remaining_rad` gives the
        remaining angle. The search tries the inverse rotation as well: its chain flown backwards may be faster.

        Args:
            needed: The rotation.
            most: Most primitives; the planner's own number if None.
            detour: Whether a primitive may lead away from the target. Within 1 deg of it none does.
        """
        most = self.most if most is None else most
        # Close to the target only direct steps: a detour would bring in more model error than it mends.
        if self.method == "greedy" or not detour or quaternion.angle(needed) <= _NO_DETOUR_RAD:
            return self._chain(self.table.single_loops, needed, most, direct=True)
        # Some turns, short ones above all, are found only among loops that are flown once.
        tables = dict.fromkeys((self.table, self.table.single_loops))
        chains = [self._search_chain(table, needed, most) for table in tables]
        if self.moving_at_once > 1 and self.trim and most > 0:
            allowed_rad = self.share * self.tolerance_rad
            loop = find_overlapping_primitive(self.table, needed, allowed_rad, self.moving_at_once)
            if loop is not None:
                chains.append(Chain((loop,), float(quaternion.angle(remainder((loop,), needed)))))
        return min(chains, key=self._order)

    def _search_chain(self, table: PrimitiveTable, needed: FloatArray, most: int) -> Chain:
        """Search both ways round, and optimize what is found."""
        undone = quaternion.inverse(needed)
        # The beam search is not symmetric in a rotation and its inverse; flying backwards costs the same.
        forth, back = (self._chain(table, turn, most, direct=False) for turn in (needed, undone))
        # Each is optimized the way it was found: a turn and its inverse then take exactly as long.
        if min(forth, back, key=self._order) is forth:
            return self._shorten_chain(forth, needed)
        return self._shorten_chain(back, undone).backwards

    def to_go(self, needed: FloatArray) -> float:
        """Estimate how far away a rotation (4,) is: its angle for the lookup, its time for the search."""
        if self.method == "greedy":
            return float(quaternion.angle(needed))
        return float(self.time_to_go.seconds(needed))

    def _order(self, chain: Chain) -> tuple[bool, float, float]:
        """Return the sort key of a chain, best first.

        Chains that reach the tolerance come first, by duration; the others follow, by remaining angle.
        """
        missed = chain.remaining_rad > self.tolerance_rad
        return missed, chain.remaining_rad if missed else 0.0, chain.duration_s

    def _chain(self, table: PrimitiveTable, needed: FloatArray, most: int, *, direct: bool) -> Chain:
        if not self.trim:
            return self._find_chain(table, needed, self.tolerance_rad, most, direct=direct)
        # A coarse goal takes fewer primitives; solving the last loop usually mends the rest.
        coarse = max(self.tolerance_rad, _TRIM_REACH_RAD)
        chain = self._trim_chain(table, self._find_chain(table, needed, coarse, most, direct=direct), needed)
        # Where it does not, search down to the tolerance itself, and keep the better chain.
        if chain.remaining_rad > self.tolerance_rad and coarse > self.tolerance_rad:
            finer = self._find_chain(table, needed, self.tolerance_rad, most, direct=direct)
            finer = self._trim_chain(table, finer, needed)
            chain = min(chain, finer, key=lambda chain: chain.remaining_rad)
        return chain

    def _shorten_chain(self, chain: Chain, needed: FloatArray) -> Chain:
        """Optimize all displacements of the chain, and again with a joint held aside over neighbouring loops."""
        if not self.trim or chain.remaining_rad > self.tolerance_rad:
            return chain
        chain = self._optimize(chain.primitives, chain, needed)
        joined = join_repeats(self.table, chain.primitives)
        return self._optimize(joined, chain, needed) if len(joined) < len(chain.primitives) else chain

    def _optimize(self, start: tuple[Primitive, ...], chain: Chain, needed: FloatArray) -> Chain:
        """Optimize all displacements from `start` on; return `chain` if that is not faster."""
        for share in (self.share, 0.5 * self.share):  # from some chains the last bit of time is not found
            shorter = shorten_chain(self.table, start, needed, share * self.tolerance_rad)
            if shorter is not None and Chain(*shorter).duration_s < chain.duration_s:
                return Chain(*shorter)
        return chain

    def _find_chain(
        self, table: PrimitiveTable, needed: FloatArray, goal_rad: float, most: int, *, direct: bool
    ) -> Chain:
        if direct:
            route = lookup(table, needed, goal_rad, most)
        else:
            time_to_go = self.time_to_go if table is self.table else TimeToGo.of(table)
            route = search(table, time_to_go, needed, goal_rad, most=most)
        return Chain(tuple(table.primitive(index) for index in route.primitives), route.remaining_rad)

    def _trim_chain(self, table: PrimitiveTable, chain: Chain, needed: FloatArray) -> Chain:
        """Solve for the chain's last primitive; return the chain unchanged if that leaves no less."""
        # Only the last loop is free: it must give what those before it leave of the rotation.
        before = chain.primitives[:-1]
        last, remaining = trim_primitive(table, remainder(before, needed), self.tolerance_rad)
        return Chain((*before, last), remaining) if remaining < chain.remaining_rad else chain


def backwards(primitives: tuple[Primitive, ...]) -> tuple[Primitive, ...]:
    """Return the primitives that undo these, in the order they are flown."""
    return tuple(primitive.backwards for primitive in reversed(primitives))


def remainder(primitives: tuple[Primitive, ...], needed: FloatArray) -> FloatArray:
    """Compute the remainder of a rotation (4,) after some primitives, by the model."""
    for primitive in primitives:
        needed = quaternion.product(quaternion.inverse(primitive.quaternion_xyzw), needed)
    return needed
