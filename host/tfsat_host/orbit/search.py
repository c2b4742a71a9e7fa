"""Chains of primitives: by lookup, one best primitive after another, and by a beam search for the shortest time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tfsat_host.dynamics import quaternion
from tfsat_host.orbit.primitives import PrimitiveTable
from tfsat_host.orbit.time_to_go import TimeToGo
from tfsat_host.robot.model import FloatArray, IntArray

# Two states of the beam that differ by less are one.
_SAME_RAD = 0.005
# A primitive must bring the target nearer by this at least: rounding is no progress.
_LEAST_GAIN_RAD = 1e-9
# Where no chain reaches the goal, the search ends with those that would take so many times the estimate, and some
# loops more.
_PATIENCE = 1.5
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
    remaining = _remaining(table, needed)
    few = np.argpartition(remaining, min(count, len(table)) - 1)[:count]
    return np.asarray(few[np.argsort(remaining[few], kind="stable")])


def lookup(table: PrimitiveTable, needed: FloatArray, goal_rad: float, most: int) -> Route:
    """One best primitive after another, until `goal_rad` is reached or none brings the target nearer.

    The successive table lookup of the paper's section "Feedback control", before it is flown.
    """
    chain: list[int] = []
    left, duration = float(quaternion.angle(needed)), 0.0
    while left > goal_rad and len(chain) < most:
        best = int(nearest(table, needed, 1)[0])
        after = quaternion.product(table.undone[:, best], needed)
        remaining = float(quaternion.angle(after))
        if remaining > left - _LEAST_GAIN_RAD:
            break
        needed, left, duration = after, remaining, duration + float(table.duration_s[best])
        chain.append(best)
    return Route(tuple(chain), left, duration)


def search(
    table: PrimitiveTable,
    time_to_go: TimeToGo,
    needed: FloatArray,
    goal_rad: float,
    *,
    most: int,
    width: int = 32,
) -> Route:
    """The fastest chain that a beam search finds, never slower than the lookup's where that reaches the goal.

    Each level of the search tries every primitive after each of the `width` most promising chains: those with the
    least time so far plus estimated time to go.

    Args:
        table: The primitives.
        time_to_go: The estimate.
        needed: (4,) rotation from the present attitude to the target, body axes.
        goal_rad: What may be left.
        most: Most primitives in the chain.
        width: Chains that are kept a level.

    Returns:
        The chain; if none reaches the goal, the one that comes nearest.
    """
    best = lookup(table, needed, goal_rad, most)
    patience_s = _PATIENCE * float(time_to_go.seconds(needed)) + _LOOPS_MORE * float(table.duration_s.max())
    beam, times, chains = needed[:, None], np.zeros(1), np.empty((1, 0), dtype=np.int64)
    for _level in range(most):
        after = quaternion.product(table.undone[:, :, None], beam[:, None, :]).reshape(4, -1)
        spent = (table.duration_s[:, None] + times).reshape(-1)
        best = _better(best, after, spent, chains, goal_rad)
        worth = spent + time_to_go.seconds(after)
        limit = best.duration_s if best.remaining_rad <= goal_rad else patience_s
        kept = _promising(after, worth, limit, width)
        if not len(kept):
            break
        chains = np.column_stack([chains[kept % len(chains)], kept // len(chains)])
        beam, times = after[:, kept], spent[kept]
    return best


def _better(best: Route, after: FloatArray, spent: FloatArray, chains: IntArray, goal: float) -> Route:
    """The best of `best` and the new chains."""
    remaining = quaternion.angle(after)
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


def _promising(after: FloatArray, worth: FloatArray, limit: float, width: int) -> IntArray:
    """Indices of the `width` best states that are worth less than `limit` and differ from one another."""
    count = min(16 * width, len(worth))
    few = np.argpartition(worth, count - 1)[:count]
    few = few[np.argsort(worth[few], kind="stable")]
    few = few[worth[few] < limit]
    cells = np.round(quaternion.logarithm(after[:, few]) / _SAME_RAD).astype(np.int64)
    _, first = np.unique(cells, axis=1, return_index=True)
    return np.asarray(few[np.sort(first)][:width])


def _remaining(table: PrimitiveTable, needed: FloatArray) -> FloatArray:
    return quaternion.angle(quaternion.product(table.undone, needed[:, None]))
