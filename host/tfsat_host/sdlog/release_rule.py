"""Releases by the rule of protocol/tfsat.toml, [release], on recorded edges, as the firmware's `ReleaseDetector`.

And those that the logger itself recorded, compared with them.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate

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
    """All releases by the rule, false ones included; watched for again when both have been closed.

    Args:
        edges: By time.
        start: Bit i: switch i is open before them.
        end_us: How long the switches are known to stay as the last edge left them.
    """
    releases: list[RuledRelease] = []
    state, watching = start, start == 0
    changed_us: int | None = None
    opening: RuledRelease | None = None  # the last of `releases` once it is certain
    settled = False
    for time_us, switch, is_open in [*edges, (end_us, -1, False)]:
        stood_us = 0 if changed_us is None else time_us - changed_us
        if opening and state == 0 and stood_us >= RELEASE_HUNG_US and not settled:
            opening.hung = True
        if stood_us >= RELEASE_DEBOUNCE_US and changed_us is not None:
            if state == ALL_OPEN:
                settled = stood_us >= RELEASE_CHATTER_US or settled
                if opening and opening.certain_us is None:
                    opening.certain_us = changed_us + RELEASE_DEBOUNCE_US
                    releases.append(opening)
            elif opening is None or opening.certain_us is None:
                if stood_us >= RELEASE_CHATTER_US or state == 0:
                    opening = None
                watching = watching or state == 0
            elif state == 0 and stood_us >= RELEASE_SEATED_US:
                opening.false_us, opening = changed_us + RELEASE_SEATED_US, None
        if switch < 0:
            break
        changed = state | 1 << switch if is_open else state & ~(1 << switch)
        if changed == state:
            continue
        state, changed_us = changed, time_us
        if state != ALL_OPEN or not watching:
            continue
        if opening is None:
            opening, settled = RuledRelease(time_us, time_us, time_us), False
        elif opening.certain_us is not None:
            opening.last_us = opening.last_us if settled else time_us
        else:
            opening.last_us, settled = time_us, False
            opening.first_us = max(opening.first_us, time_us - RELEASE_CHATTER_US)
            if time_us - opening.at_us > RELEASE_BOUNCE_US:
                opening.at_us = time_us
    return releases


def recorded_releases(events: Iterable[DropEvent]) -> tuple[list[int], list[int]]:
    """The logger's own `release` events: when those were that it never revoked, and those that it revoked.

    An event that revokes a release, because both switches closed again, has that release's time.
    """
    events = [event for event in events if event.name == "release"]
    revoked = {event.t_us for event in events if event.arg == 0}
    recorded = {event.t_us for event in events if event.arg != 0} - revoked
    return sorted(recorded), sorted(revoked)


def reconciled(
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
    reach = list(accumulate((span[1] for span in spans), max))
    remaining: list[int | None] = list(by_edges)
    certain: set[int] = set()
    without_edges = []
    for time_us in sorted((*recorded, *revoked)):
        i = bisect_left(by_edges, time_us - SAME_US)
        if i == len(by_edges) or by_edges[i] > time_us + SAME_US or remaining[i] is None:
            without_edges.append(time_us)
            continue
        remaining[i] = None
        if time_us not in revoked:
            certain.add(by_edges[i])
    for time_us in without_edges:
        before = bisect_right(starts, time_us)
        if not before or reach[before - 1] < time_us:
            continue
        # Its edges are lost: what shows it is the first edge after the loss, unless that is another's.
        i = bisect_left(by_edges, time_us)
        if i < len(by_edges) and by_edges[i] <= reach[before - 1] + RELEASE_CHATTER_US:
            remaining[i] = None
        if time_us not in revoked:
            certain.add(time_us)
    return sorted({time_us for time_us in remaining if time_us is not None} | certain), frozenset(certain)
