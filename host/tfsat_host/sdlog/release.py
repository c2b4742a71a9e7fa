"""When the robot was released, by the sequencer's own rule, and how far that time can be trusted."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from tfsat_host.arrays import BoolArray, IntArray
from tfsat_host.protocol.limits import (
    LANDING_LATEST_US,
    PAUSE_MIN_US,
    RELEASE_BOUNCE_US,
    RELEASE_DEBOUNCE_US,
    RELEASE_SEATED_US,
    SAMPLES_PER_BLOCK,
)

from .events import DropEvent
from .ledger import Gap
from .release_rule import (
    ALL_OPEN,
    RuledRelease,
    Span,
    SwitchEdge,
    reconcile_releases,
    recorded_releases,
    releases_by_rule,
    state_at_start,
    switch_edges,
)

_BACKLOG_BLOCKS = 2
"""Edges wait for a free event slot, so a lost block may hold edges from before its first sample."""
_STEPS_LOOKED_AT = 1 << 16
# Beyond every time that is believed (LATEST_TIME_US).
_NEVER_US = 1 << 62


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
    events: Sequence[DropEvent], t_us: IntArray, switch_open: BoolArray, gaps: Sequence[Gap] = ()
) -> Release | None:
    """Find the last release before the first stroke, else before the landing, else of all.

    None if there is no release. A release that the logger revoked is none. One that it recorded itself is
    certain, whatever edges are lost.

    Events and sample times (n,) are by time. The switches at the samples (n, 2) show edges that are not in
    the log; `gaps` are where blocks or samples are lost.
    """
    if not len(t_us):
        return None
    period_us = _usual_step_us(t_us)
    first_us, last_us = int(t_us[0]), int(t_us[-1])
    # Recorded edges, completed by the levels of the samples, and the spans that may hide more.
    edges, missing = switch_edges(events, t_us, switch_open, period_us)
    # A lost block may hold edges that waited for a slot: its gap begins that much earlier.
    backlog_us = _BACKLOG_BLOCKS * SAMPLES_PER_BLOCK * period_us
    holes = [
        (first_us if gap.start_us is None else gap.start_us - backlog_us, gap.end_us)
        for gap in gaps
        if gap.end_us is not None
    ]
    missing += holes
    # Replay the rule of all three programs over the edges, the last level held to the end of the log.
    start = state_at_start(edges, first_us, switch_open[0])
    ruled = releases_by_rule(edges, start, max(last_us, edges[-1][0] if edges else 0))
    left_us = {release.at_us: release.left_us for release in ruled}
    by_edges = [release.at_us for release in ruled if not _is_false(release, events)]
    # Where the start is lost, edges may be missing from any time before the first sample.
    before_start = [(-_NEVER_US, first_us) for gap in gaps if gap.start_us is None]
    # The logger saw every edge in time: a release that it recorded is certain, whatever is lost.
    recorded, revoked = recorded_releases(events)
    releases, certain = reconcile_releases(by_edges, recorded, revoked, missing + before_start)
    latest_us, chosen = _choose(releases, events, period_us)
    if chosen is None:
        return None
    is_certain = chosen in certain
    # Between the nearest quiet debounces, edges that are missing could still move t = 0.
    begin, end = _window(chosen, edges, start, missing)
    end = max(end, end if latest_us is None else latest_us)

    def may_move_it(span: Span) -> bool:
        if is_certain:
            # Only a missing closing and another release could: that takes longer than most gaps.
            return chosen < span[1] and span[0] <= end and span[1] - span[0] >= RELEASE_SEATED_US
        return span[1] >= begin and span[0] <= end and not _is_chatter(span, chosen)

    # The uncertainty reaches over every missing span that may move the release.
    moving = [span for span in missing if may_move_it(span)]
    return Release(
        t_us=chosen,
        earliest_us=chosen if is_certain else min([chosen, *(span[0] for span in moving)]),
        latest_us=max([chosen, *(span[1] for span in moving)]),
        left_us=left_us.get(chosen, (chosen, chosen)),
        touches_gap=any(may_move_it(span) for span in holes),
        contradicts_us=None if is_certain or moving else _last_before(recorded, latest_us),
    )


def _is_false(release: RuledRelease, events: Sequence[DropEvent]) -> bool:
    """Return whether both switches closed again before the landing and before any stroke.

    Closed switches mean nothing after the landing. Strokes that were flown count from the release, whatever
    became of the robot.
    """
    landings = (event.t_us for event in events if event.name == "landing" and event.t_us > release.at_us)
    # Without a landing in the log, the latest time at which a fall can have ended.
    landed_us = next(landings, release.at_us + LANDING_LATEST_US)
    if release.false_us is None or release.false_us >= landed_us:
        return False
    strokes = (event.t_us for event in events if event.name == "stroke")
    return not any(release.at_us < t_us < release.false_us for t_us in strokes)


def _choose(
    releases: list[int], events: Sequence[DropEvent], tolerance_us: int
) -> tuple[int | None, int | None]:
    """Return the latest time that the release can have, None if unknown, and the release chosen."""
    stroke_us = next((event.t_us for event in events if event.name == "stroke"), None)
    landing_us = next((event.t_us for event in events if event.name == "landing"), None)
    if stroke_us is None:
        # No stroke was flown: the last release up to the landing, or of all.
        before = [release for release in releases if landing_us is None or release <= landing_us]
        return landing_us, before[-1] if before else None
    # No maneuver strokes before its pause is over, so the release lies at least that far back.
    latest_us = stroke_us - PAUSE_MIN_US
    # A release that only the samples show is dated late: allow for it, the first stroke is certain.
    before = [release for release in releases if release <= latest_us + tolerance_us]
    # Rather a release too close to the stroke than none.
    if not before:
        before = [release for release in releases if release <= stroke_us]
    return latest_us, before[-1] if before else None


def _last_before(recorded: Sequence[int], latest_us: int | None) -> int | None:
    """Return the logger's own choice: its last release before `latest_us`, else the first after it."""
    before = [time_us for time_us in recorded if latest_us is None or time_us <= latest_us]
    return next(iter([*before[-1:], *recorded]), None)


def _usual_step_us(t_us: IntArray) -> int:
    """Return the median time between samples; a long recording is subsampled."""
    # A median over every k-th step is as good, and bounded in time.
    every = len(t_us) // _STEPS_LOOKED_AT + 1
    before = np.arange(0, len(t_us) - 1, every)
    return int(np.median(t_us[before + 1] - t_us[before])) if len(before) else 0


def _window(release_us: int, edges: Sequence[SwitchEdge], start: int, missing: Sequence[Span]) -> Span:
    """Return the interval in which missing edges would change the release.

    It reaches from one known quiet debounce to the next.
    """
    times = [edge[0] for edge in edges]
    # State of the switches after each edge, so that any moment's is found by bisection.
    states = list(accumulate(edges, _state_after, initial=start))
    # Edges are points, missing spans intervals; in all the time between, the switches were quiet.
    busy = sorted([*((time_us, time_us) for time_us in times), *missing])
    begin, end, quiet_from_us = busy[0][0], release_us, -_NEVER_US
    for first_us, last_us in [*busy, (_NEVER_US, _NEVER_US)]:
        quiet_us = first_us - quiet_from_us
        if quiet_us >= RELEASE_DEBOUNCE_US:
            # A whole debounce of quiet fixes the state: it may bar the release from what lies beyond.
            state = states[bisect_right(times, quiet_from_us)]
            # Edges with one switch open may belong to the same bounce.
            apart = state == 0 or quiet_us > RELEASE_BOUNCE_US
            if first_us <= release_us and state != ALL_OPEN and apart:
                begin = first_us
            if quiet_from_us >= release_us and state == ALL_OPEN:
                end = quiet_from_us
                break
        quiet_from_us = max(quiet_from_us, last_us)
    return begin, end


def _state_after(state: int, edge: SwitchEdge) -> int:
    _, switch, is_open = edge
    return state | 1 << switch if is_open else state & ~(1 << switch)


def _is_chatter(span: Span, release_us: int) -> bool:
    """Too short to hide a closing, and after both were open for the first time: it cannot move the release."""
    first_us, last_us = span
    short = last_us - first_us < RELEASE_DEBOUNCE_US
    return short and first_us >= release_us and last_us - release_us <= RELEASE_BOUNCE_US
