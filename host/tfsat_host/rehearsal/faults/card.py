"""Faults of the logger's card and supply."""

from __future__ import annotations

from tfsat_host.emulated.card import CardDefect
from tfsat_host.emulated.robot import BoardIndex
from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.faults.fault import Fault, Outcome
from tfsat_host.rehearsal.moment import Moment

STALL_US = 400_000
EVERY_US = 1_000_000


def _slow(day: Day) -> None:
    day.robot.faults.card_stalls(STALL_US, EVERY_US)


def _full(day: Day) -> None:
    day.robot.card_slot.fill(0)


def _missing(day: Day) -> None:
    day.robot.card_slot.remove()


def _protected(day: Day) -> None:
    day.robot.card_slot.spoil(CardDefect.WRITE_PROTECTED)


def _power_cut(day: Day) -> None:
    for board in BoardIndex:
        day.robot.set_power(board, False)


CARD_FAULTS = (
    Fault(
        "card-slow",
        f"Now and then the card is busy for {STALL_US // 1000} ms.",
        Moment.POWERED,
        _slow,
        Outcome.FLIES,
    ),
    Fault(
        "card-full",
        "Somebody's files fill the card.",
        Moment.POWERED,
        _full,
        Outcome.NOT_DROPPED,
        noticed="card",
    ),
    Fault(
        "card-missing",
        "No card is in the logger.",
        Moment.POWERED,
        _missing,
        Outcome.NOT_DROPPED,
        noticed="card",
    ),
    Fault(
        "card-write-protected",
        "The card forbids writing.",
        Moment.POWERED,
        _protected,
        Outcome.NOT_DROPPED,
        noticed="card",
    ),
    Fault(
        "card-pulled",
        "The card is shaken out of its contacts halfway through the fall.",
        Moment.FALLING,
        _missing,
        Outcome.FLIES,
        complete=False,
        noticed="end",
    ),
    *(
        Fault(
            name,
            f"Both boards lose their power {when} the landing.",
            moment,
            _power_cut,
            Outcome.FLIES,
            complete=False,
            noticed="end",
        )
        for name, when, moment in (
            ("power-cut-before-landing", "100 ms before", Moment.BEFORE_LANDING),
            ("power-cut-after-landing", "100 ms after", Moment.LANDED),
        )
    ),
)
"""A power cut right after the landing comes before the second copy of the fall is written."""
