"""The release rule of protocol/tfsat.toml, [release], on recorded edges, as the firmware's `ReleaseDetector`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tfsat_host.protocol.limits import (
    RELEASE_BOUNCE_US,
    RELEASE_CHATTER_US,
    RELEASE_DEBOUNCE_US,
    RELEASE_HUNG_US,
    RELEASE_SEATED_US,
    SWITCH_COUNT,
)

ALL_OPEN = (1 << SWITCH_COUNT) - 1

SwitchEdge = tuple[int, int, bool]
"""Time in µs, switch from 0, whether it opened."""


@dataclass(slots=True)
class RuledRelease:
    """A release by the rule.

    Attributes:
        at_us: t = 0 of the schedule.
        first_us: Both were open for the first time, at most RELEASE_CHATTER_US before the last.
        last_us: And for the last time before the interval was settled.
        hung: The robot may have hung between the two.
        certain_us: When the rule tells it; None before.
        false_us: When the rule tells that it was a false one; None if it was none.
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
    """All releases by the rule, false ones included; armed anew when both have been closed.

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
