"""docs/faults.md: what may go wrong, what stops it in the morning, and what the robot does else; as measured."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tests.rehearsal import days
from tests.rehearsal.days import Day, Days
from tfsat_host.rehearsal.fault import Fault, words_of
from tfsat_host.rehearsal.faults import FAULTS

PAGE = Path(__file__).parents[2] / "docs" / "faults.md"
_HEAD = """# What may go wrong, and what happens then

Written by `python -m tests.rehearsal.faults_page`; do not edit. Each fault was rehearsed with the firmware's own code:

    tfsat-host rehearse 59 70 --fault gyro-dead
    tfsat-host rehearse 59 70 --fault gyro-dead@powered
    tfsat-host rehearse 59 70 --fault gyro-swapped --despite-preflight
    tfsat-host rehearse --list-faults

A fault strikes at its own moment ("when"), or at one of those in the column "or @", typed behind an `@`; any other is
refused, for the fault cannot be there then. The tests repeat every row: the day on which the fault is there in the
morning already, where that can be, and the day on which it strikes at its own moment and the team drops whatever the
preflight says.

- **Preflight** names the checks that then say NO-GO (docs/preflight.md); "cannot see it" is what no check can find
  without moving the robot, and "comes later" what cannot be there yet.
- **The robot** is what it does then, dropped all the same; and what it does if the fault strikes at another moment,
  where that differs.
- **The recording** "to where it was cut off" holds every sample that had reached the card.
- **Noticed** is where its name, or what it did, is said afterwards: by a board's refusal to go on, by a board after the
  landing, in what `decode` says of the log, or in what `evaluate` and `report` say of the drop. "report refuses" is
  where these two give no numbers and no page, and say why. Nothing is to be noticed of a fault that changes nothing.
  `rehearse` says for each fault that was thrown in when it struck and who noticed.

| fault | what happens | when | or @ | preflight | the robot | the recording | noticed |
| --- | --- | --- | --- | --- | --- | --- | --- |
"""


Checks = Callable[[Fault], tuple[str, ...]]


def page(seen: Days, no_go: Checks) -> str:
    """The text of the page.

    Args:
        seen: What became of a fault's day.
        no_go: Which checks stand against the drop when it is there before the preflight.
    """
    return _HEAD + "".join(_row(fault, seen(fault), no_go) for fault in FAULTS)


def _row(fault: Fault, found: Day, no_go: Checks) -> str:
    where = ", ".join(who for who, words in found.said.items() if fault.noticed and fault.noticed in words)
    kept = "none" if found.log is None else "whole" if fault.complete else "to where it was cut off"
    cells = (
        f"`{fault.name}`",
        fault.what,
        fault.moment.value,
        words_of(fault.outcomes),
        "comes later"
        if fault.morning is None
        else ", ".join(f"`{name}`" for name in no_go(fault)) or "cannot see it",
        _robot(fault),
        kept,
        where or "nothing to notice",
    )
    return "| " + " | ".join(cells) + " |\n"


def _robot(fault: Fault) -> str:
    others = [one for one in dict.fromkeys(fault.outcomes.values()) if one is not fault.outcome]
    when = {one: words_of([at for at, what in fault.outcomes.items() if what is one]) for one in others}
    return "; ".join([fault.outcome.value, *(f"{one.value} if @{when[one]}" for one in others)])


def _no_go(fault: Fault) -> tuple[str, ...]:
    return days.seen(fault).no_go if fault.moment in days.BEFORE_PREFLIGHT else days.no_go(fault)


if __name__ == "__main__":
    PAGE.write_text(page(days.seen, _no_go), encoding="utf-8")
