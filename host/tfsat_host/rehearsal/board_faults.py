"""Faults of the releaser, of both boards, of their card and of their power."""

from __future__ import annotations

from functools import partial

from tfsat_host.devices.ports import PortError, PortProblem
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.emulated.faults import CardDefect
from tfsat_host.emulated.robot import US_PER_S, BoardIndex, Reset
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.fault import Fault, Moment, Outcome, Outcomes, at_any_moment, broken, during

BOUNCE_US = 50_000
KNOCK_US = 4_000
JOLT_US = 6_000
"""Both switches open for 5 ms are a release, whoever opened them; closed again for 200 ms, a false one."""
ONE_PERCENT_PPM = 10_000.0
FRAMES_BEFORE_CRASH = 3
STALL_US = 400_000
EVERY_US = 1_000_000
FOREVER_US = 100_000_000
BEYOND_THE_RING_S = 25


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
        broken("switch", 1, "stuck-closed"),
        during(Moment.POWERED, Moment.RELEASE, Outcome.STANDS_STILL),
        noticed="holds no release",
        preflight=(),
        part="switch 1",
    ),
    Fault(
        "switch-stuck-open",
        "Switch 1 shows open while the robot hangs in the releaser.",
        Moment.POWERED,
        broken("switch", 1, "stuck-open"),
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
        broken("bounce", BOUNCE_US),
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
        broken("clock", "sequencer", ONE_PERCENT_PPM),
        during(Moment.POWERED, Moment.FALLING, Outcome.FLIES),
        noticed="clock runs",
        preflight=("clock-pace",),
        part="sequencer's clock",
    ),
    Fault(
        "logger-clock-fast",
        "The logger's clock runs 1 % fast.",
        Moment.POWERED,
        broken("clock", "logger", ONE_PERCENT_PPM),
        during(Moment.POWERED, Moment.BEFORE_LANDING, Outcome.FLIES),
        noticed="clock runs",
        preflight=("clock-pace",),
        part="logger's clock",
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
        broken("card_stalls", STALL_US, EVERY_US),
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
