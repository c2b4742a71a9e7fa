"""docs/faults.md: each fault, the checks that find it, and what the robot does; as rehearsed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from tests.rehearsal import days
from tests.rehearsal.days import Day, Days
from tfsat_host.rehearsal.fault import Fault, words_of
from tfsat_host.rehearsal.faults import FAULTS, GROUPS

PAGE = Path(__file__).parents[2] / "docs" / "faults.md"
_HEAD = """# Faults

Written by `python -m tests.rehearsal.faults_page`; do not edit. Each fault was rehearsed with the firmware's own code:

    tfsat-host rehearse 59 70 --fault gyro-dead
    tfsat-host rehearse 59 70 --fault gyro-dead@powered
    tfsat-host rehearse 59 70 --fault gyro-swapped --despite-preflight

A fault strikes at its own moment ("when"), or at one of those in the column "or @", typed behind an `@`. The tests
repeat every row: the fault before the preflight, where that can be, and at its own moment whatever the preflight says.

- **Preflight**: the checks that say NO-GO (docs/preflight.md); "cannot find it": only a motion shows it; "comes
  later": the fault cannot be there yet.
- **The robot**: what it does, dropped all the same; and at other moments, where that differs.
- **The recording** "to where it was cut off": every sample that had reached the card.
- **Reported by**: a board's refusal, a board after the landing, the log (`decode`), the report (`evaluate`, `report`),
  or their refusal to give numbers. A fault that changes nothing is not reported; of a mismatch between the robot and
  its files (the last rows, those with a size) it is who names the cause.

A fault with a size can have another: `wrong-masses=1`, `imu-late=3`, `gyro-bias-step=0.1@armed`.

| fault | what happens | when | or @ | preflight | the robot | the recording | reported by |
| --- | --- | --- | --- | --- | --- | --- | --- |
"""
MISMATCHES = (*GROUPS["model-mismatch"], *GROUPS["sensor-mismatch"])
_DIAGNOSES = """
## What an evaluation makes of a mismatch

Of one drop each, `tfsat-host rehearse 59 70 --fault …`, of seed 1: the verdict, and the causes that its checks name.

| | size | verdict | cause |
| --- | --- | --- | --- |
"""

Checks = Callable[[Fault], tuple[str, ...]]


def page(seen: Days, no_go: Checks) -> str:
    """The text of the page.

    Args:
        seen: What became of a fault's day.
        no_go: Which checks stand against the drop when it is there before the preflight.
    """
    rows = "".join(row(fault, seen(fault), no_go) for fault in FAULTS)
    return _HEAD + rows + _DIAGNOSES + "".join(diagnosis(fault, seen(fault)) for fault in MISMATCHES)


def diagnosis(fault: Fault, found: Day) -> str:
    """Of the second table: what the evaluation makes of a mismatch."""
    causes = dict.fromkeys(one["cause"] for one in found.checks.values() if one["cause"])
    level = found.verdict or "refused"
    return f"| `--fault {fault.name}` | {fault.size} | {level} | {'; '.join(causes) or '–'} |\n"


def row(fault: Fault, found: Day, no_go: Checks) -> str:
    """Of the table."""
    where = ", ".join(who for who, words in found.said.items() if fault.noticed and fault.noticed in words)
    kept = "none" if found.log is None else "whole" if fault.complete else "to where it was cut off"
    cells = (
        f"`{fault.name}`",
        fault.what if fault.size is None else f"{fault.what} By default {fault.size}.",
        fault.moment.value,
        words_of(fault.outcomes),
        "comes later"
        if fault.preflight is None
        else ", ".join(f"`{name}`" for name in no_go(fault)) or "cannot find it",
        _robot(fault),
        kept,
        where or "–",
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
