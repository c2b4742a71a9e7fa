"""One fault: when it strikes, what it does, and what must come of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum

from tfsat_host.emulated.robot import US_PER_S
from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.moment import Moment, between

AT = "@"
"""Between a fault's name and another moment than its own, as in gyro-dead@powered."""


class Outcome(Enum):
    """What the robot must do in spite of a fault, or because of it."""

    FLIES = "flies the maneuver"
    STANDS_STILL = "moves no joint"
    STOPS = "stops at once and stays where it is"
    NOT_DROPPED = "is not dropped"


Outcomes = Mapping[Moment, Outcome]
"""What comes of a fault by the moment at which it strikes; at a moment that is missing it cannot be."""


def during(first: Moment, last: Moment, outcome: Outcome) -> Outcomes:
    """The same at all moments from one to another."""
    return dict.fromkeys(between(first, last), outcome)


def at_any_moment(outcome: Outcome) -> Outcomes:
    """The same whenever it strikes."""
    return dict.fromkeys(Moment, outcome)


@dataclass(frozen=True, eq=False)
class Fault:
    """See the module.

    Attributes:
        name: To type.
        what: What happens, a sentence that is true at every moment in `outcomes`.
        moment: When.
        strike_now: Does it.
        outcomes: What the robot must then do, if a preflight does not keep it from being dropped.
        complete: The recording holds the whole drop; else it holds all that had reached the card.
        noticed: Words by which a refusal, the log or the report names it; empty: nothing is to be noticed.
        morning: Checks of the preflight that say so if it is there in the morning already; empty: none can;
            None: it cannot be there then.
        part: What it is a fault of, which can have one at a time; empty: of nothing that another fault is of, too.
    """

    name: str
    what: str
    moment: Moment
    strike_now: Callable[[Day], None]
    outcomes: Outcomes
    complete: bool = True
    noticed: str = ""
    morning: tuple[str, ...] | None = None
    part: str = ""

    @property
    def outcome(self) -> Outcome:
        """What the robot must do, struck at this moment."""
        return self.outcomes[self.moment]

    def strike(self, day: Day, moment: Moment) -> None:
        """Does it, if its moment has come."""
        if moment is self.moment:
            self.strike_now(day)

    def at(self, moment: Moment) -> Fault:
        """The same at another moment, one in `outcomes`."""
        return replace(self, moment=moment, name=f"{self.name}{AT}{moment.typed}")

    def telling(self, tell: Callable[[float], None]) -> Fault:
        """The same, which tells virtual time, in s, when it strikes: a day may end before."""

        def strike_and_tell(day: Day) -> None:
            tell(day.robot.now_us / US_PER_S)
            self.strike_now(day)

        return replace(self, strike_now=strike_and_tell)
