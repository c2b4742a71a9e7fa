"""A bench at which a servo moves the joint: both boards, and whoever holds the rest of the robot."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tfsat_host.cli.calibrate.bench import HANDS_SEED, Bench, origin_of
from tfsat_host.cli.calibrate.prompts import LEAD_S, PersonAtPrompt
from tfsat_host.cli.options import port_name
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.calibration.steps.step import Step
    from tfsat_host.devices.jogging import JogClient
    from tfsat_host.emulated.bench import EmulatedOperator
    from tfsat_host.robot import RobotModel


@dataclass(frozen=True)
class JogBench(Bench):
    """A bench at which a servo moves the joint.

    Attributes:
        sequencer: Drives it.
    """

    sequencer: JogClient


class _PersonBeside:
    """Holds the robot, and was asked already."""

    def __init__(self, out: Output) -> None:
        self._out = out

    @property
    def lead_s(self) -> float:
        """With `--yes` nobody says that the robot is held."""
        return LEAD_S if self._out.yes else 0.0

    def begin(self, step: Step) -> None:
        """Says when it moves; a rest before that is asked for."""
        if step.joint is None:
            PersonAtPrompt(self._out).begin(step)
        elif self._out.yes:
            self._out.note(f"  Joint {step.joint} moves {LEAD_S:g} s from now.")


class EmulatedBeside:
    """The emulated bench's person: closes the joint, and holds what the servo is not to move."""

    lead_s = 0.0

    def __init__(self, operator: EmulatedOperator) -> None:
        self._operator = operator

    def begin(self, step: Step) -> None:
        """As soon as the servo of the sweep before has let go."""
        from tfsat_host.calibration.steps.step import Step, StepKind, zero

        if step.joint is None:
            self._operator.begin(step)
            return
        self._operator.wait_until_limp()
        self._operator.begin(zero(step.joint))
        self._operator.begin(Step(StepKind.SERVO, step.joint, step.moved, step.held))


def add_sequencer_port(parser: argparse.ArgumentParser) -> None:
    """`--sequencer-port`, beside the logger's `--port`."""
    parser.add_argument(
        "--sequencer-port",
        metavar="PORT",
        type=port_name,
        help="serial port of the sequencer, which moves the joint; without it the environment's "
        "TFSAT_SEQUENCER_PORT, else the one port that looks like this board",
    )


@contextmanager
def open_jog_bench(args: argparse.Namespace, model: RobotModel, out: Output) -> Iterator[JogBench]:
    """Both boards, and whoever holds the robot. Raises PortError, NoAnswer, WrongBoard, BuildError."""
    from tfsat_host.cli.advice import explained, offering_emulated
    from tfsat_host.cli.connection import emulated_robot, open_jog_client, open_logger
    from tfsat_host.devices.jogging import JogClient
    from tfsat_host.devices.logger import LoggerClient

    if not args.emulated:
        at_sequencer = argparse.Namespace(emulated=False, port=args.sequencer_port)
        with (
            offering_emulated(),
            open_logger(args, out) as logger,
            open_jog_client(at_sequencer, out) as sequencer,
        ):
            yield JogBench(logger, _PersonBeside(out), origin_of(logger), sequencer)
        return
    from tfsat_host.emulated.bench import EmulatedOperator
    from tfsat_host.emulated.hands import Hands
    from tfsat_host.emulated.robot import BoardIndex
    from tfsat_host.emulated.transport import EmulatedTransport

    with emulated_robot(out, model=model, as_built=True) as robot:
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        sequencer = JogClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER))
        beside = EmulatedBeside(EmulatedOperator(robot, Hands.human(HANDS_SEED)))
        with explained(sequencer, argparse.Namespace(emulated=True, port=None)):
            yield JogBench(logger, beside, origin_of(logger), sequencer)
