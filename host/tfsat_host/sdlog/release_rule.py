"""The release switches' edges, recorded or shown by the samples alone; releases by the rule on them.

The rule is that of protocol/tfsat.toml, [release], as the firmware's `ReleaseDetector`. The releases that the logger
itself recorded are compared with those.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np

from tfsat_host.arrays import BoolArray, IntArray
from tfsat_host.protocol.limits import (
    RELEASE_BOUNCE_US,
    RELEASE_CHATTER_US,
    RELEASE_DEBOUNCE_US,
    RELEASE_HUNG_US,
    RELEASE_SEATED_US,
    SWITCH_COUNT,
)

from .events import DropEvent

ALL_OPEN = (1 << SWITCH_COUNT) - 1

SwitchEdge = tuple[int, int, bool]
"""Time in µs, switch from 0, whether it opened."""
SAME_US = 4
"""Edges and recorded releases are stamped alike; only the rule's half-microsecond ticks round between them."""


@dataclass(slots=True)
class RuledRelease:
    """A release by the rule.

    Attributes:
        at_us: t = 0 of the schedule.
        first_us: Both were open for the first time, at most RELEASE_CHATTER_US before the last.
        last_us: And for the last time before the interval was settled.
        hung: The robot may have hung between the two.
        certain_us: When the rule decides it; None before.
        false_us: When the rule decides that it was a false one; None if it was not.
    """

    at_us: int
    first_us: int
    last_us: int
    hung: bool = False
    certain_us: int | None = None
    false_us: int | None = None

    @property
    def left_us(self) -> tuple[int, int]:
        """Between when the robot left; the same time twice where the edges fit one release only."""
        ambiguous = self.hung or self.last_us - self.first_us > RELEASE_BOUNCE_US
        return (self.first_us, self.last_us) if ambiguous else (self.at_us, self.at_us)


def releases_by_rule(edges: Sequence[SwitchEdge], start: int, end_us: int) -> list[RuledRelease]:
    """Find all releases by the rule, false ones included.

    The rule watches for a release again once both switches have been closed.

    Bit i of `start`: switch i is open before the edges, which are by time. `end_us` is how long the switches
    are known to stay as the last edge left them.
    """
    releases: list[RuledRelease] = []
    state, watching = start, start == 0
    changed_us: int | None = None
    opening: RuledRelease | None = None  # the last of `releases` once it is certain
    settled = False
    # A last entry without a switch lets the rule judge the final state up to end_us.
    for time_us, switch, is_open in [*edges, (end_us, -1, False)]:
        stood_us = 0 if changed_us is None else time_us - changed_us
        if opening and state == 0 and stood_us >= RELEASE_HUNG_US and not settled:
            # Bouncing contacts are not closed together for so long: a blow may have come first.
            opening.hung = True
        if stood_us >= RELEASE_DEBOUNCE_US and changed_us is not None:
            if state == ALL_OPEN:
                # Both open for a debounce: a release. For the chatter time: its interval is settled.
                settled = stood_us >= RELEASE_CHATTER_US or settled
                if opening and opening.certain_us is None:
                    opening.certain_us = changed_us + RELEASE_DEBOUNCE_US
                    releases.append(opening)
            elif opening is None or opening.certain_us is None:
                # Not certain yet: both closed for a debounce, or one for the chatter time, cancel it.
                if stood_us >= RELEASE_CHATTER_US or state == 0:
                    opening = None
                watching = watching or state == 0
            elif state == 0 and stood_us >= RELEASE_SEATED_US:
                # In a fall nothing closes both for so long: the robot hangs, it was a jolt.
                opening.false_us, opening = changed_us + RELEASE_SEATED_US, None
        if switch < 0:
            break
        changed = state | 1 << switch if is_open else state & ~(1 << switch)
        # A level repeated is no edge and must not restart the debounce.
        if changed == state:
            continue
        state, changed_us = changed, time_us
        if state != ALL_OPEN or not watching:
            continue
        if opening is None:
            # Both open for the first time: t = 0 unless the contacts bounce for longer than sound ones.
            opening, settled = RuledRelease(time_us, time_us, time_us), False
        elif opening.certain_us is not None:
            # Once the release is certain, further openings only widen the interval until it is settled.
            opening.last_us = opening.last_us if settled else time_us
        else:
            # Still bouncing: the interval keeps no more than the chatter time before its last opening.
            opening.last_us, settled = time_us, False
            opening.first_us = max(opening.first_us, time_us - RELEASE_CHATTER_US)
            # Of openings further apart than sound contacts bounce, t = 0 is the first of the later ones.
            if time_us - opening.at_us > RELEASE_BOUNCE_US:
                opening.at_us = time_us
    return releases


def recorded_releases(events: Iterable[DropEvent]) -> tuple[list[int], list[int]]:
    """Return the times of the logger's own `release` events: those never revoked, and those revoked.

    An event that revokes a release, because both switches closed again, has that release's time.
    """
    events = [event for event in events if event.name == "release"]
    revoked = {event.t_us for event in events if event.arg == 0}
    recorded = {event.t_us for event in events if event.arg != 0} - revoked
    return sorted(recorded), sorted(revoked)


def reconcile_releases(
    by_edges: Sequence[int],
    recorded: Sequence[int],
    revoked: Sequence[int],
    missing: Iterable[tuple[int, int]],
) -> tuple[list[int], frozenset[int]]:
    """Releases by the edges and by the logger's own events, the revoked ones left out.

    A recorded release whose edges are not in the log counts if they may be lost. If they cannot be, it
    contradicts the edges: they stand, and the caller reports it.

    Args:
        by_edges: Releases by the switch edges, by time.
        recorded, revoked: Of `recorded_releases`.
        missing: Times between which edges may be missing.

    Returns:
        Releases that may be the drop's, by time; and those that the logger recorded too, certain to the microsecond.
    """
    spans = sorted(missing)
    starts = [span[0] for span in spans]
    # The running maximum of the spans' ends: one bisection tells whether a time lies in any.
    reach = list(accumulate((span[1] for span in spans), max))
    remaining: list[int | None] = list(by_edges)
    certain: set[int] = set()
    without_edges = []
    for time_us in sorted((*recorded, *revoked)):
        # Pair each recorded release with the rule's at the same time, each of the rule's once.
        i = bisect_left(by_edges, time_us - SAME_US)
        if i == len(by_edges) or by_edges[i] > time_us + SAME_US or remaining[i] is None:
            without_edges.append(time_us)
            continue
        remaining[i] = None
        if time_us not in revoked:
            certain.add(by_edges[i])
    for time_us in without_edges:
        before = bisect_right(starts, time_us)
        # No edge can be missing there: the record contradicts complete edges, and they stand.
        if not before or reach[before - 1] < time_us:
            continue
        # Its edges are lost: what shows it is the first edge after the loss, unless that is another's.
        i = bisect_left(by_edges, time_us)
        if i < len(by_edges) and by_edges[i] <= reach[before - 1] + RELEASE_CHATTER_US:
            remaining[i] = None
        if time_us not in revoked:
            certain.add(time_us)
    return sorted({time_us for time_us in remaining if time_us is not None} | certain), frozenset(certain)


_ROWS_AT_A_TIME = 1 << 15
_NEVER_US = 1 << 62

Span = tuple[int, int]
"""Times in µs between which edges may be missing."""


def switch_edges(
    events: Sequence[DropEvent], t_us: IntArray, switch_open: BoolArray, period_us: int
) -> tuple[list[SwitchEdge], list[Span]]:
    """Return all edges by time, and the spans in which edges may be missing.

    Edges are missing if the logger was too slow for them or if they are lost. An edge that only the samples
    show is dated at the first sample after it.

    Events are by time; sample times (n,), at least one, are `period_us` apart; the switches at the samples
    are (n, 2).
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
    # Add what the samples' levels show of each switch and its recorded edges do not.
    for switch in range(SWITCH_COUNT):
        own = [edge for edge in recorded if edge[1] == switch]
        for span, is_open in _find_unrecorded_changes(own, t_us, switch_open[:, switch], period_us, changes):
            edges.append((span[1], switch, is_open))
            missing.append(span)
    return sorted(edges, key=lambda edge: edge[0]), missing


def state_at_start(edges: Sequence[SwitchEdge], first_us: int, is_open: BoolArray) -> int:
    """Bits of the switches that were open before the first of `edges`: some may lie before the first sample.

    A recording that follows another holds what happened between the two.
    """
    state = sum(1 << i for i, now_open in enumerate(is_open.tolist()) if now_open)
    # Undo the edges before the first sample, the latest first.
    for time_us, switch, opened in reversed(edges):
        if time_us < first_us:
            state = state & ~(1 << switch) if opened else state | 1 << switch
    return state


def _find_unrecorded_changes(
    edges: list[SwitchEdge], t_us: IntArray, is_open: BoolArray, period_us: int, changes: IntArray
) -> list[tuple[Span, bool]]:
    """Changes of one switch that its samples show and its edges do not: between when, and to what."""
    # Only samples beside an edge or a change of level can disagree with the edges: few of millions.
    edge_us = np.array([edge[0] for edge in edges], np.int64)
    first_us, first_open = t_us[0], bool(is_open[0])
    rows = np.unique(np.concatenate((changes, _rows_around(edge_us, t_us, period_us))))
    t_us, is_open = t_us[rows], is_open[rows]
    # How many edges lie before each sample; sentinels spare the cases of none before and none after.
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


def _rows_at_changes(t_us: IntArray, switch_open: BoolArray) -> IntArray:
    """Return the samples on both sides of each change of a switch; all samples if time goes back.

    These are few of millions. With the samples around recorded edges they hold all that the samples tell about
    the switches.
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


def _rows_around(edge_us: IntArray, t_us: IntArray, period_us: int) -> IntArray:
    """Return the samples around each edge, and around one period before and after it."""
    moments = np.concatenate((edge_us - period_us, edge_us, edge_us + period_us))
    rows = (np.searchsorted(t_us, moments)[:, None] + np.arange(-2, 3)).ravel()
    return rows[(rows >= 0) & (rows < len(t_us))]
