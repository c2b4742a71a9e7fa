"""Where a calibration happens: a logger, whose sensors they are, and who holds and moves the robot."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from tfsat_host.cli.calibrate.prompts import PersonAtPrompt, announce
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.calibration.certificate.certificate import Subject
    from tfsat_host.calibration.steps.evidence import Origin
    from tfsat_host.calibration.steps.step import Step
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.emulated.bench import EmulatedOperator
    from tfsat_host.robot import RobotModel

HANDS_SEED = 1
"""The emulated bench's person is always the same one."""


class Operator(Protocol):
    """Who holds and moves the robot: a person at the prompt, or the emulated bench."""

    @property
    def lead_s(self) -> float:
        """From `begin` to the moment from which the sensors are to be read."""

    def begin(self, step: Step) -> None:
        """Sets the robot up for the step and starts the motion."""


class ToldOperator:
    """The emulated bench, with the screen saying what it does."""

    lead_s = 0.0

    def __init__(self, operator: EmulatedOperator, out: Output) -> None:
        self._operator = operator
        self._out = out

    def begin(self, step: Step) -> None:
        """As a person would, at once."""
        if not self._out.json_mode:
            announce(step, self._out)
        self._operator.begin(step)


@dataclass(frozen=True)
class Bench:
    """Where a calibration happens.

    Attributes:
        logger: Reads the sensors.
        operator: Moves the robot.
        origin: Whose sensors they are.
    """

    logger: LoggerClient
    operator: Operator
    origin: Origin


@contextmanager
def open_bench(args: argparse.Namespace, model: RobotModel, out: Output) -> Iterator[Bench]:
    """The logger and whoever moves the robot. Raises PortError, NoAnswer, WrongBoard, BuildError."""
    from tfsat_host.cli.advice import offering_emulated
    from tfsat_host.cli.connection import emulated_robot, open_logger
    from tfsat_host.devices.logger import LoggerClient

    if not args.emulated:
        with offering_emulated(), open_logger(args, out) as logger:
            yield Bench(logger, PersonAtPrompt(out), origin_of(logger))
        return
    from tfsat_host.emulated.bench import EmulatedOperator
    from tfsat_host.emulated.hands import Hands
    from tfsat_host.emulated.robot import BoardIndex
    from tfsat_host.emulated.transport import EmulatedTransport

    with emulated_robot(out, model=model, as_built=True) as robot:
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        operator = EmulatedOperator(robot, Hands.human(HANDS_SEED))
        yield Bench(logger, ToldOperator(operator, out), origin_of(logger))


def origin_of(logger: LoggerClient) -> Origin:
    """Whose sensors hang on the logger; a core that runs natively is an emulated robot's."""
    from tfsat_host.preflight.origin import origin_of_logger

    return origin_of_logger(logger.identity, logger.status().who_am_i)


def subject_of(origin: Origin, model: RobotModel) -> Subject:
    """What a certificate of these sensors is of."""
    from tfsat_host.calibration.certificate.certificate import Subject

    return Subject(model.name, origin.logger_serial, origin.who_am_i, origin.emulated)
