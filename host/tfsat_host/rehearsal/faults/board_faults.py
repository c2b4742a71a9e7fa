"""Faults of the boards: resets, clocks, and an upload that breaks off or is another one."""

from __future__ import annotations

from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.devices.serial_ports import PortError, PortProblem
from tfsat_host.emulated.emulated_robot import BoardIndex, Reset
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.faults.fault import Fault, Moment, Outcome, break_part, outcomes_between

FRAMES_BEFORE_CRASH = 3
WEAK_BATTERY_OHM = 0.7
"""With the currents and voltages of supply.h the sequencer restarts from 2.07 A on: two servos that start draw 2 A."""


class _DyingTransport(EmulatedTransport):
    """A cable whose program dies after a few frames."""

    _left = FRAMES_BEFORE_CRASH

    def write(self, data: bytes) -> None:
        """Sends, until the program is dead."""
        if not self._left:
            raise PortError(PortProblem.OTHER, what="The program was killed.", next_step="Start it again.")
        self._left -= 1
        super().write(data)


def _crash_host(day: Day) -> None:
    dying = SequencerClient.connect(_DyingTransport(day.robot, BoardIndex.SEQUENCER))
    try:
        dying.upload(day.schedule)
    except PortError as error:
        day.setbacks.append(f"The upload broke off and was begun again: {error.what}")
    # A new program connects; the day's own upload, which follows, begins again from the start.
    dying.close()
    day.reconnect()


def _upload_another(day: Day) -> None:
    # `record start` asks the sequencer what it holds by then: the log's header names this one.
    day.upload = day.sequencer.upload(schedule_maneuver(four_stroke(18.0, 90.0)))


def _fast_clock(board: str, last: Moment) -> Fault:
    return Fault(
        f"{board}-clock-fast",
        f"The {board}'s clock runs 1 % fast.",
        Moment.POWERED,
        outcomes_between(Moment.POWERED, last, Outcome.FLIES),
        action=break_part("clock", board, 10_000.0),
        noticed="clock runs",
        preflight=("clock-pace",),
        part=f"{board}'s clock",
    )


FAULTS = (
    Fault(
        "host-crash-in-upload",
        "The program that uploads is killed after 3 frames; the team starts it again.",
        Moment.POWERED,
        {Moment.POWERED: Outcome.FLIES},
        action=_crash_host,
    ),
    Fault(
        "wrong-maneuver",
        "18/90 is uploaded after the maneuver was read back.",
        Moment.UPLOADED,
        outcomes_between(Moment.UPLOADED, Moment.RECORDING, Outcome.FLIES),
        action=_upload_another,
        noticed="Another maneuver was flown",
        preflight=("maneuver",),
    ),
    Fault(
        "watchdog-while-armed",
        "The sequencer's watchdog restarts it while it hangs armed on the hook.",
        Moment.LIFTED,
        {Moment.LIFTED: Outcome.FLIES},
        action=lambda day: day.robot.reset(Reset.WATCHDOG),
    ),
    Fault(
        "watchdog-while-falling",
        "The sequencer's watchdog restarts it halfway through the fall.",
        Moment.FALLING,
        {Moment.FALLING: Outcome.STOPS},
        action=lambda day: day.robot.reset(Reset.WATCHDOG),
        noticed="Stroke",
    ),
    Fault(
        "brown-out-at-release",
        "The sequencer's supply sags at the moment of the release; it restarts with its switches open.",
        Moment.RELEASE,
        {Moment.RELEASE: Outcome.STANDS_STILL},
        action=lambda day: day.robot.reset(Reset.BROWN_OUT),
        noticed="did not move",
    ),
    Fault(
        "weak-battery",
        f"Battery and plugs have {WEAK_BATTERY_OHM:g} ohm: the sequencer's supply dips and restarts it where three "
        "servos move at once, not where two do.",
        Moment.POWERED,
        outcomes_between(Moment.POWERED, Moment.RELEASE, Outcome.FLIES),
        action=break_part("battery", WEAK_BATTERY_OHM),
        preflight=(),
        three_moving=(Outcome.STOPS, "supply may have dipped"),
    ),
    _fast_clock("sequencer", Moment.FALLING),
    _fast_clock("logger", Moment.BEFORE_LANDING),
)
