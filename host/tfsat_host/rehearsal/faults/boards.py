"""Faults of the sequencer, its supply, the host and the clocks."""

from __future__ import annotations

from tfsat_host.devices.ports import PortError, PortProblem
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.emulated.robot import BoardIndex, Reset
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.rehearsal.day import Day
from tfsat_host.rehearsal.faults.fault import Fault, Outcome, during
from tfsat_host.rehearsal.moment import Moment

ONE_PERCENT_PPM = 10_000.0
FRAMES_BEFORE_CRASH = 3


class _Dying(EmulatedTransport):
    """A cable whose program dies after a few frames."""

    _left = FRAMES_BEFORE_CRASH

    def write(self, data: bytes) -> None:
        """Sends, until there is nobody left who would."""
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


def _wrong_maneuver(day: Day) -> None:
    day.sequencer.upload(schedule_maneuver(four_stroke(18.0, 90.0)))


def _watchdog(day: Day) -> None:
    day.robot.reset(Reset.WATCHDOG)


def _brown_out(day: Day) -> None:
    day.robot.reset(Reset.BROWN_OUT)


def _fast_sequencer(day: Day) -> None:
    day.robot.faults.clock("sequencer", ONE_PERCENT_PPM)


def _fast_logger(day: Day) -> None:
    day.robot.faults.clock("logger", ONE_PERCENT_PPM)


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
        "Somebody uploads 18/90 after the maneuver was read back.",
        Moment.UPLOADED,
        _wrong_maneuver,
        during(Moment.UPLOADED, Moment.RECORDING, Outcome.FLIES),
        noticed="Another maneuver was flown",
        morning=("maneuver",),
    ),
    Fault(
        "watchdog-while-armed",
        "The sequencer's watchdog restarts it while it hangs armed on the hook.",
        Moment.LIFTED,
        _watchdog,
        {Moment.LIFTED: Outcome.FLIES},
    ),
    Fault(
        "watchdog-while-falling",
        "The sequencer's watchdog restarts it halfway through the fall.",
        Moment.FALLING,
        _watchdog,
        {Moment.FALLING: Outcome.STOPS},
        noticed="Stroke",
    ),
    Fault(
        "brown-out-at-release",
        "The sequencer's supply sags at the moment of the release; it starts anew and finds its switches open.",
        Moment.RELEASE,
        _brown_out,
        {Moment.RELEASE: Outcome.STANDS_STILL},
        noticed="did not move",
    ),
    Fault(
        "sequencer-clock-fast",
        "The sequencer's clock runs 1 % fast.",
        Moment.POWERED,
        _fast_sequencer,
        during(Moment.POWERED, Moment.FALLING, Outcome.FLIES),
        noticed="clock runs",
        morning=("clock-pace",),
        part="sequencer's clock",
    ),
    Fault(
        "logger-clock-fast",
        "The logger's clock runs 1 % fast.",
        Moment.POWERED,
        _fast_logger,
        during(Moment.POWERED, Moment.BEFORE_LANDING, Outcome.FLIES),
        noticed="clock runs",
        morning=("clock-pace",),
        part="logger's clock",
    ),
)
