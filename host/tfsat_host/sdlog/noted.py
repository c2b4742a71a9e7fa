"""Which releases the logger itself noted, and which of those that the switch edges tell they are."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate

from tfsat_host.protocol.limits import RELEASE_CHATTER_US

from .events import DropEvent

SAME_US = 4
"""Edges and noted releases are stamped alike; only the rule's half-microsecond ticks round between them."""


@dataclass(frozen=True)
class Noted:
    """The logger's `release` events.

    Attributes:
        believed_us: Releases that it never took back, by time.
        revoked_us: Releases that were none: both switches closed again.
    """

    believed_us: tuple[int, ...]
    revoked_us: tuple[int, ...]


@dataclass(frozen=True)
class Candidates:
    """Releases that may be the drop's.

    Attributes:
        at_us: By time.
        noted_us: Those of them that the logger noted too: they are certain to the microsecond.
    """

    at_us: list[int]
    noted_us: frozenset[int]


def read_noted(events: Iterable[DropEvent]) -> Noted:
    """What the logger noted; an event that revokes a release carries that release's time."""
    events = [event for event in events if event.name == "release"]
    revoked = {event.t_us for event in events if event.arg == 0}
    believed = {event.t_us for event in events if event.arg != 0} - revoked
    return Noted(tuple(sorted(believed)), tuple(sorted(revoked)))


def set_against(told: Sequence[int], noted: Noted, unseen: Iterable[tuple[int, int]]) -> Candidates:
    """Take out what was revoked; where edges are lost, take the time that the logger noted.

    A noted release whose edges are not in the log counts if they may be lost. If they cannot be, it
    contradicts the edges: they stand, and the caller says so.

    Args:
        told: Releases by the switch edges, by time.
        noted: By the logger.
        unseen: Times between which edges may be missing.
    """
    spans = sorted(unseen)
    starts = [span[0] for span in spans]
    reach = list(accumulate((span[1] for span in spans), max))
    left: list[int | None] = list(told)
    kept: set[int] = set()
    unmatched = []
    revoked = frozenset(noted.revoked_us)
    for time_us in sorted((*noted.believed_us, *noted.revoked_us)):
        i = bisect_left(told, time_us - SAME_US)
        if i == len(told) or told[i] > time_us + SAME_US or left[i] is None:
            unmatched.append(time_us)
            continue
        left[i] = None
        if time_us not in revoked:
            kept.add(told[i])
    for time_us in unmatched:
        before = bisect_right(starts, time_us)
        if not before or reach[before - 1] < time_us:
            continue
        # Its edges are lost: what shows it is the first that was seen again, unless that is another's.
        i = bisect_left(told, time_us)
        if i < len(told) and told[i] <= reach[before - 1] + RELEASE_CHATTER_US:
            left[i] = None
        if time_us not in revoked:
            kept.add(time_us)
    rest = {time_us for time_us in left if time_us is not None}
    return Candidates(sorted(rest | kept), frozenset(kept))
