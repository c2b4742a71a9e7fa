"""All steps of a calibration on one emulated robot, as they are done on the bench; its truth is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from tfsat_host.calibration.steps import step as steps
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.evidence import Evidence, Origin
from tfsat_host.calibration.steps.step import Step
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_operator import EmulatedOperator
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.imperfections import Imperfections
from tfsat_host.emulated.manual_motion import Operator
from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.robot import RobotModel

DAY_BEGINS = datetime(2026, 1, 5, 8, 0, tzinfo=UTC)


def all_steps() -> tuple[Step, ...]:
    """Return the steps that gyros and angle sensors need, in order.

    Servos are another command's.
    """
    joints = range(1, JOINT_COUNT + 1)
    swings = (swing for joint in joints for swing in steps.swings(joint))
    sweeps = (sweep for joint in joints for sweep in steps.sweeps(joint))
    # Biases and zero points first: every later step is judged by them.
    return (steps.rest(), steps.zero(None), *swings, *sweeps, steps.turn("z", 360.0))


@dataclass(frozen=True, eq=False)
class CalibrationDay:
    """One recording a step, in order; how the robot is meant to be, and how it is."""

    evidence: tuple[Evidence, ...]
    model: RobotModel
    truth: Imperfections


def calibration_day(
    model: RobotModel, truth: Imperfections, hands: Operator, seed: int, todo: Sequence[Step] = ()
) -> CalibrationDay:
    """Records the steps `todo`, all by default, through the logger's own firmware; `seed` is for noise."""
    with EmulatedRobot(model, imperfections=truth, seed=seed) as robot:
        robot.advance(SETTLE_US)
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        operator = EmulatedOperator(robot, hands)
        evidence = tuple(record_step(robot, logger, operator, step) for step in todo or all_steps())
    return CalibrationDay(evidence, model, truth)


def record_step(
    robot: EmulatedRobot, logger: LoggerClient, operator: EmulatedOperator, step: Step
) -> Evidence:
    """Record one step."""
    recorded_at = DAY_BEGINS + timedelta(microseconds=robot.now_us)
    identity, who = logger.identity, logger.status().who_am_i
    origin = Origin(identity.serial, bytes(who).hex(), True, identity.firmware, identity.image_crc)
    samples: list[LiveSample] = []
    # Live streaming stays on from before the motion to its end.
    with logger.live() as scales:
        operator.begin(step)
        end_us = robot.now_us + round(1e6 * operator.duration_s(step))
        while robot.now_us < end_us:
            samples += logger.live_samples()
    # The origin ties the recording to its logger: another board's is refused.
    return Evidence(step, Counts.from_live(samples, scales), recorded_at, origin)
