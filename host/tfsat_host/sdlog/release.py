"""When the robot was released, by the sequencer's own rule, and how far that time can be trusted."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.limits import (
    LANDING_LATEST_US,
    PAUSE_MIN_US,
    RELEASE_BOUNCE_US,
    RELEASE_DEBOUNCE_US,
    RELEASE_SEATED_US,
    SAMPLES_PER_BLOCK,
    SWITCH_COUNT,
)

from .events import DropEvent
from .ledger import Gap
from .release_rule import (
    ALL_OPEN,
    RuledRelease,
    SwitchEdge,
    compared,
    recorded_releases,
    releases_by_rule,
)

_BACKLOG_BLOCKS = 2
"""Edges wait for a free event slot, so a lost block may hold edges from before its first sample."""
_ROWS_AT_A_TIME = 1 << 15
_STEPS_LOOKED_AT = 1 << 16
_NEVER_US = 1 << 62

Span = tuple[int, int]
"""Times in µs between which edges may be missing."""


@dataclass(frozen=True)
class Release:
    """A release by the rule, t = 0 of the schedule, and what is not certain of it.

    Attributes:
        t_us: The logger's clock.
        earliest_us: The rule's release cannot have been before; `t_us` if its edges are all there.
        latest_us: It cannot have been after.
        left_us: Between when the robot left: not the same time twice where the edges fit two releases.
        touches_gap: Blocks or samples that are lost may hold its edges.
        contradicts_us: Another time, at which the logger recorded a release that the edges do not show, and
            nothing is lost that would explain it.
    """

    t_us: int
    earliest_us: int
    latest_us: int
    left_us: Span
    touches_gap: bool
    contradicts_us: int | None = None

    @property
    def uncertainty_us(self) -> int:
        """The most by which the robot may have left before or after `t_us`."""
        earliest_us, latest_us = self.interval_us
        return max(self.t_us - earliest_us, latest_us - self.t_us)

    @property
    def interval_us(self) -> Span:
        """Between when the robot left, lost edges counted too."""
        return min(self.earliest_us, self.left_us[0]), max(self.latest_us, self.left_us[1])


def find_release(
    events: Sequence[DropEvent],
    t_us: NDArray[np.int64],
    switch_open: NDArray[np.bool_],
    gaps: Sequence[Gap] = (),
) -> Release | None:
    """The last release before the first stroke, else before the landing, else of all; None without one.

    A release that the logger revoked is none. One that it recorded itself is certain, whatever edges are lost.

    Args:
        events: By time.
        t_us: (n,) sample times.
        switch_open: (n, 2) the switches at the samples: they show edges that are not in the log.
        gaps: Where blocks or samples are lost.
    """
    if not len(t_us):
        return None
    period_us = _usual_step_us(t_us)
    recorded = [
        (event.t_us, event.index, event.arg != 0)
        for event in events
        if event.name == "switch_edge" and event.index < SWITCH_COUNT
    ]
    edges, unseen = list(recorded), _lost_before_edges(events)
    changes = _rows_beside_changes(t_us, switch_open)
    for switch in range(SWITCH_COUNT):
        own = [edge for edge in recorded if edge[1] == switch]
        for (before_us, after_us), is_open in _unrecorded(
            own, t_us, switch_open[:, switch], period_us, changes
        ):
            edges.append((after_us, switch, is_open))
            unseen.append((before_us, after_us))
    edges.sort(key=lambda edge: edge[0])
    backlog_us = _BACKLOG_BLOCKS * SAMPLES_PER_BLOCK * period_us
    holes = [
        (int(t_us[0]) if gap.start_us is None else gap.start_us - backlog_us, gap.end_us)
        for gap in gaps
        if gap.end_us is not None
    ]
    start = _state_at_start(edges, int(t_us[0]), switch_open[0])
    ruled = releases_by_rule(edges, start, max(int(t_us[-1]), edges[-1][0] if edges else 0))
    left_us = {release.at_us: release.left_us for release in ruled}
    shown = [release.at_us for release in ruled if not _is_false(release, events)]
    before_start = [(-_NEVER_US, int(t_us[0])) for gap in gaps if gap.start_us is None]
    believed, revoked = recorded_releases(events)
    releases, certain = compared(shown, believed, revoked, unseen + holes + before_start)
    latest_us, chosen = _choose(releases, events, period_us)
    if chosen is None:
        return None
    begin, end = _window(chosen, edges, start, unseen + holes)
    if latest_us is not None:
        end = max(end, latest_us)
    is_certain = chosen in certain

    def may_move_it(span: Span) -> bool:
        if is_certain:
            # Only an unseen closing and another release could: that takes longer than most gaps.
            return chosen < span[1] and span[0] <= end and span[1] - span[0] >= RELEASE_SEATED_US
        return span[1] >= begin and span[0] <= end and not _is_chatter(span, chosen)

    near = [span for span in unseen + holes if may_move_it(span)]
    return Release(
        chosen,
        chosen if is_certain else min([chosen, *(span[0] for span in near)]),
        max([chosen, *(span[1] for span in near)]),
        left_us.get(chosen, (chosen, chosen)),
        any(may_move_it(span) for span in holes),
        None if is_certain or near else _last_before(believed, latest_us),
    )


def _is_false(release: RuledRelease, events: Sequence[DropEvent]) -> bool:
    """Whether both switches closed again before the landing, which ends what they mean, and before a stroke.

    Strokes that were flown count from it, whatever became of the robot.
    """
    landings = (event.t_us for event in events if event.name == "landing" and event.t_us > release.at_us)
    landed_us = next(landings, release.at_us + LANDING_LATEST_US)
    if release.false_us is None or release.false_us >= landed_us:
        return False
    strokes = (event.t_us for event in events if event.name == "stroke")
    return not any(release.at_us < t_us < release.false_us for t_us in strokes)


def _state_at_start(edges: Sequence[SwitchEdge], first_us: int, is_open: NDArray[np.bool_]) -> int:
    """Bits of the switches that were open before the first of `edges`: some may lie before the first sample.

    A recording that follows another holds what happened between the two.
    """
    state = sum(1 << i for i, now_open in enumerate(is_open.tolist()) if now_open)
    for time_us, switch, opened in reversed(edges):
        if time_us < first_us:
            state = state & ~(1 << switch) if opened else state | 1 << switch
    return state


def _choose(
    releases: list[int], events: Sequence[DropEvent], tolerance_us: int
) -> tuple[int | None, int | None]:
    """Until when the release must have been, None if unknown; and the release."""
    stroke_us = next((event.t_us for event in events if event.name == "stroke"), None)
    landing_us = next((event.t_us for event in events if event.name == "landing"), None)
    if stroke_us is None:
        before = [release for release in releases if landing_us is None or release <= landing_us]
        return landing_us, before[-1] if before else None
    latest_us = stroke_us - PAUSE_MIN_US
    # A release that only the samples show is dated late: allow for it, the first stroke is certain.
    before = [release for release in releases if release <= latest_us + tolerance_us]
    if not before:
        before = [release for release in releases if release <= stroke_us]
    return latest_us, before[-1] if before else None


def _last_before(believed: Sequence[int], latest_us: int | None) -> int | None:
    """The logger's own choice: its last release before `latest_us`, else the first after it."""
    before = [time_us for time_us in believed if latest_us is None or time_us <= latest_us]
    return next(iter([*before[-1:], *believed]), None)


def _lost_before_edges(events: Sequence[DropEvent]) -> list[Span]:
    """Where edges came too fast for the logger to keep."""
    stamped = [event for event in events if event.name in ("switch_edge", "stroke")]
    spans = []
    for i, event in enumerate(stamped):
        if event.value > 0:
            spans.append((stamped[i - 1].t_us if i else event.t_us, event.t_us))
    return spans


def _unrecorded(
    edges: list[SwitchEdge],
    t_us: NDArray[np.int64],
    is_open: NDArray[np.bool_],
    period_us: int,
    changes: NDArray[np.int64] | None,
) -> list[tuple[Span, bool]]:
    """Changes of one switch that its samples show and its edges do not: between when, and to what."""
    edge_us = np.array([edge[0] for edge in edges], np.int64)
    first_us, first_open = t_us[0], bool(is_open[0])
    if changes is not None:
        telling = np.sort(np.concatenate((changes, _rows_beside(edge_us, t_us, period_us))))
        telling = telling[np.diff(telling, prepend=-1) > 0]
        t_us, is_open = t_us[telling], is_open[telling]
    after = np.searchsorted(edge_us, t_us, side="right")
    padded = np.concatenate(([-_NEVER_US], edge_us, [_NEVER_US]))
    # A sample within a period of an edge may have been read on either side of it.
    clear = (t_us - padded[after] >= period_us) & (padded[after + 1] - t_us >= period_us)
    rows = np.flatnonzero(clear)
    if not len(rows):
        return []
    segment, level = after[rows], is_open[rows]
    before = np.array([first_open, *(edge[2] for edge in edges)])[segment]
    before_us = np.maximum(padded[segment], first_us)
    same = np.flatnonzero(segment[1:] == segment[:-1]) + 1
    before[same], before_us[same] = level[same - 1], t_us[rows[same - 1]]
    return [
        ((int(before_us[i]), int(t_us[rows[i]])), bool(level[i])) for i in np.flatnonzero(level != before)
    ]


def _rows_beside_changes(t_us: NDArray[np.int64], switch_open: NDArray[np.bool_]) -> NDArray[np.int64] | None:
    """The samples on both sides of each change of a switch, few of millions; None where time goes back.

    With those around recorded edges they hold all that the samples know of the switches.
    """
    changes = [np.zeros(1, np.int64)]
    for begin in range(0, len(t_us) - 1, _ROWS_AT_A_TIME):
        rows = slice(begin, begin + _ROWS_AT_A_TIME + 1)
        times = t_us[rows]
        if (times[1:] < times[:-1]).any():
            return None
        for switch in range(switch_open.shape[1]):
            levels = np.ascontiguousarray(switch_open[rows, switch])
            changed = np.flatnonzero(levels[1:] != levels[:-1]) + begin
            changes += [changed, changed + 1]
    return np.concatenate(changes)


def _rows_beside(edge_us: NDArray[np.int64], t_us: NDArray[np.int64], period_us: int) -> NDArray[np.int64]:
    """The samples around each edge, and a period before and after it."""
    moments = np.concatenate((edge_us - period_us, edge_us, edge_us + period_us))
    rows = (np.searchsorted(t_us, moments)[:, None] + np.arange(-2, 3)).ravel()
    return rows[(rows >= 0) & (rows < len(t_us))]


def _usual_step_us(t_us: NDArray[np.int64]) -> int:
    """The median time between samples; of a long recording, at some of them."""
    every = len(t_us) // _STEPS_LOOKED_AT + 1
    before = np.arange(0, len(t_us) - 1, every)
    return int(np.median(t_us[before + 1] - t_us[before])) if len(before) else 0


def _window(release_us: int, edges: list[SwitchEdge], start: int, unseen: list[Span]) -> Span:
    """From when to when unseen edges would change the release: up to a debounce of known quiet."""
    marks = sorted({edge[0] for edge in edges} | {time_us for span in unseen for time_us in span})
    spans = sorted(unseen)
    span_starts = [span[0] for span in spans]
    reach_us = list(accumulate((span[1] for span in spans), max))
    begin = end = release_us
    found_begin = False
    state, next_edge = start, 0
    previous: int | None = None
    for mark in [*marks, _NEVER_US]:
        quiet_us = _NEVER_US if previous is None else mark - previous
        if quiet_us >= RELEASE_DEBOUNCE_US:
            started = 0 if previous is None else bisect_right(span_starts, previous)
            known = not started or reach_us[started - 1] < mark
            # Edges with one switch open may belong to the same bounce.
            apart = state == 0 or quiet_us > RELEASE_BOUNCE_US
            if known and mark <= release_us and state != ALL_OPEN and apart:
                begin, found_begin = mark, True
            if known and previous is not None and previous >= release_us and state == ALL_OPEN:
                end = previous
                break
        while next_edge < len(edges) and edges[next_edge][0] <= mark:
            _, switch, is_open = edges[next_edge]
            state = state | 1 << switch if is_open else state & ~(1 << switch)
            next_edge += 1
        previous = mark
    return (begin if found_begin else marks[0]), end


def _is_chatter(span: Span, release_us: int) -> bool:
    """Too short to hide a closing, and after both were open for the first time: it cannot move the release."""
    first_us, last_us = span
    short = last_us - first_us < RELEASE_DEBOUNCE_US
    return short and first_us >= release_us and last_us - release_us <= RELEASE_BOUNCE_US
