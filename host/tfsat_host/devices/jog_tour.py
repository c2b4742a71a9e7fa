"""A joint's way from stop to stop, without being let go in between: a limp joint would sag."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

from tfsat_host.protocol.limits import JOG_SPEED_CDEG_S


@dataclass(frozen=True, slots=True)
class JogTour:
    """One joint's stops.

    Attributes:
        joint: 1 to 3.
        stops_cdeg: Where it rests, 0.01 deg; at the first of them it is now, and its first pulse holds it there.
        hold_s: How long it rests at each.
    """

    joint: int
    stops_cdeg: tuple[int, ...]
    hold_s: float

    @property
    def duration_s(self) -> float:
        """At the board's jogging speed, rests included."""
        way_cdeg = sum(abs(after - before) for before, after in pairwise(self.stops_cdeg))
        return way_cdeg / JOG_SPEED_CDEG_S + len(self.stops_cdeg) * self.hold_s


class TourWatch(Protocol):
    """Whoever follows a tour. What a method raises ends the tour, and the joint is let go."""

    def pause(self, duration_s: float) -> None:
        """Lets so much time pass on the sequencer's clock; another board can be read meanwhile."""

    def shown(self, stop: int, angle_cdeg: int) -> None:
        """Told several times a second, on the way to a stop (from 0) and at rest there, what the servo is told."""

    def rested(self, stop: int) -> None:
        """Told when the joint has rested at a stop for as long as it should; it is still held there.

        The board lets go of a joint that it gets no order for: this must not take half a second.
        """
