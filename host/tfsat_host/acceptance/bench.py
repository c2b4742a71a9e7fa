"""The bench of an acceptance: both boards, and hands that do what a task says."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from tfsat_host.acceptance.imu_wiring import MOVED_WITH
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.calibration.steps.step import bodies
from tfsat_host.devices.board_errors import NoAnswer
from tfsat_host.devices.jogging import JogClient
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.serial_ports import PortError
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import bodies_of, ignore_absent

READ_STEP_S = 0.25


class Task(StrEnum):
    """What hands do; a number says which joint or switch it is about."""

    REST = "rest"
    OPEN_AND_CLOSE = "open and close"
    TILT = "tilt"
    FREE_SWITCHES = "free switches"
    PRESS = "press"
    OPEN_HALF = "open half"
    PRESS_BOTH_UNPOWERED = "press both, servos off"
    PRESS_BOTH_POWERED = "press both, servos on"
    LET_GO = "let go"


MOVING = (Task.OPEN_HALF, Task.PRESS_BOTH_UNPOWERED, Task.PRESS_BOTH_POWERED)
"""What comes after these arms the sequencer or moves a joint."""
_BOTH = "Press both release switches and keep them pressed."
_LINES = {
    Task.REST: ("Stand the robot upright on the bench, joints closed, body 1 on top.", "Hands off for 10 s."),
    Task.TILT: (
        "Keep all joints closed. Begin upright and at rest.",
        "Tilt the whole robot by 90 deg until its y axis points up, in 2 s; stand it up again.",
    ),
    Task.FREE_SWITCHES: ("Take the robot out of the releaser; press no switch.",),
    Task.PRESS: ("Press release switch {} alone and keep it pressed.",),
    Task.OPEN_HALF: (
        "Lay the robot on its side; open each joint about half way, 45 deg.",
        "Servo power on (S4). Hands, hair and cables off: one joint after the other moves by 10 deg, then to its ends.",
        "Ctrl-C lets the joint go.",
    ),
    Task.PRESS_BOTH_UNPOWERED: (
        "Servo power OFF (S4): nothing may move.",
        _BOTH,
        "The sequencer is armed then.",
    ),
    Task.PRESS_BOTH_POWERED: (
        "Clamp the robot, joints closed and free to open. Servo power on (S4), hands off the joints.",
        _BOTH,
        "The sequencer is armed then: its servos hold 0 deg.",
        "After the release so many joints, from joint 1 on, open by 40 deg at once and close: {}.",
    ),
    Task.LET_GO: ("NOW let go of both switches at the same time, and leave them.",),
}


def describe_task(task: Task, number: int, robot: RobotModel) -> tuple[str, ...]:
    """Return the instructions of a task, line by line."""
    if task is not Task.OPEN_AND_CLOSE:
        return tuple(line.format(number) for line in _LINES[task])
    moved = MOVED_WITH[number - 1]
    held = [body for body in bodies_of(robot) if body not in moved]
    return (
        f"Close all joints; hold {bodies(held)} on the bench. Begin at rest.",
        f"Open joint {number} to its end in 2 s by moving {bodies(moved)}; close it again.",
    )


class StillArmed(TfsatError):
    """The sequencer could not be disarmed: the session ends, and this is the last thing on the screen."""


class Hands(Protocol):
    """Whoever holds and moves robot and switches: two people, or a program."""

    def do(self, task: Task, number: int = 0) -> None:
        """Has a task done, or begun where it is a motion. Raises TfsatError: it will not be."""


@dataclass
class Bench:
    """Where an acceptance happens.

    Attributes:
        robot: By design.
        sequencer: To be replaced after a restart by `reopen`.
        logger: Reads the sensors.
        hands: See there.
        reopen: Finds the sequencer again after its restart took the link. Raises TfsatError: it does not come back.
        note: Tells the people something.
        unhurried: Holds signals such as Ctrl-C back while the sequencer is being disarmed.
        progress: Shows that something goes on, given what and for how many seconds.
    """

    robot: RobotModel
    sequencer: JogClient
    logger: LoggerClient
    hands: Hands
    reopen: Callable[[], JogClient]
    note: Callable[[str], None]
    progress: Callable[[str, float], AbstractContextManager[Callable[[float], None]]]
    unhurried: Callable[[], AbstractContextManager[None]] = nullcontext

    @property
    def joints(self) -> range:
        """Numbers of the joints that are there."""
        return range(1, len(bodies_of(self.robot)))

    def read(self, duration_s: float) -> SensorSamples:
        """Read the sensors for so long. Raises CalibrationError: the logger sent nothing; PortError."""
        samples = []
        with self.logger.live() as scales, self.progress("Reading the sensors", duration_s) as advance:
            for _ in range(round(duration_s / READ_STEP_S)):
                samples += self.logger.samples_of(READ_STEP_S)
                advance(READ_STEP_S)
        if not samples:
            raise CalibrationError(
                what=f"The logger sent no sample in {duration_s:g} s.",
                meaning="It has stopped sampling: nothing of this step was measured.",
                next_step=Advice("Switch it off and on; ", NextStep("status")),
            )
        return SensorSamples.from_counts(ignore_absent(Counts.from_live(samples, scales), self.robot))

    def disarm(self) -> None:
        """Disarm the sequencer and see that it is safe, over a new link if the old one broke.

        Raises:
            StillArmed: it may still be armed.
        """
        with self.unhurried():
            try:
                self._disarm_once()
            except (NoAnswer, PortError):
                self.note(f"  LINK LOST. {_MAY_BE_ARMED}")
                # A restart takes the USB link with it, and the bootloader keeps the port for 8 s.
                with suppress(TfsatError):
                    self.sequencer.close()
                try:
                    self.sequencer = self.reopen()
                    self._disarm_once()
                except TfsatError as error:
                    raise _still_armed(error.what) from None

    def _disarm_once(self) -> None:
        self.sequencer.disarm()
        state = self.sequencer.status().state
        if state != SequencerState.SAFE:
            raise _still_armed(f"It says that it is {state.name.lower()}.")


_MAY_BE_ARMED = "IT MAY STILL BE ARMED, or drive a joint: hands off the joints, KEEP both switches pressed."


def _still_armed(reason: str) -> StillArmed:
    return StillArmed(
        what=f"The sequencer could not be disarmed. {reason}",
        meaning=_MAY_BE_ARMED,
        next_step=Advice(
            "Open S4, then S3, pull the sequencer's cable and wait some seconds. Later: ", NextStep("disarm")
        ),
    )
