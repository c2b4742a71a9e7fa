"""What the faults of `faults.toml` do that strike on the day: to the releaser, boards, sensors, card and power."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from tfsat_host.devices.ports import PortError, PortProblem
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.emulated.certificate import careful_certificate
from tfsat_host.emulated.faults import CardDefect
from tfsat_host.emulated.imperfections import draw_as_built
from tfsat_host.emulated.robot import US_PER_S, BoardIndex, Reset
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.rehearsal.day import CALIBRATED, Day

FRAMES_BEFORE_CRASH = 3
ANOTHER_ROBOT = 4711
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


def _gone_on_the_hook(day: Day) -> None:
    day.robot.faults.card_stalls(FOREVER_US, 0)
    day.robot.advance(BEYOND_THE_RING_S * US_PER_S)


def power_cut(day: Day, after_us: int = 0) -> None:
    """Both boards lose their power so long after now."""
    day.robot.advance(after_us)
    for board in BoardIndex:
        day.robot.set_power(board, False)


def _foreign_calibration(day: Day) -> None:
    day.calibration = careful_certificate(
        day.robot.model, draw_as_built(ANOTHER_ROBOT), ANOTHER_ROBOT, CALIBRATED
    )


def _spoiled(defect: CardDefect) -> Callable[[Day], object]:
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
    "card-write-protected": _spoiled(CardDefect.WRITE_PROTECTED),
    "card-pulled": lambda day: day.robot.card_slot.remove(),
    # One right after the landing comes before the second copy of the fall is written.
    **dict.fromkeys(
        ("power-cut-before-landing", "power-cut-at-landing", "power-cut-after-landing"), power_cut
    ),
}
"""By the fault's name."""
