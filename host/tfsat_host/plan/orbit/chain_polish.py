"""A chain of loops made as short as it can be, and an estimate of the least time that it can take.

The search takes loops from a grid; here the displacements of the whole chain are free, for the least time that still
leads to the target (sequential quadratic programming, SLSQP of scipy). Equal loops of a chain stay equal: a long chain
repeats few of them, and a part of its turn that they share is best shared evenly.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np
from scipy import optimize

from tfsat_host.arrays import FloatArray, IntArray
from tfsat_host.dynamics import quaternion
from tfsat_host.plan.orbit.primitives import Primitive, PrimitiveTable

# Central differences: truncation near 1e-10 and rounding near 1e-11 are far below any tolerance.
_DIFFERENCE_RAD = 1e-5
# What is smaller cannot be commanded.
_STILL_RAD = np.radians(0.005)
# More free displacements than these would take longer than the search.
_MAX_FREE = 60
_ITERATIONS = 25
# Short of what is allowed by a little, or rounding would leave more.
_ALMOST = 0.999


def shorten_chain(
    table: PrimitiveTable, primitives: Sequence[Primitive], needed: FloatArray, allowed_rad: float
) -> tuple[tuple[Primitive, ...], float] | None:
    """Minimize the chain's duration over its displacements; None if the result misses what is allowed.

    Returns the chain and its remaining angle in rad; it may take longer than the one to start from.

    Args:
        table: The robot, its start pose, limits and rates.
        primitives: The chain to start from; which joints move in which order is kept.
        needed: (4,) the rotation that the chain is for, body axes.
        allowed_rad: Greatest permissible remaining angle.
    """
    chain = _Chain.of(table, primitives)
    if not 0 < len(chain.start) <= _MAX_FREE:
        return None
    # Count misses in tolerances, so that the constraints are of order one.
    scale = max(allowed_rad, np.radians(0.01))

    # Slacks x[-3:] hold the scaled miss: equality rows tie them to it, a ball bounds their length.
    def missed(x: FloatArray) -> FloatArray:
        return np.asarray(chain.residual_rotation(x[:-3], needed)[0] / scale - x[-3:])

    def missed_slopes(x: FloatArray) -> FloatArray:
        return np.hstack([chain.residual_rotation(x[:-3], needed)[1] / scale, -np.eye(3)])

    # Without changes of sign the time is linear in the displacements; slacks take none.
    times: FloatArray = np.append(chain.seconds, np.zeros(3))

    def duration(x: FloatArray) -> tuple[float, FloatArray]:
        return float(times @ x), times

    room = (_ALMOST * allowed_rad / scale) ** 2
    # Begin with slacks that fulfil the equality rows.
    first, _ = chain.residual_rotation(chain.start, needed)
    result = optimize.minimize(
        duration,
        np.append(chain.start, first / scale),
        jac=True,
        method="SLSQP",
        bounds=optimize.Bounds(np.append(chain.low, [-np.inf] * 3), np.append(chain.high, [np.inf] * 3)),
        constraints=[
            optimize.NonlinearConstraint(missed, 0.0, 0.0, jac=missed_slopes),
            optimize.NonlinearConstraint(
                lambda x: x[-3:] @ x[-3:],
                -np.inf,
                room,
                jac=lambda x: np.append(np.zeros(len(x) - 3), 2.0 * x[-3:])[None],
            ),
        ],
        options={"maxiter": _ITERATIONS, "ftol": 1e-4},
    )
    # Judge the chain as it is flown, without strokes that are too small to command.
    trimmed_primitives = chain.primitives(np.clip(result.x[:-3], chain.low, chain.high))
    remaining_xyzw = needed
    for primitive in trimmed_primitives:
        remaining_xyzw = quaternion.product(quaternion.inverse(primitive.quaternion_xyzw), remaining_xyzw)
    remaining = float(quaternion.angle(remaining_xyzw))
    # Few iterations need not converge.
    return (trimmed_primitives, remaining) if remaining <= allowed_rad else None


def join_repeats(table: PrimitiveTable, primitives: Sequence[Primitive]) -> tuple[Primitive, ...]:
    """Make one primitive of neighbours that hold the same joint aside: between them it need not come back.

    Their displacements become the mean, so the chain leads elsewhere until it is optimized again.
    """
    joined = list[Primitive]()
    for (shape, _), neighbours in itertools.groupby(
        primitives, key=lambda primitive: (primitive.shape.once, tuple(np.sign(primitive.displacement_rad)))
    ):
        equal = list(neighbours)
        if shape.held is not None and len(equal) > 1:
            repeats = [primitive.shape.repeats for primitive in equal]
            mean = np.average([primitive.displacement_rad for primitive in equal], axis=0, weights=repeats)
            equal = [table.primitive_of(shape._replace(repeats=sum(repeats)), mean)]
        joined += equal
    return tuple(joined)


class _Chain:
    """Different loops, the order they are flown in, and the vector (f,) of all their displacements.

    Attributes:
        start: (f,) where they stand.
        low, high: (f,) as far as the joints' limits let them go without a change of sign.
        seconds: (f,) time that a rad of each takes in the whole chain.
    """

    def __init__(
        self, table: PrimitiveTable, different: list[Primitive], order: IntArray, start: FloatArray
    ) -> None:
        self._table, self._order, self.start = table, order, start
        self._shapes = [primitive.shape for primitive in different]
        edges = np.cumsum([0, *(len(shape.joints) for shape in self._shapes)])
        self._parts = [slice(a, b) for a, b in itertools.pairwise(edges)]
        joints = np.concatenate([shape.joints for shape in self._shapes]).astype(int)
        room = table.limits_rad[joints] - table.start_rad[joints, None]
        # Each displacement stays on its side of zero, where its time has no kink.
        self.low = np.where(start >= 0.0, 0.0, room[:, 0])
        self.high = np.where(start >= 0.0, room[:, 1], 0.0)
        # A loop that is flown k times takes k times as long for each of its displacements.
        flight_counts = np.repeat(np.bincount(order), np.diff(edges))
        # The tiny number gives a displacement of zero the sign of its bounds.
        stroke_counts = flight_counts * np.concatenate([shape.stroke_counts for shape in self._shapes])
        self.seconds = np.sign(start + 1e-300) * stroke_counts / table.joint_rate_rad_s[joints]
        self._known: tuple[bytes, tuple[FloatArray, FloatArray]] | None = None

    @classmethod
    def of(cls, table: PrimitiveTable, primitives: Sequence[Primitive]) -> _Chain:
        # Loops that are equal to the bit share their variables, and stay equal.
        keys = [(p.shape, p.displacement_rad.tobytes()) for p in primitives]
        numbers = {key: number for number, key in enumerate(dict.fromkeys(keys))}
        different = [primitives[keys.index(key)] for key in numbers]
        start = np.concatenate([p.displacement_rad for p in different]) if different else np.empty(0)
        return cls(table, different, np.array([numbers[key] for key in keys], dtype=int), start)

    def residual_rotation(self, x: FloatArray, needed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rotation vector (3,) that displacements (f,) leave, and its derivatives (3, f)."""
        # The solver asks for residual and Jacobian of a point in two calls: compute both in the first.
        if self._known is not None and self._known[0] == x.tobytes():
            return self._known[1]
        turns, slopes = [], []
        for shape, part in zip(self._shapes, self._parts, strict=True):
            shift = _DIFFERENCE_RAD * np.eye(len(shape.joints))
            # A loop and its central differences in one batch; changes are in the axes after the loop.
            columns = x[part, None] + np.hstack([np.zeros((len(shift), 1)), shift, -shift])
            rotation = self._table.rotations(shape, columns)
            change = quaternion.logarithm(
                quaternion.product(quaternion.inverse(rotation[:, :1]), rotation[:, 1:])
            )
            forward, backward = np.split(change, 2, axis=1)
            turns.append(rotation[:, 0])
            slopes.append((forward - backward) / (2.0 * _DIFFERENCE_RAD))
        # From the last loop to the first; `after` is the product of the loops that follow.
        of_each = np.zeros((3, len(x)))
        after = quaternion.identity()
        for number in self._order[::-1]:
            part = self._parts[number]
            # A loop's change, in the axes at the end of the chain.
            of_each[:, part] += quaternion.to_matrix(after).T @ slopes[number]
            after = quaternion.product(turns[number], after)
        rest = quaternion.product(quaternion.inverse(after), needed)
        vector = quaternion.logarithm(rest)
        # The rest becomes exp(-change) rest: the differential of its logarithm, from the other side.
        turned = -quaternion.to_matrix(rest).T @ of_each
        derivative = quaternion.inverse_differential(np.repeat(vector[:, None], len(x), axis=1), turned)
        self._known = x.tobytes(), (vector, derivative)
        return vector, derivative

    def primitives(self, x: FloatArray) -> tuple[Primitive, ...]:
        """Build the primitives of the chain for displacements (f,).

        A loop in which fewer than two joints still move is left out.
        """
        primitives: list[Primitive | None] = []
        for shape, part in zip(self._shapes, self._parts, strict=True):
            displacement = np.where(np.abs(x[part]) < _STILL_RAD, 0.0, x[part])
            # A single joint retraces its path, which turns nothing.
            moves = np.count_nonzero(displacement) > 1
            primitives.append(self._table.primitive_of(shape, displacement) if moves else None)
        return tuple(p for p in (primitives[number] for number in self._order) if p is not None)


# A loop of the grid slower than this share of the fastest is not climbed from; nor are more than so many.
_WORTH_CLIMBING = 0.9
_CLIMBS = 12


class LeastTime(NamedTuple):
    """An estimate of the least time of a chain of loops of a table's shapes, within the joints' limits.

    Rotations obey the triangle inequality: a chain turns by no more than its loops turn one by one, and tilts a
    direction by no more than they tilt it. So it takes about the turn (or the tilt) that is needed, divided by the
    greatest turn (or tilt) a second of any single loop. A joint that is held aside over loops without end takes no
    time of each.

    Attributes:
        seconds: The time.
        of: Which of the two gives it.
        angle_rad: What is needed at least of it: tolerance taken off.
        rate_rad_s: The greatest of any loop: the highest of the maxima that are climbed from the table's best loops.
        direction: (3,) the direction that is tilted, body axes; the one that gives the longest time by the table.
    """

    seconds: float
    of: Literal["turn", "tilt"]
    angle_rad: float
    rate_rad_s: float
    direction: FloatArray


def least_time(
    table: PrimitiveTable, fast_axis: FloatArray, needed: FloatArray, tolerance_rad: float
) -> LeastTime:
    """Estimate the least time for a rotation `needed` (4,).

    The search for the direction starts at `fast_axis` (3,).
    """
    turns = table.rotation

    def by_table(angles: tuple[float, FloatArray]) -> float:
        return (angles[0] - tolerance_rad) / max(float((angles[1] / table.inner_s).max()), 1e-12)

    # Angle between a body direction before and after a rotation; by the chord, small angles keep digits.
    def tilts(direction: FloatArray, rotation: FloatArray) -> FloatArray:
        moved = np.tensordot(direction, quaternion.to_matrix(quaternion.inverse(rotation)), 1)
        chord = np.sqrt(((moved.T - direction).T ** 2).sum(axis=0))
        return np.asarray(2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0)))

    def shorter(direction: FloatArray) -> float:
        unit = direction / np.linalg.norm(direction)
        return -by_table((float(tilts(unit, needed)), tilts(unit, turns)))

    # Every direction gives an estimate, the greatest counts: search without derivatives, over the kinks.
    optimum = optimize.minimize(
        shorter, fast_axis, method="Nelder-Mead", options={"maxiter": 200, "xatol": 1e-3}
    )
    direction = optimum.x / np.linalg.norm(optimum.x)

    def tilt(rotation: FloatArray) -> FloatArray:
        return tilts(direction, rotation)

    def estimate(of: Literal["turn", "tilt"], measure: Callable[[FloatArray], FloatArray]) -> LeastTime:
        angle = max(float(measure(needed)) - tolerance_rad, 0.0)
        # Loops between the grid's may be faster.
        rate = _greatest_rate(table, measure) if angle > 0.0 else np.inf
        return LeastTime(angle / rate, of, angle, rate, direction)

    return max(estimate("turn", quaternion.angle), estimate("tilt", tilt), key=lambda least: least.seconds)


def _greatest_rate(table: PrimitiveTable, measure: Callable[[FloatArray], FloatArray]) -> float:
    """Compute the greatest rate of a measure over all loops, rad/s.

    It is climbed to from the table's best loop of each shape.
    """
    rates = measure(table.rotation) / table.inner_s
    best = float(rates.max())
    ranked = np.argsort(-rates, kind="stable")
    # The best loop of each shape, however often repeated: starts of one shape would lead to the same maxima.
    shapes_once = [table.shapes.index(shape.once) for shape in table.shapes]
    _, first = np.unique(np.array(shapes_once)[table.shape[ranked]], return_index=True)
    for index in ranked[np.sort(first)][:_CLIMBS]:
        if rates[index] < _WORTH_CLIMBING * best:
            break
        best = max(best, _climbed_rate(table, table.primitive(int(index)), measure))
    return best


def _climbed_rate(
    table: PrimitiveTable, primitive: Primitive, measure: Callable[[FloatArray], FloatArray]
) -> float:
    """Compute the rate of the measure at the local maximum reached from a primitive, flown once."""
    shape, start = primitive.shape.once, primitive.displacement_rad
    joints = list(shape.joints)
    # Signed, so that the product with the displacements is the loop's duration.
    seconds = 2.0 * np.where(start < 0.0, -1.0, 1.0) / table.joint_rate_rad_s[joints]
    if shape.held is not None:
        seconds[shape.held] = 0.0
    room = table.limits_rad[joints] - table.start_rad[joints, None]
    shifts = _DIFFERENCE_RAD * np.hstack([np.zeros((len(start), 1)), np.eye(len(start)), -np.eye(len(start))])

    def slower(x: FloatArray) -> tuple[float, FloatArray]:
        columns = x[:, None] + shifts
        values = -measure(table.rotations(shape, columns)) / (seconds @ columns)
        forward, backward = np.split(values[1:], 2)
        return float(values[0]), (forward - backward) / (2.0 * _DIFFERENCE_RAD)

    # A loop that hardly moves hardly turns: no maximum is down there.
    least, most = (
        np.where(start > 0.0, 0.1 * start, room[:, 0]),
        np.where(start < 0.0, 0.1 * start, room[:, 1]),
    )
    bounds = optimize.Bounds(least, most)
    return -float(optimize.minimize(slower, start, jac=True, method="L-BFGS-B", bounds=bounds).fun)
