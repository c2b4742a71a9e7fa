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

import numpy as np

from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import FloatArray, IntArray
from tfsat_host.dynamics import quaternion
from tfsat_host.plan.loops import Loops
from tfsat_host.plan.orbit.chain_polish import shorten_chain
from tfsat_host.plan.orbit.primitives import Primitive, PrimitiveTable

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
            second, middle = _perpendicular(first), _SLOWEST_RAD_S
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


def _perpendicular(axis: FloatArray) -> FloatArray:
    """Some vector (3,) perpendicular to `axis` (3,)."""
    return np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])


# Two states of the beam that differ by less are one.
_SAME_RAD = 0.005
# A primitive must bring the target nearer by this at least: rounding is no progress.
_MIN_GAIN_RAD = 1e-9
# Where no chain reaches the goal, the search ends with those that would take so many times the estimate, and some
# loops more.
_MAX_COST_RATIO = 1.5
_LOOPS_MORE = 2.0


class Route(NamedTuple):
    """A chain of primitives.

    Attributes:
        primitives: Indices into the table, in order.
        remaining_rad: What is left after the last, by the model.
        duration_s: Of all.
    """

    primitives: tuple[int, ...]
    remaining_rad: float
    duration_s: float


def nearest(table: PrimitiveTable, needed: FloatArray, count: int) -> IntArray:
    """Indices of the `count` primitives that leave least of the rotation `needed` (4,), the best first."""
    remaining = _remaining_rotation(table, needed)
    # Partition first: only the few need sorting, not the whole table.
    few = np.argpartition(remaining, min(count, len(table)) - 1)[:count]
    return np.asarray(few[np.argsort(remaining[few], kind="stable")])


def lookup(table: PrimitiveTable, needed: FloatArray, goal_rad: float, most: int) -> Route:
    """Chain best primitives one by one until `goal_rad` is reached or none brings the target nearer.

    The successive table lookup of the paper's section "Feedback control", before it is flown.
    """
    chain: list[int] = []
    to_go_rad, duration = float(quaternion.angle(needed)), 0.0
    while to_go_rad > goal_rad and len(chain) < most:
        best = int(nearest(table, needed, 1)[0])
        after = quaternion.product(table.undone[:, best], needed)
        remaining = float(quaternion.angle(after))
        # Stop where even the best primitive gains no more than rounding would.
        if remaining > to_go_rad - _MIN_GAIN_RAD:
            break
        needed, to_go_rad, duration = after, remaining, duration + float(table.duration_s[best])
        chain.append(best)
    return Route(tuple(chain), to_go_rad, duration)


def search(
    table: PrimitiveTable,
    time_to_go: TimeToGo,
    needed: FloatArray,
    goal_rad: float,
    *,
    most: int,
    width: int = 32,
) -> Route:
    """Find the fastest chain by beam search, never slower than the lookup's if that reaches the goal.

    Each level of the search appends every primitive to each of the `width` most promising chains: those
    with the least time so far plus estimated time to go.

    Args:
        table: The primitives.
        time_to_go: The estimate of the time to go.
        needed: (4,) rotation from the present attitude to the target, body axes.
        goal_rad: Greatest permissible remaining angle.
        most: Most primitives in the chain.
        width: Chains kept per level.

    Returns:
        The chain; if none reaches the goal, the one that comes nearest.
    """
    # The greedy chain is the incumbent: once it reaches the goal, its time bounds the search.
    best = lookup(table, needed, goal_rad, most)
    patience_s = _MAX_COST_RATIO * float(time_to_go.seconds(needed)) + _LOOPS_MORE * float(
        table.duration_s.max()
    )
    beam, times, chains = needed[:, None], np.zeros(1), np.empty((1, 0), dtype=np.int64)
    for _level in range(most):
        # Expand every state of the beam by every primitive: (4, m, width) rotations that are then left.
        after = quaternion.product(table.undone[:, :, None], beam[:, None, :]).reshape(4, -1)
        spent = (table.duration_s[:, None] + times).reshape(-1)
        # Update the incumbent before pruning, so that a chain found here bounds this very level.
        best = _better(best, after, spent, chains, goal_rad)
        worth = spent + time_to_go.seconds(after)
        # Without an incumbent a generous multiple of the estimate ends hopeless searches.
        limit = best.duration_s if best.remaining_rad <= goal_rad else patience_s
        survivors = _select_promising(after, worth, limit, width)
        if not len(survivors):
            break
        # The flat index counts parents fastest: remainder and quotient are parent and primitive.
        chains = np.column_stack([chains[survivors % len(chains)], survivors // len(chains)])
        beam, times = after[:, survivors], spent[survivors]
    return best


def _better(best: Route, after: FloatArray, spent: FloatArray, chains: IntArray, goal: float) -> Route:
    """Return the best route of `best` and the new chains."""
    remaining = quaternion.angle(after)
    # Within the goal the time decides, outside of it the angle that is left.
    reached = np.flatnonzero(remaining <= goal)
    if len(reached):
        index = int(reached[np.argmin(spent[reached])])
        better = best.remaining_rad > goal or spent[index] < best.duration_s
    else:
        index = int(np.argmin(remaining))
        better = best.remaining_rad > goal and remaining[index] < best.remaining_rad
    if not better:
        return best
    chain = (*chains[index % len(chains)].tolist(), index // len(chains))
    return Route(chain, float(remaining[index]), float(spent[index]))


def _select_promising(after: FloatArray, worth: FloatArray, limit: float, width: int) -> IntArray:
    """Indices of the `width` best states that are worth less than `limit` and differ from one another."""
    # Take sixteen candidates a place: many of them fall into the same cell below.
    count = min(16 * width, len(worth))
    few = np.argpartition(worth, count - 1)[:count]
    few = few[np.argsort(worth[few], kind="stable")]
    few = few[worth[few] < limit]
    # Keep one state a cell of rotation vectors: near-duplicates would crowd the beam.
    cells = np.round(quaternion.logarithm(after[:, few]) / _SAME_RAD).astype(np.int64)
    _, first = np.unique(cells, axis=1, return_index=True)
    # `unique` orders by cell; sorting its indices restores the order of worth.
    return np.asarray(few[np.sort(first)][:width])


def _remaining_rotation(table: PrimitiveTable, needed: FloatArray) -> FloatArray:
    return quaternion.angle(quaternion.product(table.undone, needed[:, None]))


# The nearest primitives of so many shapes are tried: some have a joint at its limit, or too little to say about an
# axis. Among so many of the nearest they are looked for.
_SHAPES = 6
_CANDIDATES = 200
# Central differences: truncation near 1e-12 and rounding near 1e-10 are far below any tolerance.
_DIFFERENCE_RAD = 1e-6
# The sequencer's resolution is 0.01 deg: what rounds to nothing is not flown.
_STILL_RAD = np.radians(0.005)
# What is left by the model's account matters little below this share of the tolerance. Then the shortest loop is
# best, for the model's errors grow with what the joints turn.
_SHARE_OF_TOLERANCE = 0.25


def trim_primitive(
    table: PrimitiveTable, needed: FloatArray, tolerance_rad: float
) -> tuple[Primitive, float]:
    """Fit the displacements of a primitive to a rotation; return it and the remaining angle in rad.

    Args:
        table: Its primitives are the starting points; its body, limits and start pose apply.
        needed: (4,) the rotation, body axes.
        tolerance_rad: Of the solutions that leave a quarter of this or less, the shortest is taken.
    """
    # Several starts, the nearest primitive of each shape: a solution cannot change its order of strokes.
    near = nearest(table, needed, _CANDIDATES)
    _, first = np.unique(table.shape[near], return_index=True)
    starts = near[np.sort(first)[:_SHAPES]]
    tries = [_solve_primitive(table, table.primitive(int(index)), needed) for index in starts]
    # Solutions well inside the tolerance are equally good by the model: fly the shortest of them.
    enough = max(min(remaining for _, remaining in tries), _SHARE_OF_TOLERANCE * tolerance_rad)
    return min(
        (solution for solution in tries if solution[1] <= enough), key=lambda solution: solution[0].duration_s
    )


def _solve_primitive(
    table: PrimitiveTable, primitive: Primitive, needed: FloatArray
) -> tuple[Primitive, float]:
    """Solve for one primitive's displacements by least squares, within the joints' limits."""
    from scipy.optimize import least_squares

    shape = primitive.shape
    joints = list(shape.joints)
    loops = Loops(table.body, joints, (shape.sequence,), start_rad=table.start_rad, steps=table.steps)
    low, high = (table.limits_rad[joints] - table.start_rad[joints, None]).T

    # One batch of 2 d + 1 columns gives the residual and both sides of its central differences.
    shifts = _DIFFERENCE_RAD * np.hstack(
        [np.zeros((len(joints), 1)), np.eye(len(joints)), -np.eye(len(joints))]
    )
    # `least_squares` asks for the Jacobian in a call of its own: keep it by the bits of its argument.
    slope_cache: dict[bytes, FloatArray] = {}

    def left(displacement: FloatArray) -> FloatArray:
        """Rotation vector (3,) that displacements (d,) leave; its slopes come with it, at the price of a call."""
        undone = quaternion.inverse(loops.rotations(displacement[:, None] + shifts)[:, 0])
        vectors = quaternion.logarithm(quaternion.product(undone, needed[:, None]))
        forward, backward = np.split(vectors[:, 1:], 2, axis=1)
        slope_cache[displacement.tobytes()] = np.asarray((forward - backward) / (2.0 * _DIFFERENCE_RAD))
        return np.asarray(vectors[:, 0])

    def slopes(displacement: FloatArray) -> FloatArray:
        return slope_cache[displacement.tobytes()]

    # The residual is a rotation vector, its length the angle that is left.
    solution = least_squares(
        left,
        np.clip(primitive.displacement_rad, low, high),
        jac=slopes,
        bounds=(low, high),
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-14,
        max_nfev=20,
    )
    solved = np.clip(solution.x, low, high)
    displacement = np.where(np.abs(solved) < _STILL_RAD, 0.0, solved)
    # Judge what is flown: the rotation after small strokes were set to zero.
    rotation = loops.rotations(displacement[:, None])[:, 0, 0]
    remaining = float(quaternion.angle(quaternion.product(quaternion.inverse(rotation), needed)))
    return Primitive(shape, displacement, rotation, table.duration_of(shape, displacement)), remaining


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
    """

    table: PrimitiveTable
    time_to_go: TimeToGo
    method: Method
    tolerance_rad: float
    trim: bool = True
    most: int = 150
    share: float = _SHARE_OF_TOLERANCE

    @classmethod
    def of(
        cls,
        table: PrimitiveTable,
        method: Method,
        tolerance_rad: float,
        *,
        trim: bool = True,
        most: int = 150,
        share: float = _SHARE_OF_TOLERANCE,
    ) -> Planner:
        """Build a planner with the time-to-go estimates of the table."""
        return cls(table, TimeToGo.of(table), method, tolerance_rad, trim, most, share)

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
            return self._chain(needed, most, direct=True)
        undone = quaternion.inverse(needed)
        # The beam search is not symmetric in a rotation and its inverse; flying backwards costs the same.
        forth, back = (self._chain(turn, most, direct=False) for turn in (needed, undone))
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

    def _chain(self, needed: FloatArray, most: int, *, direct: bool) -> Chain:
        if not self.trim:
            return self._find_chain(needed, self.tolerance_rad, most, direct=direct)
        # A coarse goal takes fewer primitives; solving the last loop usually mends the rest.
        coarse = max(self.tolerance_rad, _TRIM_REACH_RAD)
        chain = self._trim_chain(self._find_chain(needed, coarse, most, direct=direct), needed)
        # Where it does not, search down to the tolerance itself, and keep the better chain.
        if chain.remaining_rad > self.tolerance_rad and coarse > self.tolerance_rad:
            finer = self._trim_chain(
                self._find_chain(needed, self.tolerance_rad, most, direct=direct), needed
            )
            chain = min(chain, finer, key=lambda chain: chain.remaining_rad)
        return chain

    def _shorten_chain(self, chain: Chain, needed: FloatArray) -> Chain:
        """Optimize all displacements of the chain; return the chain unchanged if that is not faster."""
        if not self.trim or chain.remaining_rad > self.tolerance_rad:
            return chain
        for share in (self.share, 0.5 * self.share):  # from some chains the last bit of time is not found
            shorter_chain = shorten_chain(self.table, chain.primitives, needed, share * self.tolerance_rad)
            if shorter_chain is not None:
                return Chain(*shorter_chain)
        return chain

    def _find_chain(self, needed: FloatArray, goal_rad: float, most: int, *, direct: bool) -> Chain:
        if direct:
            route = lookup(self.table, needed, goal_rad, most)
        else:
            route = search(self.table, self.time_to_go, needed, goal_rad, most=most)
        return Chain(tuple(self.table.primitive(index) for index in route.primitives), route.remaining_rad)

    def _trim_chain(self, chain: Chain, needed: FloatArray) -> Chain:
        """Solve for the chain's last primitive; return the chain unchanged if that leaves no less."""
        # Only the last loop is free: it must give what those before it leave of the rotation.
        before = chain.primitives[:-1]
        last, remaining = trim_primitive(self.table, remainder(before, needed), self.tolerance_rad)
        return Chain((*before, last), remaining) if remaining < chain.remaining_rad else chain


def backwards(primitives: tuple[Primitive, ...]) -> tuple[Primitive, ...]:
    """Return the primitives that undo these, in the order they are flown."""
    return tuple(primitive.backwards for primitive in reversed(primitives))


def remainder(primitives: tuple[Primitive, ...], needed: FloatArray) -> FloatArray:
    """Compute the remainder of a rotation (4,) after some primitives, by the model."""
    for primitive in primitives:
        needed = quaternion.product(quaternion.inverse(primitive.quaternion_xyzw), needed)
    return needed
