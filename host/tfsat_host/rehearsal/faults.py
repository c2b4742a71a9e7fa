"""All faults that a rehearsed day can have, by `faults.toml`, and their choice by name."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import nan
from pathlib import Path
from typing import Any

from tfsat_host.errors import UsageError
from tfsat_host.quantity import Column, fields, records
from tfsat_host.rehearsal.fault import AT, FAULT, OF, SIZE, Fault, Moment, Outcome, Size, moments_of, words_of
from tfsat_host.rehearsal.mismatches import BUILT, SIZED_STRIKES
from tfsat_host.rehearsal.strikes import STRIKES

_STRIKES: Mapping[str, Callable[..., object]] = {**STRIKES, **SIZED_STRIKES}


def _nothing(*_: object) -> None:
    """Strikes: the robot is so from the day's beginning."""


def _declared(values: Mapping[str, Any]) -> Fault:
    name, (moment,) = values["name"], moments_of(values["moment"])
    outcomes = {at: outcome for outcome in Outcome for at in moments_of(values.get(outcome.typed, ""))}
    return Fault(
        name,
        values["what"],
        moment,
        strike=_STRIKES.get(name, _nothing),
        outcomes={at: outcomes[at] for at in Moment if at in outcomes},
        complete=values.get("complete", True),
        noticed=values.get("noticed", ""),
        preflight=tuple(values["preflight"]) if "preflight" in values else None,
        part=values.get("part", ""),
        size=Size(values["size"], values["unit"], values["most"]) if "size" in values else None,
        hidden=BUILT.get(name),
    )


GROUPS: Mapping[str, tuple[Fault, ...]] = {
    group: tuple(map(_declared, tables))
    for group, tables in tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8")).items()
}
"""By what they are faults of."""
FAULTS = tuple(fault for group in GROUPS.values() for fault in group)


def faults_named(names: Sequence[str]) -> tuple[Fault, ...]:
    """Those of one day.

    Raises:
        UsageError: one does not exist, is named twice, or two are of the same part, of which the last would win.
    """
    if len(set(names)) < len(names):
        raise UsageError(
            what="A fault is named twice.", meaning="Nothing was flown.", next_step="Name each fault once."
        )
    faults = tuple(map(fault_named, names))
    of_part: dict[str, Fault] = {}
    for fault in faults:
        part = fault.part or fault.kind
        other = of_part.setdefault(part, fault)
        if other is not fault:
            raise UsageError(
                what=f"{other.name} and {fault.name} cannot both be rehearsed: both are of the same part, {part}."
                if fault.part
                else f"{other.name} and {fault.name} are the same fault at two moments or of two sizes.",
                meaning="Nothing was flown: only the one that strikes last would have been rehearsed.",
                next_step=f"Rehearse one at a time: leave out --fault {other.name} or --fault {fault.name}.",
            )
    return faults


def fault_named(typed: str) -> Fault:
    """By its name, of another size than its own by NAME=SIZE, at another moment by NAME@MOMENT or NAME=SIZE@MOMENT.

    Raises:
        UsageError: there is no such fault, size or moment, or the fault cannot be at that moment.
    """
    kind, at, when = typed.partition(AT)
    name, of, size = kind.partition(OF)
    fault = next((one for one in FAULTS if one.name == name), None)
    if fault is None:
        raise UsageError(
            what=f"There is no fault {name!r}.",
            meaning="Nothing was flown.",
            next_step="See them all: tfsat-host rehearse --list-faults",
        )
    if of:
        fault = _sized(fault, size)
    if not at:
        return fault
    moment = next((one for one in Moment if one.typed == when), None)
    if moment is not None and moment in fault.outcomes:
        return fault.at(moment)
    possible = ", ".join(one.typed for one in fault.outcomes)
    raise UsageError(
        what=f"There is no moment {when!r}."
        if moment is None
        else f"{fault.name} cannot strike at {when} ({moment.value}): {fault.what}",
        meaning="Nothing was flown.",
        next_step=f"Write {fault.name}{AT} and one of {possible}."
        if len(fault.outcomes) > 1
        else f"Write {fault.name} alone: it strikes at {possible} ({fault.moment.value}) and at no other moment.",
    )


def _sized(fault: Fault, typed: str) -> Fault:
    own = fault.size
    if own is None:
        raise UsageError(
            what=f"{fault.name} has no size: {fault.what}",
            meaning="Nothing was flown.",
            next_step=f"Write {fault.name} alone; which faults have a size: tfsat-host rehearse --list-faults",
        )
    try:
        value = float(typed)
    except ValueError:
        value = nan
    if not 0.0 <= value <= own.most:
        raise UsageError(
            what=f"{typed!r} is no size of {fault.name}: a number from 0 to {own.most:g}, in {own.unit or 'times'}.",
            meaning="Nothing was flown.",
            next_step=f"Write for example {fault.name}{OF}{own.value:g}; its sign and direction follow from --seed.",
        )
    return fault.sized(replace(own, value=value))


def listed() -> tuple[list[dict[str, Any]], tuple[Sequence[str], Sequence[Sequence[str]]]]:
    """All of them, for JSON and as a table for people."""
    moments = Column(
        "moments", of=lambda fault: {when.typed: what.value for when, what in fault.outcomes.items()}
    )
    rows = [
        (
            fault.name,
            "" if fault.size is None else str(fault.size),
            fault.what,
            fault.moment.typed,
            words_of(fault.outcomes),
            fault.outcome.value,
        )
        for fault in FAULTS
    ]
    heads = ("fault", "size", "what happens", "when", "or @", "the robot then")
    return records((*FAULT, moments, *fields("complete noticed"), *SIZE), FAULTS), (heads, rows)
