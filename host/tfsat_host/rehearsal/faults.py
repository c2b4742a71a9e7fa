"""All faults that a rehearsed day can have, and their choice by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from tfsat_host.devices.ports import PortError, PortProblem
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.emulated.certificate import careful_certificate
from tfsat_host.emulated.faults import CardDefect
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.emulated.robot import US_PER_S, BoardIndex, Reset
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.errors import UsageError
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.quantity import Column, fields, records
from tfsat_host.rehearsal.day import CALIBRATED, Day
from tfsat_host.rehearsal.fault import (
    AT,
    FAULT,
    Fault,
    Moment,
    Outcome,
    Outcomes,
    at_any_moment,
    during,
    words_of,
)

BOUNCE_US = 50_000
KNOCK_US = 4_000
JOLT_US = 6_000
"""Both switches open for 5 ms are a release, whoever opened them; closed again for 200 ms, a false one."""
ONE_PERCENT_PPM = 10_000.0
FRAMES_BEFORE_CRASH = 3
ANOTHER_ROBOT = 4711
SLIPPED_DEG = 200.0
STALL_US = 400_000
EVERY_US = 1_000_000
FOREVER_US = 100_000_000
BEYOND_THE_RING_S = 25


def _broken(part: str, *how: object) -> Callable[[Day], object]:
    """A method of `emulated.faults.Faults`, with its arguments."""
    return lambda day: getattr(day.robot.faults, part)(*how)


def _knock(day: Day, open_us: int) -> None:
    for switch in (1, 2):
        day.robot.knock(switch, open_us)


class _Dying(EmulatedTransport):
    """A cable whose program dies after a few frames."""

    _left = FRAMES_BEFORE_CRASH

    def write(self, data: bytes) -> None:
        """Sends, until the program is dead."""
        if not self._left:
            raise PortError(PortProblem.OTHER, what="The program was killed.", next_step="Start it again.")
        self._left -= 1
        super().write(data)


def _host_crash(day: Day) -> None:
    dying = SequencerClient.connect(_Dying(day.robot, BoardIndex.SEQUENCER))
    try:
        dying.upload(day.schedule)
    except PortError as error:
        day.setbacks.append(f"The upload broke off and was begun again: {error.what}")
    dying.close()
    day.reconnect()


def _foreign_calibration(day: Day) -> None:
    day.calibration = careful_certificate(
        day.robot.model, draw_as_built(ANOTHER_ROBOT), ANOTHER_ROBOT, CALIBRATED
    )


def _gone_on_the_hook(day: Day) -> None:
    day.robot.faults.card_stalls(FOREVER_US, 0)
    day.robot.advance(BEYOND_THE_RING_S * US_PER_S)


def power_cut(day: Day, after_us: int = 0) -> None:
    """Both boards lose their power so long after now."""
    day.robot.advance(after_us)
    for board in BoardIndex:
        day.robot.set_power(board, False)


RELEASE_FAULTS = (
    Fault(
        "switch-stuck-closed",
        "Switch 1 shows closed, and only switch 2 opens at the release.",
        Moment.ARMED,
        _broken("switch", 1, "stuck-closed"),
        during(Moment.POWERED, Moment.RELEASE, Outcome.STANDS_STILL),
        noticed="holds no release",
        preflight=(),
        part="switch 1",
    ),
    Fault(
        "switch-stuck-open",
        "Switch 1 shows open while the robot hangs in the releaser.",
        Moment.POWERED,
        _broken("switch", 1, "stuck-open"),
        {
            **during(Moment.POWERED, Moment.RECORDING, Outcome.NOT_DROPPED),
            **during(Moment.ARMED, Moment.RELEASE, Outcome.FLIES),
        },
        noticed="A release switch is open (switch 1)",
        preflight=("switches",),
        part="switch 1",
    ),
    Fault(
        "switch-bounce",
        f"Both switches' contacts chatter for {BOUNCE_US // 1000} ms at the release.",
        Moment.RELEASE,
        _broken("bounce", BOUNCE_US),
        during(Moment.POWERED, Moment.RELEASE, Outcome.FLIES),
        noticed="edges fit two releases",
    ),
    Fault(
        "lift-knock",
        f"A blow in the lift opens both switches for {KNOCK_US // 1000} ms.",
        Moment.LIFTED,
        partial(_knock, open_us=KNOCK_US),
        {Moment.LIFTED: Outcome.FLIES},
    ),
    Fault(
        "crane-jolt",
        f"A jolt on the crane opens both switches for {JOLT_US // 1000} ms, as a release does, and the robot hangs on.",
        Moment.LIFTED,
        partial(_knock, open_us=JOLT_US),
        {Moment.LIFTED: Outcome.FLIES},
        noticed="false release",
    ),
    Fault(
        "release-before-arming",
        "The robot is released although it is not armed.",
        Moment.POWERED,
        lambda day: setattr(day, "arming", False),
        during(Moment.POWERED, Moment.RECORDING, Outcome.STANDS_STILL),
        noticed="did not move",
    ),
    Fault(
        "cable-pulled-while-armed",
        "The sequencer's cable is pulled right after arming.",
        Moment.ARMED,
        lambda day: day.robot.set_cable(BoardIndex.SEQUENCER, False),
        {Moment.ARMED: Outcome.FLIES},
    ),
)

BOARD_FAULTS = (
    Fault(
        "host-crash-in-upload",
        f"The program that uploads is killed after {FRAMES_BEFORE_CRASH} frames; the team starts it again.",
        Moment.POWERED,
        _host_crash,
        {Moment.POWERED: Outcome.FLIES},
    ),
    Fault(
        "wrong-maneuver",
        "18/90 is uploaded after the maneuver was read back.",
        Moment.UPLOADED,
        lambda day: day.sequencer.upload(schedule_maneuver(four_stroke(18.0, 90.0))),
        during(Moment.UPLOADED, Moment.RECORDING, Outcome.FLIES),
        noticed="Another maneuver was flown",
        preflight=("maneuver",),
    ),
    Fault(
        "watchdog-while-armed",
        "The sequencer's watchdog restarts it while it hangs armed on the hook.",
        Moment.LIFTED,
        lambda day: day.robot.reset(Reset.WATCHDOG),
        {Moment.LIFTED: Outcome.FLIES},
    ),
    Fault(
        "watchdog-while-falling",
        "The sequencer's watchdog restarts it halfway through the fall.",
        Moment.FALLING,
        lambda day: day.robot.reset(Reset.WATCHDOG),
        {Moment.FALLING: Outcome.STOPS},
        noticed="Stroke",
    ),
    Fault(
        "brown-out-at-release",
        "The sequencer's supply sags at the moment of the release; it restarts with its switches open.",
        Moment.RELEASE,
        lambda day: day.robot.reset(Reset.BROWN_OUT),
        {Moment.RELEASE: Outcome.STANDS_STILL},
        noticed="did not move",
    ),
    Fault(
        "sequencer-clock-fast",
        "The sequencer's clock runs 1 % fast.",
        Moment.POWERED,
        _broken("clock", "sequencer", ONE_PERCENT_PPM),
        during(Moment.POWERED, Moment.FALLING, Outcome.FLIES),
        noticed="clock runs",
        preflight=("clock-pace",),
        part="sequencer's clock",
    ),
    Fault(
        "logger-clock-fast",
        "The logger's clock runs 1 % fast.",
        Moment.POWERED,
        _broken("clock", "logger", ONE_PERCENT_PPM),
        during(Moment.POWERED, Moment.BEFORE_LANDING, Outcome.FLIES),
        noticed="clock runs",
        preflight=("clock-pace",),
        part="logger's clock",
    ),
)

_IMU_4, _SERVO_1 = "IMU of body 4", "servo of joint 1"
_LAST = Moment.BEFORE_LANDING
"""After the landing no servo matters any more."""


def _flies(
    name: str,
    what: str,
    strike: Callable[[Day], object],
    noticed: str,
    preflight: tuple[str, ...],
    part: str,
    moment: Moment = Moment.LIFTED,
    last: Moment = Moment.LANDED,
) -> Fault:
    """A fault of a part that keeps no robot from flying, whenever it strikes until `last`."""
    outcomes = during(Moment.POWERED, last, Outcome.FLIES)
    return Fault(name, what, moment, strike, outcomes, noticed=noticed, preflight=preflight, part=part)


SENSOR_FAULTS = (
    _flies(
        "servo-dead",
        "The servo of joint 1 does not turn.",
        _broken("servo", 1, "dead"),
        "did not move",
        (),
        _SERVO_1,
        last=_LAST,
    ),
    _flies(
        "servo-slow",
        "The servo of joint 1 reaches a quarter of its rate.",
        _broken("servo", 1, "slow"),
        "had not come to rest",
        (),
        _SERVO_1,
        last=_LAST,
    ),
    _flies(
        "servo-reversed",
        "The servo of joint 1 turns the other way.",
        _broken("servo", 1, "reversed"),
        "wrong way",
        (),
        _SERVO_1,
        last=_LAST,
    ),
    _flies(
        "gyro-dead",
        "The IMU of body 4 answers no more.",
        _broken("imu", 4, "dead"),
        "body 4",
        ("gyros-present",),
        _IMU_4,
    ),
    _flies(
        "gyro-frozen",
        "The IMU of body 4 repeats one reading.",
        _broken("imu", 4, "frozen"),
        "body 4",
        ("gyros-present",),
        _IMU_4,
    ),
    _flies(
        "gyro-swapped",
        "The plugs of the IMUs of bodies 3 and 4 were exchanged after the calibration.",
        _broken("imu", 4, "swapped", 3),
        "IMUs of bodies 3 and 4 exchanged",
        ("gyros-agree",),
        _IMU_4,
        Moment.POWERED,
    ),
    _flies(
        "gyro-saturated",
        "The gyro of body 4 shows ten times its rate, and clips.",
        _broken("imu", 4, "saturated"),
        "body 4",
        ("gyro-biases", "gyros-agree"),
        _IMU_4,
    ),
    _flies(
        "bus-glitch",
        "A disturbance spoils one transfer with the IMU of body 4: at most one of its samples is lost.",
        _broken("glitch", 4),
        "",
        (),
        _IMU_4,
        Moment.FALLING,
    ),
    _flies(
        "bus-stuck",
        "The bus of the IMUs of bodies 3 and 4 is held low.",
        _broken("bus", 2, True),
        "body 3",
        ("gyros-present",),
        "bus of the IMUs of bodies 3 and 4",
    ),
    _flies(
        "angle-sensor-slipped",
        f"The magnet of joint 1's first angle sensor slips by {SLIPPED_DEG:g} deg and wraps.",
        _broken("angle_sensor", 1, "turned", SLIPPED_DEG),
        "joint 1",
        ("joint-sensors",),
        "first angle sensor of joint 1",
    ),
    _flies(
        "calibration-of-another-robot",
        "The calibration at hand is another robot's.",
        _foreign_calibration,
        "it is not used",
        ("gyros-agree", "joint-sensors", "start-pose", "calibration"),
        "calibration",
        Moment.POWERED,
    ),
)

POWER_CUTS = tuple(
    Fault(
        name,
        f"Both boards lose their power {when} the landing.",
        moment,
        power_cut,
        {moment: Outcome.FLIES},
        complete=False,
        noticed="has no end",
        part="power of both boards",
    )
    for name, when, moment in (
        ("power-cut-before-landing", "100 ms before", Moment.BEFORE_LANDING),
        ("power-cut-at-landing", "at the moment of", Moment.LANDING),
        ("power-cut-after-landing", "100 ms after", Moment.LANDED),
    )
)
"""A power cut right after the landing comes before the second copy of the fall is written."""

_NO_CARD = ("card", "card-room", "card-writing")
_NOT_DROPPED: Outcomes = during(Moment.POWERED, Moment.CHECKED, Outcome.NOT_DROPPED)

CARD_FAULTS = (
    Fault(
        "card-slow",
        f"Now and then the card is busy for {STALL_US // 1000} ms.",
        Moment.POWERED,
        _broken("card_stalls", STALL_US, EVERY_US),
        at_any_moment(Outcome.FLIES),
        preflight=(),
        part="card",
    ),
    Fault(
        "card-gone-on-the-hook",
        f"The card takes nothing more from the lift on, and the team waits {BEYOND_THE_RING_S} s, longer than the ring "
        "in RAM bridges.",
        Moment.LIFTED,
        _gone_on_the_hook,
        {Moment.LIFTED: Outcome.FLIES},
        complete=False,
        noticed="RAM kept the newest",
        part="card",
    ),
    Fault(
        "card-full",
        "Other files fill the card.",
        Moment.POWERED,
        lambda day: day.robot.card_slot.fill(0),
        _NOT_DROPPED,
        noticed="The card has no room",
        preflight=_NO_CARD[1:],
        part="card",
    ),
    Fault(
        "card-missing",
        "No card is in the logger.",
        Moment.POWERED,
        lambda day: day.robot.card_slot.remove(),
        _NOT_DROPPED,
        noticed="No SD card answers",
        preflight=_NO_CARD,
        part="card",
    ),
    Fault(
        "card-write-protected",
        "The card forbids writing.",
        Moment.POWERED,
        lambda day: day.robot.card_slot.spoil(CardDefect.WRITE_PROTECTED),
        _NOT_DROPPED,
        noticed="The card forbids writing",
        preflight=_NO_CARD,
        part="card",
    ),
    Fault(
        "card-pulled",
        "The card is shaken out of its contacts.",
        Moment.FALLING,
        lambda day: day.robot.card_slot.remove(),
        {**_NOT_DROPPED, **during(Moment.RECORDING, Moment.LANDED, Outcome.FLIES)},
        noticed="in the logger's RAM only",
        preflight=_NO_CARD,
        part="card",
    ),
    *POWER_CUTS,
)

FAULTS = (*RELEASE_FAULTS, *BOARD_FAULTS, *SENSOR_FAULTS, *CARD_FAULTS)


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
        part = fault.part or fault.name.partition(AT)[0]
        other = of_part.setdefault(part, fault)
        if other is not fault:
            raise UsageError(
                what=f"{other.name} and {fault.name} cannot both be rehearsed: both are of the same part, {part}."
                if fault.part
                else f"{other.name} and {fault.name} are the same fault at two moments.",
                meaning="Nothing was flown: only the one that strikes last would have been rehearsed.",
                next_step=f"Rehearse one at a time: leave out --fault {other.name} or --fault {fault.name}.",
            )
    return faults


def fault_named(typed: str) -> Fault:
    """By its name, or at another moment than its own by NAME@MOMENT.

    Raises:
        UsageError: there is no such fault or moment, or the fault cannot be at that moment.
    """
    name, at, when = typed.partition(AT)
    fault = next((one for one in FAULTS if one.name == name), None)
    if fault is None:
        raise UsageError(
            what=f"There is no fault {name!r}.",
            meaning="Nothing was flown.",
            next_step="See them all: tfsat-host rehearse --list-faults",
        )
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


def listed() -> tuple[list[dict[str, Any]], tuple[Sequence[str], Sequence[Sequence[str]]]]:
    """All of them, for JSON and as a table for people."""
    moments = Column(
        "moments", of=lambda fault: {when.typed: what.value for when, what in fault.outcomes.items()}
    )
    rows = [
        (fault.name, fault.what, fault.moment.typed, words_of(fault.outcomes), fault.outcome.value)
        for fault in FAULTS
    ]
    heads = ("fault", "what happens", "when", "or @", "the robot then")
    return records((*FAULT, moments, *fields("complete noticed")), FAULTS), (heads, rows)
