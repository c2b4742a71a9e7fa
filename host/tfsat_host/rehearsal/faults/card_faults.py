"""Faults of the card and of the power that it is written with."""

from __future__ import annotations

from tfsat_host.emulated.emulated_robot import US_PER_S, BoardIndex
from tfsat_host.emulated.fault_injection import CardDefect
from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.faults.fault import (
    Fault,
    Moment,
    Outcome,
    at_any_moment,
    break_part,
    outcomes_between,
)

_FOREVER_US = 100_000_000
_BEYOND_THE_RING_S = 25


def _stop_card_on_the_hook(day: Day) -> None:
    day.robot.faults.card_stalls(_FOREVER_US, 0)
    # Longer than the ring buffer bridges: samples that follow find no room.
    day.robot.advance(_BEYOND_THE_RING_S * US_PER_S)


def cut_power(day: Day, after_us: int = 0) -> None:
    """Cut the power of both boards after a delay."""
    day.robot.advance(after_us)
    for board in BoardIndex:
        day.robot.set_power(board, False)


def _power_cut(name: str, when: str, moment: Moment) -> Fault:
    return Fault(
        name,
        f"Both boards lose their power {when}.",
        moment,
        {moment: Outcome.FLIES},
        action=cut_power,
        complete=False,
        noticed="has no end",
        part="power of both boards",
    )


FAULTS = (
    Fault(
        "card-slow",
        "Now and then the card is busy for 400 ms.",
        Moment.POWERED,
        at_any_moment(Outcome.FLIES),
        action=break_part("card_stalls", 400_000, 1_000_000),
        preflight=(),
        part="card",
    ),
    Fault(
        "card-gone-on-the-hook",
        "The card takes nothing more from the lift on, and the team waits 25 s, longer than the ring in RAM bridges.",
        Moment.LIFTED,
        {Moment.LIFTED: Outcome.FLIES},
        action=_stop_card_on_the_hook,
        complete=False,
        noticed="RAM kept the newest",
        part="card",
    ),
    Fault(
        "card-full",
        "Other files fill the card.",
        Moment.POWERED,
        outcomes_between(Moment.POWERED, Moment.CHECKED, Outcome.NOT_DROPPED),
        action=lambda day: day.robot.card_slot.fill(0),
        noticed="The card has no room",
        preflight=("card-room", "card-writing"),
        part="card",
    ),
    Fault(
        "card-missing",
        "No card is in the logger.",
        Moment.POWERED,
        outcomes_between(Moment.POWERED, Moment.CHECKED, Outcome.NOT_DROPPED),
        action=lambda day: day.robot.card_slot.remove(),
        noticed="No SD card answers",
        preflight=("card", "card-room", "card-writing"),
        part="card",
    ),
    Fault(
        "card-write-protected",
        "The card forbids writing.",
        Moment.POWERED,
        outcomes_between(Moment.POWERED, Moment.CHECKED, Outcome.NOT_DROPPED),
        action=lambda day: day.robot.card_slot.spoil(CardDefect.WRITE_PROTECTED),
        noticed="The card forbids writing",
        preflight=("card", "card-room", "card-writing"),
        part="card",
    ),
    Fault(
        "card-pulled",
        "The card is shaken out of its contacts.",
        Moment.FALLING,
        outcomes_between(Moment.POWERED, Moment.CHECKED, Outcome.NOT_DROPPED)
        | outcomes_between(Moment.RECORDING, Moment.LANDED, Outcome.FLIES),
        action=lambda day: day.robot.card_slot.remove(),
        noticed="in the logger's RAM only",
        preflight=("card", "card-room", "card-writing"),
        part="card",
    ),
    _power_cut("power-cut-before-landing", "100 ms before the landing", Moment.BEFORE_LANDING),
    _power_cut("power-cut-at-landing", "at the moment of the landing", Moment.LANDING),
    # Right after the landing: before the second copy of the fall is written.
    _power_cut("power-cut-after-landing", "100 ms after the landing", Moment.LANDED),
)
