"""What happened in the drop, on its axis of time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from typing import Literal

import numpy as np

from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.protocol.limits import SWITCH_COUNT
from tfsat_host.quantity import fields, number

Kind = Literal["release", "stroke", "landing", "switch", "gap", "other"]

BEFORE_S = 1.0
AFTER_S = 0.5
"""Events so long before the release and after the end of the evaluation belong to the drop."""
_AT_MOST = 60
"""A chattering line has thousands: more cannot be read."""
_NOT_SHOWN = {"stroke", "release", "landing", "switch_edge", "ring_high_water", "rewritten"}
"""The first four are shown as they were measured; the others say how the card kept up."""
_BOUNCE_US = 5_000


@dataclass(frozen=True, slots=True)
class EventMark:
    """A moment, or with `until_s` a span, of the drop; times in s after the release."""

    t_s: float
    kind: Kind
    label: str
    until_s: float | None = None


EVENT = fields("t_s kind label until_s")


def events_of(evaluation: Evaluation) -> list[EventMark]:
    """Return the events of a drop, sorted by time."""
    first, last = -BEFORE_S, evaluation.motion.samples.until_s + AFTER_S
    near = [event for event in _all(evaluation) if first <= event.t_s <= last]
    return sorted(near, key=lambda event: event.t_s)[:_AT_MOST]


def _all(evaluation: Evaluation) -> Iterator[EventMark]:
    log = evaluation.log
    yield EventMark(0.0, "release", "release")
    yield from _strokes(evaluation)
    yield from _landing_events(evaluation)
    yield from _switches(evaluation)
    for event in log.events:
        if event.name not in _NOT_SHOWN:
            yield EventMark(log.seconds(event.t_us), "other", event.name.replace("_", " "))
    for gap in log.gaps:
        if gap.start_us is not None and gap.end_us is not None:
            label = f"{gap.samples} samples lost" if gap.samples else "blocks lost, no samples in them"
            yield EventMark(log.seconds(gap.start_us), "gap", label, log.seconds(gap.end_us))


def _strokes(evaluation: Evaluation) -> Iterator[EventMark]:
    """Yield the strokes as flown; without a schedule, the edges of the stroke line."""
    for stroke in evaluation.strokes:
        # The best start that is known: as measured, as logged, as scheduled.
        begin = next(t for t in (stroke.start_s, stroke.logged_s, stroke.scheduled_s) if np.isfinite(t))
        turned = ", did not move"
        if stroke.moved:
            turned = f", {number(np.rad2deg(stroke.size_rad), '+.1f').replace('-', '−')} deg"
        label = f"{stroke.number}: joint {stroke.joint}{turned if evaluation.is_given() else ''}"
        yield EventMark(begin, "stroke", label, stroke.end_s if np.isfinite(stroke.end_s) else None)
    # Without a schedule the stroke line's edges are all that tells of strokes.
    if evaluation.schedule is None:
        for event in evaluation.log.events:
            if event.name == "stroke":
                yield EventMark(evaluation.log.seconds(event.t_us), "stroke", f"stroke {event.index + 1}")


def _landing_events(evaluation: Evaluation) -> Iterator[EventMark]:
    instants = evaluation.instants
    if instants.landing is not None:
        yield EventMark(instants.landing.t_s, "landing", "landing")
    elif instants.landing_logged_s is not None:
        yield EventMark(instants.landing_logged_s, "landing", "landing, as the logger recorded it")


def _switches(evaluation: Evaluation) -> Iterator[EventMark]:
    """Yield the release switches' edges, keeping the last edge of each bounce."""
    log = evaluation.log
    for index in range(SWITCH_COUNT):
        edges = [event for event in log.events if event.name == "switch_edge" and event.index == index]
        # Contacts bounce for milliseconds: of edges in quick succession the last one counts.
        for edge, following in zip_longest(edges, edges[1:]):
            if following is None or following.t_us - edge.t_us > _BOUNCE_US:
                state = "opened" if edge.arg else "closed"
                yield EventMark(log.seconds(edge.t_us), "switch", f"release switch {index + 1} {state}")
