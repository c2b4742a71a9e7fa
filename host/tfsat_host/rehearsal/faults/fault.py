"""One fault: when it strikes, what it does, and what must come of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.moment import Moment

AT = "@"
"""Between a fault's name and another moment than its own, as in gyro-dead@powered."""


class Outcome(Enum):
    """What the robot must do in spite of a fault, or because of it."""

    FLIES = "flies the maneuver"
    STANDS_STILL = "moves no joint"
    STOPS = "stops at once and stays where it is"
    NOT_DROPPED = "is not dropped"


@dataclass(frozen=True, slots=True)
class Fault:
    """See the module.

    Attributes:
        name: To type.
        what: What happens, a sentence.
        moment: When.
        strike_now: Does it.
        outcome: What the robot must then do, if a preflight does not keep it from being dropped.
        complete: The recording holds the whole drop; else it holds all that had reached the card.
        noticed: Words by which a refusal, the log or the report names it; empty: nothing is to be noticed.
        morning: Checks of the preflight that say so if it is there in the morning already; empty: none can;
            None: it cannot be there then.
    """

    name: str
    what: str
    moment: Moment
    strike_now: Callable[[Day], None]
    outcome: Outcome
    complete: bool = True
    noticed: str = ""
    morning: tuple[str, ...] | None = None

    def strike(self, day: Day, moment: Moment) -> None:
        """Does it, if its moment has come."""
        if moment is self.moment:
            self.strike_now(day)

    def at(self, moment: Moment) -> Fault:
        """The same at another moment."""
        return replace(self, moment=moment, name=f"{self.name}{AT}{moment.typed}")
