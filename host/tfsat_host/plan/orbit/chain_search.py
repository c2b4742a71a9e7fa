"""Chains of primitives of the table for a rotation: by lookup, or by a beam search for the shortest time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray, IntArray
from tfsat_host.dynamics import quaternion
from tfsat_host.plan.orbit.primitives import PrimitiveTable
from tfsat_host.plan.orbit.time_to_go import TimeToGo

# Two states of the beam that differ by less are one.
_SAME_RAD = 0.005
# A primitive must bring the target nearer by this at least: rounding is no progress.
_MIN_GAIN_RAD = 1e-9
# The time to go counts so many times more where chains of as many primitives are compared: short primitives that
# bring the target hardly nearer would crowd out long ones that do.
_TO_GO_WEIGHT = 1.3
# Where no chain reaches the goal, the search ends with those that would take so many times the estimate, and some
# loops more.
_MAX_COST_RATIO = 1.5
_LOOPS_MORE = 2.0
_BEAM_WIDTH = 32
"""Chains kept per level of the search."""


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
    remaining = quaternion.angle(quaternion.product(table.undone, needed[:, None]))
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
) -> Route:
    """Find the fastest chain by beam search, never slower than the lookup's if that reaches the goal.

    Each level of the search appends every primitive to each of the `_BEAM_WIDTH` most promising chains: those
    with the least time so far plus, weighted, the estimated time to go.

    Args:
        table: The primitives.
        time_to_go: The estimate of the time to go.
        needed: (4,) rotation from the present attitude to the target, body axes.
        goal_rad: Greatest permissible remaining angle.
        most: Most primitives in the chain.

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
        to_go = time_to_go.seconds(after)
        # Without an incumbent a generous multiple of the estimate ends hopeless searches.
        limit = best.duration_s if best.remaining_rad <= goal_rad else patience_s
        survivors = _select_promising(after, spent, to_go, limit)
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


def _select_promising(after: FloatArray, spent: FloatArray, to_go: FloatArray, limit: float) -> IntArray:
    """Indices of the `_BEAM_WIDTH` best states that take less than `limit` by the estimate and differ."""
    worth = spent + _TO_GO_WEIGHT * to_go
    # Take sixteen candidates a place: many of them fall into the same cell below.
    count = min(16 * _BEAM_WIDTH, len(worth))
    few = np.argpartition(worth, count - 1)[:count]
    few = few[np.argsort(worth[few], kind="stable")]
    few = few[spent[few] + to_go[few] < limit]
    # Keep one state a cell of rotation vectors: near-duplicates would crowd the beam.
    cells = np.round(quaternion.logarithm(after[:, few]) / _SAME_RAD).astype(np.int64)
    _, first = np.unique(cells, axis=1, return_index=True)
    # `unique` orders by cell; sorting its indices restores the order of worth.
    return np.asarray(few[np.sort(first)][:_BEAM_WIDTH])
