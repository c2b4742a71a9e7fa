"""Faults of the logger's card and supply."""

from __future__ import annotations

from tfsat_host.emulated.card import CardDefect
from tfsat_host.emulated.robot import US_PER_S, BoardIndex
from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.faults.fault import Fault, Outcome, at_any_moment, during
from tfsat_host.rehearsal.moment import Moment

STALL_US = 400_000
EVERY_US = 1_000_000
FOREVER_US = 100_000_000
BEYOND_THE_RING_S = 25


def _slow(day: Day) -> None:
    day.robot.faults.card_stalls(STALL_US, EVERY_US)


def _gone_on_the_hook(day: Day) -> None:
    day.robot.faults.card_stalls(FOREVER_US, 0)
    day.robot.advance(BEYOND_THE_RING_S * US_PER_S)


def _full(day: Day) -> None:
    day.robot.card_slot.fill(0)


def _missing(day: Day) -> None:
    day.robot.card_slot.remove()


def _protected(day: Day) -> None:
    day.robot.card_slot.spoil(CardDefect.WRITE_PROTECTED)


def power_cut(day: Day, after_us: int = 0) -> None:
    """Both boards lose their power so long after now."""
    day.robot.advance(after_us)
    for board in BoardIndex:
        day.robot.set_power(board, False)


POWER_CUTS = tuple(
    Fault(
        name,
        f"Both boards lose their power {when} the landing.",
        moment,
        power_cut,
        {moment: Outcome.FLIES},
        complete=False,
        noticed="has no end",
        part="power of both boards",
    )
    for name, when, moment in (
        ("power-cut-before-landing", "100 ms before", Moment.BEFORE_LANDING),
        ("power-cut-at-landing", "at the moment of", Moment.LANDING),
        ("power-cut-after-landing", "100 ms after", Moment.LANDED),
    )
)
"""A power cut right after the landing comes before the second copy of the fall is written."""

CARD_FAULTS = (
    Fault(
        "card-slow",
        f"Now and then the card is busy for {STALL_US // 1000} ms.",
        Moment.POWERED,
        _slow,
        at_any_moment(Outcome.FLIES),
        morning=(),
        part="card",
    ),
    Fault(
        "card-gone-on-the-hook",
        f"The card takes nothing more from the lift on, and the team waits {BEYOND_THE_RING_S} s, longer than the ring "
        "in RAM bridges.",
        Moment.LIFTED,
        _gone_on_the_hook,
        {Moment.LIFTED: Outcome.FLIES},
        complete=False,
        noticed="RAM kept the newest",
        part="card",
    ),
    Fault(
        "card-full",
        "Somebody's files fill the card.",
        Moment.POWERED,
        _full,
        during(Moment.POWERED, Moment.CHECKED, Outcome.NOT_DROPPED),
        noticed="The card has no room",
        morning=("card-room", "card-writing"),
        part="card",
    ),
    Fault(
        "card-missing",
        "No card is in the logger.",
        Moment.POWERED,
        _missing,
        during(Moment.POWERED, Moment.CHECKED, Outcome.NOT_DROPPED),
        noticed="No SD card answers",
        morning=("card", "card-room", "card-writing"),
        part="card",
    ),
    Fault(
        "card-write-protected",
        "The card forbids writing.",
        Moment.POWERED,
        _protected,
        during(Moment.POWERED, Moment.CHECKED, Outcome.NOT_DROPPED),
        noticed="The card forbids writing",
        morning=("card", "card-room", "card-writing"),
        part="card",
    ),
    Fault(
        "card-pulled",
        "The card is shaken out of its contacts.",
        Moment.FALLING,
        _missing,
        {
            **during(Moment.POWERED, Moment.CHECKED, Outcome.NOT_DROPPED),
            **during(Moment.RECORDING, Moment.LANDED, Outcome.FLIES),
        },
        noticed="in the logger's RAM only",
        morning=("card", "card-room", "card-writing"),
        part="card",
    ),
    *POWER_CUTS,
)
