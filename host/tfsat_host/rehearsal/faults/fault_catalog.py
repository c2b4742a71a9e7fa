"""All faults that a rehearsed day can have, and their choice by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import nan

from tfsat_host.errors import UsageError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.quantity import UNKNOWN, Column, Columns, fields
from tfsat_host.rehearsal.faults import (
    board_faults,
    card_faults,
    model_mismatches,
    release_faults,
    sensor_faults,
    sensor_mismatches,
)
from tfsat_host.rehearsal.faults.fault import AT, FAULT, OF, SIZE, Fault, Moment, words_of

GROUPS: Mapping[str, tuple[Fault, ...]] = {
    "release": release_faults.FAULTS,
    "board": board_faults.FAULTS,
    "sensor": sensor_faults.FAULTS,
    "card": card_faults.FAULTS,
    "model-mismatch": model_mismatches.FAULTS,
    "sensor-mismatch": sensor_mismatches.FAULTS,
}
"""By what they are faults of."""
FAULTS = tuple(fault for group in GROUPS.values() for fault in group)


def faults_named(names: Sequence[str]) -> tuple[Fault, ...]:
    """Return the faults of one day by their names.

    Raises:
        UsageError: one does not exist, is named twice, or two are of the same part, of which the last would
            win.
    """
    if len(set(names)) < len(names):
        raise UsageError(
            what="A fault is named twice.", meaning="Nothing was flown.", next_step="Name each fault once."
        )
    faults = tuple(map(fault_named, names))
    # The emulator keeps one fault of each part: a second would silently replace the first.
    of_part: dict[str, Fault] = {}
    for fault in faults:
        part = fault.part or fault.kind
        other = of_part.setdefault(part, fault)
        if other is not fault:
            raise UsageError(
                what=f"{other.name} and {fault.name} cannot both be rehearsed: both are of the same part, {part}."
                if fault.part
                else f"{other.name} and {fault.name} are the same fault at two moments or of two sizes.",
                meaning="Nothing was flown: only the one that is injected last would have been rehearsed.",
                next_step=f"Rehearse one at a time: leave out --fault {other.name} or --fault {fault.name}.",
            )
    return faults


def fault_named(fault_text: str) -> Fault:
    """Find a fault by its name, NAME=SIZE, NAME@MOMENT or NAME=SIZE@MOMENT.

    SIZE and MOMENT replace the fault's own.

    Raises:
        UsageError: there is no such fault, size or moment, or the fault cannot be at that moment.
    """
    # NAME=SIZE@MOMENT: split off the moment first, then the size; either may be missing.
    kind, at, when = fault_text.partition(AT)
    name, of, size = kind.partition(OF)
    fault = next((candidate for candidate in FAULTS if candidate.name == name), None)
    if fault is None:
        raise UsageError(
            what=f"There is no fault {name!r}.",
            meaning="Nothing was flown.",
            next_step=Advice("List of faults: ", NextStep("rehearse", ("--list-faults",))),
        )
    if of:
        fault = _fault_of_size(fault, size)
    if not at:
        return fault
    moment = next((candidate for candidate in Moment if candidate.typed == when), None)
    if moment is not None and moment in fault.outcomes:
        return fault.at(moment)
    possible = ", ".join(allowed_moment.typed for allowed_moment in fault.outcomes)
    raise UsageError(
        what=f"There is no moment {when!r}."
        if moment is None
        else f"{fault.name} cannot be injected at {when} ({moment.value}): {fault.what}",
        meaning="Nothing was flown.",
        next_step=f"Write {fault.name}{AT} and one of {possible}."
        if len(fault.outcomes) > 1
        else f"Write {fault.name} alone: it is injected at {possible} ({fault.moment.value}) and at no other moment.",
    )


def _fault_of_size(fault: Fault, size_text: str) -> Fault:
    own = fault.size
    if own is None:
        raise UsageError(
            what=f"{fault.name} has no size: {fault.what}",
            meaning="Nothing was flown.",
            next_step=Advice(
                f"Write {fault.name} alone; which faults have a size: ",
                NextStep("rehearse", ("--list-faults",)),
            ),
        )
    try:
        value = float(size_text)
    except ValueError:
        # NaN is in no range, so it is refused below with the numbers that are not.
        value = nan
    if not 0.0 <= value <= own.most:
        raise UsageError(
            what=f"{size_text!r} is no size of {fault.name}: a number from 0 to {own.most:g}, in "
            f"{own.unit or 'times'}.",
            meaning="Nothing was flown.",
            next_step=f"Write for example {fault.name}{OF}{own.value:g}; its sign and direction follow from --seed.",
        )
    return fault.resize(replace(own, value=value))


FAULT_OF_CATALOG: Columns = (
    *FAULT,
    Column("moments", of=lambda fault: {when.typed: what.value for when, what in fault.outcomes.items()}),
    *fields("complete noticed"),
    *SIZE,
    Column("", "fault", words=lambda fault: fault.name),
    Column("", "size", words=lambda fault: UNKNOWN if fault.size is None else str(fault.size)),
    Column("", "what happens", words=lambda fault: fault.what),
    Column("", "moment", words=lambda fault: fault.moment.typed),
    Column("", "moments", words=lambda fault: words_of(fault.outcomes)),
    Column("", "outcome", words=lambda fault: fault.outcome.value),
)
"""Of each of `FAULTS`, for JSON and as a table for people."""
