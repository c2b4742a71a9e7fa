"""Where a calibration happens: the boards, whose sensors they are, and who holds and moves the robot."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from tfsat_host.calibration.steps.step import ALL_BODIES, Step, StepKind, task, title, zero
from tfsat_host.cli.boards import explain_wrong_state, offering_emulated, open_jog_client, open_logger
from tfsat_host.devices.jogging import JogClient
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.calibration.steps.evidence import Origin
    from tfsat_host.emulated.emulated_operator import EmulatedOperator
    from tfsat_host.robot import RobotModel

LEAD_S = 3.0
"""With `--yes` the sensors are read so long after the task: time to hold the robot and to move it."""
PERSON_SEED = 1
"""The emulated bench's person is always the same one."""


class Mover(Protocol):
    """Who holds and moves the robot."""

    @property
    def lead_s(self) -> float:
        """From `begin` to the moment from which the sensors are to be read."""

    def begin(self, step: Step) -> None:
        """Sets the robot up for the step and starts the motion."""


@dataclass(frozen=True)
class Bench:
    """Where a calibration happens.

    Attributes:
        logger: Reads the sensors.
        mover: Moves the robot; where the sequencer moves a joint, holds the rest of it.
        origin: Whose sensors they are.
        sequencer: Moves a joint; None where a hand does.
    """

    logger: LoggerClient
    mover: Mover
    origin: Origin
    sequencer: JogClient | None = None

    @property
    def jog(self) -> JogClient:
        """The sequencer. Raises ValueError where a hand moves the joint."""
        if self.sequencer is None:
            raise ValueError("no sequencer was opened")
        return self.sequencer


class PersonAtPrompt:
    """Tells a person what to do and waits for Enter; with `--yes` the reading starts after `LEAD_S`."""

    def __init__(
        self, out: Output, *, jogging: bool = False, robot_bodies: Sequence[int] = ALL_BODIES
    ) -> None:
        self._out = out
        self._jogging = jogging
        self._robot_bodies = robot_bodies

    @property
    def lead_s(self) -> float:
        """Zero where Enter says that all is ready."""
        return LEAD_S if self._out.yes else 0.0

    def begin(self, step: Step) -> None:
        """Asks for it. Raises UsageError without a terminal, NotConfirmed for anything but Enter."""
        if self._jogging and step.joint is not None:  # the question whether to move it was asked already
            if self._out.yes:
                self._out.note(f"  Joint {step.joint} moves in {LEAD_S:g} s.")
            return
        announce(step, self._out, self._robot_bodies)
        if self._out.yes:
            self._out.note(f"Reading starts in {LEAD_S:g} s.")
        else:
            self._out.ask(
                "Press Enter to start, q to quit: ", meaning="This step was not measured.", accept=("",)
            )


class EmulatedPerson:
    """The emulated bench's person, with the screen saying what is done."""

    lead_s = 0.0

    def __init__(
        self,
        operator: EmulatedOperator,
        out: Output,
        *,
        jogging: bool = False,
        robot_bodies: Sequence[int] = ALL_BODIES,
    ) -> None:
        self._operator = operator
        self._out = out
        self._jogging = jogging
        self._robot_bodies = robot_bodies

    def begin(self, step: Step) -> None:
        """Begin the step at once.

        Where a servo moves the joint, the emulated person first closes that joint, then holds the other bodies.
        """
        if self._jogging and step.joint is not None:
            self._operator.wait_until_limp()  # the servo of the sweep before has let go
            self._operator.begin(zero(step.joint))
            self._operator.begin(Step(StepKind.SERVO, step.joint, step.moved, step.held))
            return
        if not self._out.json_mode:
            announce(step, self._out, self._robot_bodies)
        self._operator.begin(step)


def announce(step: Step, out: Output, robot_bodies: Sequence[int]) -> None:
    """Print the heading and the task of a step that is done by hand."""
    out.note("\n  ".join((f"\n{title(step)}", *task(step, robot_bodies))))


@contextmanager
def open_bench(
    args: argparse.Namespace, model: RobotModel, out: Output, *, jog: bool = False
) -> Iterator[Bench]:
    """Open the logger and, to `jog`, the sequencer, with the person or emulated one who moves the robot.

    Raises:
        PortError, NoAnswer, WrongBoard, BuildError: a board cannot be reached, or the emulated robot not built.
    """
    from tfsat_host.robot.absent_parts import bodies_of

    if not args.emulated:
        at_sequencer = argparse.Namespace(emulated=False, port=getattr(args, "sequencer_port", None))
        with (
            offering_emulated(),
            open_logger(args, out) as logger,
            open_jog_client(at_sequencer, out) if jog else nullcontext() as sequencer,
        ):
            yield Bench(
                logger,
                PersonAtPrompt(out, jogging=jog, robot_bodies=bodies_of(model)),
                origin_of(logger),
                sequencer,
            )
        return
    from tfsat_host.emulated.emulated_operator import EmulatedOperator
    from tfsat_host.emulated.emulated_robot import BoardIndex
    from tfsat_host.emulated.emulated_transport import EmulatedTransport
    from tfsat_host.emulated.manual_motion import Operator
    from tfsat_host.emulated.state import kept_robot

    with kept_robot(out.note, model=model, as_built=True) as robot:
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        operator = EmulatedOperator(robot, Operator.human(PERSON_SEED))
        person = EmulatedPerson(operator, out, jogging=jog, robot_bodies=bodies_of(model))
        sequencer = JogClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER)) if jog else None
        with nullcontext() if sequencer is None else explain_wrong_state(sequencer):
            yield Bench(logger, person, origin_of(logger), sequencer)


def origin_of(logger: LoggerClient) -> Origin:
    """Whose sensors hang on the logger; a core that runs natively is an emulated robot's."""
    from tfsat_host.preflight.preflight_evidence import origin_of_logger

    return origin_of_logger(logger.identity, logger.status().who_am_i)
