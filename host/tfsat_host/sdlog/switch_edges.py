"""The release switches' edges: those that the logger recorded, and those that only the samples show."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import BoolArray
from tfsat_host.protocol.limits import SWITCH_COUNT

from .events import DropEvent
from .release_rule import SwitchEdge

_ROWS_AT_A_TIME = 1 << 15
_NEVER_US = 1 << 62

Span = tuple[int, int]
"""Times in µs between which edges may be missing."""


def switch_edges(
    events: Sequence[DropEvent], t_us: NDArray[np.int64], switch_open: BoolArray, period_us: int
) -> tuple[list[SwitchEdge], list[Span]]:
    """All edges by time, and between when edges may be missing that the logger was too slow for or that are lost.

    An edge that only the samples show is dated at the first sample after it.

    Args:
        events: By time.
        t_us: (n,) sample times, at least one.
        switch_open: (n, 2) the switches at the samples.
        period_us: The time between samples.
    """
    recorded = [
        (event.t_us, event.index, event.arg != 0)
        for event in events
        if event.name == "switch_edge" and event.index < SWITCH_COUNT
    ]
    stamped = [event for event in events if event.name in ("switch_edge", "stroke")]
    # The value of such an event counts the edges before it that came too fast to be kept.
    missing = [
        (before.t_us, event.t_us) for before, event in pairwise([*stamped[:1], *stamped]) if event.value > 0
    ]
    edges, changes = list(recorded), _rows_at_changes(t_us, switch_open)
    for switch in range(SWITCH_COUNT):
        own = [edge for edge in recorded if edge[1] == switch]
        for span, is_open in _unrecorded(own, t_us, switch_open[:, switch], period_us, changes):
            edges.append((span[1], switch, is_open))
            missing.append(span)
    return sorted(edges, key=lambda edge: edge[0]), missing


def state_at_start(edges: Sequence[SwitchEdge], first_us: int, is_open: BoolArray) -> int:
    """Bits of the switches that were open before the first of `edges`: some may lie before the first sample.

    A recording that follows another holds what happened between the two.
    """
    state = sum(1 << i for i, now_open in enumerate(is_open.tolist()) if now_open)
    for time_us, switch, opened in reversed(edges):
        if time_us < first_us:
            state = state & ~(1 << switch) if opened else state | 1 << switch
    return state


def _unrecorded(
    edges: list[SwitchEdge],
    t_us: NDArray[np.int64],
    is_open: BoolArray,
    period_us: int,
    changes: NDArray[np.int64],
) -> list[tuple[Span, bool]]:
    """Changes of one switch that its samples show and its edges do not: between when, and to what."""
    edge_us = np.array([edge[0] for edge in edges], np.int64)
    first_us, first_open = t_us[0], bool(is_open[0])
    rows = np.unique(np.concatenate((changes, _rows_around(edge_us, t_us, period_us))))
    t_us, is_open = t_us[rows], is_open[rows]
    after = np.searchsorted(edge_us, t_us, side="right")
    padded = np.concatenate(([-_NEVER_US], edge_us, [_NEVER_US]))
    # A sample within a period of an edge may have been read on either side of it.
    clear = (t_us - padded[after] >= period_us) & (padded[after + 1] - t_us >= period_us)
    t_us, level, edges_before = t_us[clear], is_open[clear], after[clear]
    # What each sample is compared with: the sample before it, or an edge between the two.
    expected = np.array([first_open, *(edge[2] for edge in edges)])[edges_before]
    since_us = np.maximum(padded[edges_before], first_us)
    no_edge_between = np.flatnonzero(np.diff(edges_before) == 0)
    expected[no_edge_between + 1] = level[no_edge_between]
    since_us[no_edge_between + 1] = t_us[no_edge_between]
    return [((int(since_us[i]), int(t_us[i])), bool(level[i])) for i in np.flatnonzero(level != expected)]


def _rows_at_changes(t_us: NDArray[np.int64], switch_open: BoolArray) -> NDArray[np.int64]:
    """The samples on both sides of each change of a switch, few of millions; all of them where time goes back.

    With those around recorded edges they hold all that the samples know of the switches.
    """
    changes = [np.zeros(1, np.int64)]
    for begin in range(0, len(t_us) - 1, _ROWS_AT_A_TIME):
        rows = slice(begin, begin + _ROWS_AT_A_TIME + 1)
        times = t_us[rows]
        if (times[1:] < times[:-1]).any():
            return np.arange(len(t_us))
        for switch in range(switch_open.shape[1]):
            levels = np.ascontiguousarray(switch_open[rows, switch])
            changed = np.flatnonzero(levels[1:] != levels[:-1]) + begin
            changes += [changed, changed + 1]
    return np.concatenate(changes)


def _rows_around(edge_us: NDArray[np.int64], t_us: NDArray[np.int64], period_us: int) -> NDArray[np.int64]:
    """The samples around each edge, and a period before and after it."""
    moments = np.concatenate((edge_us - period_us, edge_us, edge_us + period_us))
    rows = (np.searchsorted(t_us, moments)[:, None] + np.arange(-2, 3)).ravel()
    return rows[(rows >= 0) & (rows < len(t_us))]
