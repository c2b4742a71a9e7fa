"""docs/faults.md: what may go wrong, what stops it in the morning, and what the robot does else; as measured."""

from __future__ import annotations

from pathlib import Path

from tests.rehearsal.faults_seen import no_go, seen
from tfsat_host.rehearsal.faults.fault import Fault
from tfsat_host.rehearsal.faults.known import FAULTS

PAGE = Path(__file__).parents[2] / "docs" / "faults.md"
_HEAD = """# What may go wrong, and what happens then

Written by `python -m tests.rehearsal.faults_page`; do not edit. Each fault was rehearsed with the firmware's own code:

    tfsat-host rehearse 59 70 --fault gyro-dead
    tfsat-host rehearse 59 70 --fault gyro-dead@powered
    tfsat-host rehearse 59 70 --fault gyro-swapped --despite-preflight
    tfsat-host rehearse --list-faults

A fault strikes at its own moment ("when"), or at the one behind an `@`. The tests repeat every row: the day on which
the fault is there in the morning already, where that can be, and the day on which it strikes at its own moment and the
team drops whatever the preflight says.

- **Preflight** names the checks that then say NO-GO (docs/preflight.md); "cannot see it" is what no check can find
  without moving the robot, and "comes later" what cannot be there yet.
- **The robot** is what it does then, dropped all the same.
- **The recording** "to where it was cut off" holds every sample that had reached the card.
- **Noticed** is where its name, or what it did, is said afterwards: by a board's refusal to go on, by a board after the
  landing, in what `decode` says of the log, or in what `evaluate` and `report` say of the drop. Nothing is to be
  noticed of a fault that changes nothing.

| fault | what happens | when | preflight | the robot | the recording | noticed |
| --- | --- | --- | --- | --- | --- | --- |
"""


def page() -> str:
    """The text of the page."""
    return _HEAD + "".join(_row(fault) for fault in FAULTS)


def _row(fault: Fault) -> str:
    found = seen(fault)
    where = ", ".join(
        place for place, words in found.said.items() if fault.noticed and fault.noticed in words
    )
    kept = "none" if found.log is None else "whole" if fault.complete else "to where it was cut off"
    cells = (
        f"`{fault.name}`",
        fault.what,
        fault.moment.value,
        _preflight(fault),
        fault.outcome.value,
        kept,
        where or "nothing to notice",
    )
    return "| " + " | ".join(cells) + " |\n"


def _preflight(fault: Fault) -> str:
    if fault.morning is None:
        return "comes later"
    return ", ".join(f"`{name}`" for name in no_go(fault)) or "cannot see it"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
