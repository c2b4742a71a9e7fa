"""All faults there are."""

from __future__ import annotations

from collections.abc import Sequence

from tfsat_host.errors import UsageError
from tfsat_host.rehearsal.faults.boards import BOARD_FAULTS
from tfsat_host.rehearsal.faults.card import CARD_FAULTS
from tfsat_host.rehearsal.faults.fault import AT, Fault
from tfsat_host.rehearsal.faults.release import RELEASE_FAULTS
from tfsat_host.rehearsal.faults.sensors import SENSOR_FAULTS
from tfsat_host.rehearsal.moment import Moment

FAULTS = (*RELEASE_FAULTS, *BOARD_FAULTS, *SENSOR_FAULTS, *CARD_FAULTS)


def fault_named(typed: str) -> Fault:
    """By its name, or at another moment than its own by NAME@MOMENT.

    Raises:
        UsageError: there is no such fault or moment, or the fault cannot be at that moment.
    """
    name, at, when = typed.partition(AT)
    fault = next((one for one in FAULTS if one.name == name), None)
    moment = next((one for one in Moment if one.typed == when), None)
    if fault is None:
        raise UsageError(
            what=f"There is no fault {name!r}.",
            meaning="Nothing was flown.",
            next_step="See them all: tfsat-host rehearse --list-faults",
        )
    if not at:
        return fault
    if moment is None or moment not in fault.outcomes:
        raise _not_then(fault, when, moment)
    return fault.at(moment)


def require_different_parts(faults: Sequence[Fault]) -> None:
    """One part can have one fault at a time: of two that are thrown in, the last would win.

    Raises:
        UsageError: two are of the same part.
    """
    of_part: dict[str, Fault] = {}
    for fault in faults:
        part = fault.part or fault.name.partition(AT)[0]
        other = of_part.setdefault(part, fault)
        if other is not fault:
            raise UsageError(
                what=f"{other.name} and {fault.name} cannot both be thrown in: both are of the same part, {part}."
                if fault.part
                else f"{other.name} and {fault.name} are the same fault at two moments.",
                meaning="Nothing was flown: only the one that strikes last would have been rehearsed.",
                next_step=f"Rehearse each by itself: leave out --fault {other.name} or --fault {fault.name}.",
            )


def _not_then(fault: Fault, typed: str, moment: Moment | None) -> UsageError:
    """The words for a moment at which a fault cannot be, or that does not exist."""
    possible = ", ".join(one.typed for one in fault.outcomes)
    return UsageError(
        what=f"There is no moment {typed!r}."
        if moment is None
        else f"{fault.name} cannot strike at {typed} ({moment.value}): {fault.what}",
        meaning="Nothing was flown.",
        next_step=f"Write {fault.name}{AT} and one of {possible}."
        if len(fault.outcomes) > 1
        else f"Write {fault.name} alone: it strikes at {possible} ({fault.moment.value}) and at no other moment.",
    )
