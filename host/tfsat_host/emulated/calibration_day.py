"""All steps of a calibration on one emulated robot, as a person does them on the bench; its truth is known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from tfsat_host.calibration.steps import step as steps
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.evidence import Evidence, Origin
from tfsat_host.calibration.steps.step import Step
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.bench import EmulatedOperator
from tfsat_host.emulated.hands import Hands
from tfsat_host.emulated.imperfections import Imperfections
from tfsat_host.emulated.robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.protocol.messages import LiveSampleStream
from tfsat_host.robot import RobotModel

MORNING = datetime(2026, 1, 5, 8, 0, tzinfo=UTC)
"""When an emulated day begins."""


def all_steps() -> tuple[Step, ...]:
    """What a gyro and an angle sensor need, in order; servos are another command's."""
    joints = range(1, JOINT_COUNT + 1)
    return (
        steps.rest(),
        steps.zero(None),
        *(swing for joint in joints for swing in steps.swings(joint)),
        *(sweep for joint in joints for sweep in steps.sweeps(joint)),
        steps.turn("z", 360.0),
    )


@dataclass(frozen=True, eq=False)
class CalibrationDay:
    """What was recorded, and of whom.

    Attributes:
        evidence: One recording a step, in order.
        model: How the robot is meant to be.
        truth: How it is.
    """

    evidence: tuple[Evidence, ...]
    model: RobotModel
    truth: Imperfections


def calibration_day(
    model: RobotModel,
    truth: Imperfections,
    hands: Hands,
    seed: int,
    todo: Sequence[Step] = (),
    told: Callable[[Step], None] = lambda _: None,
) -> CalibrationDay:
    """Records the steps `todo`, all by default, through the logger's own firmware.

    Args:
        model: The robot by design.
        truth: Its hidden errors.
        hands: Who holds and moves it.
        seed: For noise.
        todo: Steps, in order.
        told: Called with each step before it is recorded.
    """
    with EmulatedRobot(model, imperfections=truth, seed=seed) as robot:
        robot.advance(SETTLE_US)
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        operator = EmulatedOperator(robot, hands)
        evidence = []
        for step in todo or all_steps():
            told(step)
            evidence.append(recorded(robot, logger, operator, step))
        return CalibrationDay(tuple(evidence), model, truth)


def recorded(robot: EmulatedRobot, logger: LoggerClient, operator: EmulatedOperator, step: Step) -> Evidence:
    """One step."""
    taken = MORNING + timedelta(microseconds=robot.now_us)
    samples: list[LiveSampleStream] = []
    with logger.live() as reply:
        operator.begin(step)
        end_us = robot.now_us + round(1e6 * operator.duration_s(step))
        while robot.now_us < end_us:
            samples += logger.live_samples()
    identity, who = logger.identity, logger.status().who_am_i
    origin = Origin(identity.serial, bytes(who).hex(), True, identity.firmware, identity.image_crc)
    return Evidence(step, Counts.from_live(samples, reply), taken, origin)
