"""All faults that a rehearsed day can have, by `faults.toml`: what strikes on the day, and their choice by name."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import nan
from pathlib import Path
from typing import Any

from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.devices.serial_ports import PortError, PortProblem
from tfsat_host.emulated.emulated_certificate import careful_certificate
from tfsat_host.emulated.emulated_robot import US_PER_S, BoardIndex, Reset
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.fault_injection import CardDefect
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.errors import UsageError
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.quantity import Column, fields, records
from tfsat_host.rehearsal.day import CALIBRATED, Day
from tfsat_host.rehearsal.fault import AT, FAULT, OF, SIZE, Fault, Moment, Outcome, Size, moments_of, words_of
from tfsat_host.rehearsal.mismatches import BUILT, SIZED_STRIKES

FRAMES_BEFORE_CRASH = 3
ANOTHER_ROBOT = 4711
FOREVER_US = 100_000_000
BEYOND_THE_RING_S = 25


def _broken(part: str, *how: object) -> Callable[[Day], object]:
    """Build a strike that calls a method of `emulated.faults.Faults` with these arguments."""
    return lambda day: getattr(day.robot.faults, part)(*how)


def _knock(day: Day, open_us: int) -> None:
    for switch in (1, 2):
        day.robot.knock(switch, open_us)


class _DyingTransport(EmulatedTransport):
    """A cable whose program dies after a few frames."""

    _left = FRAMES_BEFORE_CRASH

    def write(self, data: bytes) -> None:
        """Sends, until the program is dead."""
        if not self._left:
            raise PortError(PortProblem.OTHER, what="The program was killed.", next_step="Start it again.")
        self._left -= 1
        super().write(data)


def _host_crash(day: Day) -> None:
    dying = SequencerClient.connect(_DyingTransport(day.robot, BoardIndex.SEQUENCER))
    try:
        dying.upload(day.schedule)
    except PortError as error:
        day.setbacks.append(f"The upload broke off and was begun again: {error.what}")
    # A new program connects; the day's own upload, which follows, begins again from the start.
    dying.close()
    day.reconnect()


def _gone_on_the_hook(day: Day) -> None:
    day.robot.faults.card_stalls(FOREVER_US, 0)
    # Longer than the ring buffer bridges: samples that follow find no room.
    day.robot.advance(BEYOND_THE_RING_S * US_PER_S)


def power_cut(day: Day, after_us: int = 0) -> None:
    """Cut the power of both boards after a delay."""
    day.robot.advance(after_us)
    for board in BoardIndex:
        day.robot.set_power(board, False)


def _foreign_calibration(day: Day) -> None:
    day.calibration = careful_certificate(
        day.robot.model, draw_as_built(ANOTHER_ROBOT), ANOTHER_ROBOT, CALIBRATED
    )


def _spoil_card(defect: CardDefect) -> Callable[[Day], object]:
    return lambda day: day.robot.card_slot.spoil(defect)


STRIKES: Mapping[str, Callable[[Day], object]] = {
    "switch-stuck-closed": _broken("switch", 1, "stuck-closed"),
    "switch-stuck-open": _broken("switch", 1, "stuck-open"),
    "switch-bounce": _broken("bounce", 50_000),
    "lift-knock": partial(_knock, open_us=4_000),
    # Both switches open for 5 ms are a release, whoever opened them; closed again for 200 ms, a false one.
    "crane-jolt": partial(_knock, open_us=6_000),
    "release-before-arming": lambda day: setattr(day, "arming", False),
    "cable-pulled-while-armed": lambda day: day.robot.set_cable(BoardIndex.SEQUENCER, False),
    "host-crash-in-upload": _host_crash,
    "wrong-maneuver": lambda day: day.sequencer.upload(schedule_maneuver(four_stroke(18.0, 90.0))),
    "watchdog-while-armed": lambda day: day.robot.reset(Reset.WATCHDOG),
    "watchdog-while-falling": lambda day: day.robot.reset(Reset.WATCHDOG),
    "brown-out-at-release": lambda day: day.robot.reset(Reset.BROWN_OUT),
    "sequencer-clock-fast": _broken("clock", "sequencer", 10_000.0),
    "logger-clock-fast": _broken("clock", "logger", 10_000.0),
    "servo-dead": _broken("servo", 1, "dead"),
    "servo-slow": _broken("servo", 1, "slow"),
    "servo-reversed": _broken("servo", 1, "reversed"),
    "gyro-dead": _broken("imu", 4, "dead"),
    "gyro-frozen": _broken("imu", 4, "frozen"),
    "gyro-swapped": _broken("imu", 4, "swapped", 3),
    "gyro-saturated": _broken("imu", 4, "saturated"),
    "bus-glitch": _broken("glitch", 4),
    "bus-stuck": _broken("bus", 2, True),
    "angle-sensor-slipped": _broken("angle_sensor", 1, "turned", 200.0),
    "calibration-of-another-robot": _foreign_calibration,
    "card-slow": _broken("card_stalls", 400_000, 1_000_000),
    "card-gone-on-the-hook": _gone_on_the_hook,
    "card-full": lambda day: day.robot.card_slot.fill(0),
    "card-missing": lambda day: day.robot.card_slot.remove(),
    "card-write-protected": _spoil_card(CardDefect.WRITE_PROTECTED),
    "card-pulled": lambda day: day.robot.card_slot.remove(),
    # One right after the landing comes before the second copy of the fall is written.
    **dict.fromkeys(
        ("power-cut-before-landing", "power-cut-at-landing", "power-cut-after-landing"), power_cut
    ),
}
"""By the fault's name."""


_STRIKES: Mapping[str, Callable[..., object]] = {**STRIKES, **SIZED_STRIKES}


def _do_nothing(*_: object) -> None:
    """Strikes: the robot is so from the day's beginning."""


def _declare_fault(values: Mapping[str, Any]) -> Fault:
    name, (moment,) = values["name"], moments_of(values["moment"])
    # A fault's table gives moments by outcome; turn that around.
    outcomes = {at: outcome for outcome in Outcome for at in moments_of(values.get(outcome.typed, ""))}
    return Fault(
        name,
        values["what"],
        moment,
        strike=_STRIKES.get(name, _do_nothing),
        outcomes={at: outcomes[at] for at in Moment if at in outcomes},
        complete=values.get("complete", True),
        noticed=values.get("noticed", ""),
        preflight=tuple(values["preflight"]) if "preflight" in values else None,
        part=values.get("part", ""),
        size=Size(values["size"], values["unit"], values["most"]) if "size" in values else None,
        hidden=BUILT.get(name),
    )


GROUPS: Mapping[str, tuple[Fault, ...]] = {
    group: tuple(map(_declare_fault, tables))
    for group, tables in tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8")).items()
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
                meaning="Nothing was flown: only the one that strikes last would have been rehearsed.",
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
            next_step=Advice("See them all: ", NextStep("rehearse", ("--list-faults",))),
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
        else f"{fault.name} cannot strike at {when} ({moment.value}): {fault.what}",
        meaning="Nothing was flown.",
        next_step=f"Write {fault.name}{AT} and one of {possible}."
        if len(fault.outcomes) > 1
        else f"Write {fault.name} alone: it strikes at {possible} ({fault.moment.value}) and at no other moment.",
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


def list_faults() -> tuple[list[dict[str, Any]], tuple[Sequence[str], Sequence[Sequence[str]]]]:
    """List all faults, for JSON and as a table for people."""
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
