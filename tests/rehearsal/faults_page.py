"""docs/faults.md: what may go wrong, what the robot then does, and where it is noticed; as measured."""

from __future__ import annotations

from pathlib import Path

from tests.rehearsal.faults_seen import seen
from tfsat_host.rehearsal.faults.fault import Fault
from tfsat_host.rehearsal.faults.known import FAULTS

PAGE = Path(__file__).parents[2] / "docs" / "faults.md"
_HEAD = """# What may go wrong, and what happens then

Written by `python -m tests.rehearsal.faults_page`; do not edit. Each fault was rehearsed with the firmware's own code:

    tfsat-host rehearse 59 70 --fault gyro-dead
    tfsat-host rehearse --list-faults

The tests repeat every one of them. "Noticed" is where its name, or what it did, is said: by a board's refusal to go
on, in what `decode` says of the log, or in what `evaluate` and `report` say of the drop. Nothing is to be noticed of a
fault that changes nothing. The recording of a drop that was cut off holds every sample that had reached the card.

| fault | what happens | when | the robot | the recording | noticed |
| --- | --- | --- | --- | --- | --- |
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
        fault.outcome.value,
        kept,
        where or "nothing to notice",
    )
    return "| " + " | ".join(cells) + " |\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
