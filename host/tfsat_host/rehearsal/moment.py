"""The moments of the day at which something may go wrong, in their order."""

from __future__ import annotations

from collections.abc import Collection
from enum import Enum

GUARD_US = 100_000
"""Before and after the landing."""


class Moment(Enum):
    """Each is named after what has just been done, or is just about to be."""

    POWERED = "boards have started"
    UPLOADED = "maneuver uploaded and read back"
    CHECKED = "preflight made"
    RECORDING = "recording, hanging in the releaser"
    ARMED = "armed"
    LIFTED = "cables pulled, on the crane's hook"
    RELEASE = "about to be let go"
    FALLING = "halfway through the fall"
    BEFORE_LANDING = "100 ms before the landing"
    LANDING = "landing"
    LANDED = "100 ms after the landing"

    @property
    def typed(self) -> str:
        """As people type it."""
        return self.name.lower().replace("_", "-")


def between(first: Moment, last: Moment) -> tuple[Moment, ...]:
    """All from one to another, both among them."""
    moments = tuple(Moment)
    return moments[moments.index(first) : moments.index(last) + 1]


def words_of(moments: Collection[Moment]) -> str:
    """As people say and type them: `any moment`, `powered to armed`, or each by its name."""
    chosen = tuple(one for one in Moment if one in moments)
    if chosen == tuple(Moment):
        return "any moment"
    if len(chosen) > 2 and chosen == between(chosen[0], chosen[-1]):
        return f"{chosen[0].typed} to {chosen[-1].typed}"
    return ", ".join(one.typed for one in chosen)
