"""The morning of a rehearsed day: the robot lies on the bench, and its gyros' biases are taken.

As `tfsat-host calibrate bias` takes them: the logger is asked for its samples, the same solver makes biases of them,
and the raw samples are kept. The dies are cold and feel their weight. All else in the certificate is drawn
(`careful_certificate`), and it says so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta

from tfsat_host.calibration.certificate.campaign import with_measured
from tfsat_host.calibration.certificate.certificate import Calibration, Paper
from tfsat_host.calibration.steps.evidence import (
    Evidence,
    LiveSource,
    file_name,
    read_step,
    sha256,
    to_bytes,
    until_s,
)
from tfsat_host.calibration.steps.step import DURATION_S, StepKind, rest
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.bench import EmulatedOperator
from tfsat_host.emulated.certificate import careful_certificate
from tfsat_host.emulated.robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.preflight.origin import origin_of_logger
from tfsat_host.protocol.messages import LiveSampleStream
from tfsat_host.rehearsal.day import CALIBRATED
from tfsat_host.rehearsal.truth import Truth
from tfsat_host.robot import RobotModel

_PIECE_US = 50_000
"""Of the rest, at once: the cable holds more than twice as many samples."""


@dataclass(frozen=True)
class Morning:
    """What the bench tells.

    Attributes:
        calibration: The certificate as it is signed.
        recordings: That it rests on, by their files' names.
    """

    calibration: Calibration
    recordings: Mapping[str, bytes]


def lived(robot: EmulatedRobot, filed: RobotModel, truth: Truth) -> Morning:
    """From the logger's power-up on the bench until the robot hangs in the releaser with both boards started.

    Args:
        robot: Just made.
        filed: As its file has it: the calibration is in its terms.
        truth: What cannot be measured in minutes is drawn from it.

    Raises:
        CalibrationError: the robot did not rest.
    """
    robot.set_power(BoardIndex.SEQUENCER, False)
    robot.advance(SETTLE_US)
    rested = _rested(robot)
    data, file = to_bytes(rested), file_name(rested)
    drawn = careful_certificate(filed, truth.imperfections, truth.seed, CALIBRATED)
    calibration = replace(
        with_measured(drawn, [rested], filed),
        papers=(Paper(rested.step.key, rested.taken, file, sha256(data)),),
        written=_clock(robot),
        drawn=tuple(name for name in drawn.drawn if name != "bias"),
    )
    robot.seat()
    robot.set_power(BoardIndex.SEQUENCER, True)
    robot.advance(SETTLE_US)
    return Morning(calibration, {file: data})


def _rested(robot: EmulatedRobot) -> Evidence:
    logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
    step = rest()
    EmulatedOperator(robot).begin(step)
    origin = origin_of_logger(logger.identity, logger.status().who_am_i)

    def fresh() -> Sequence[LiveSampleStream]:
        robot.advance(_PIECE_US)
        return logger.live_samples()

    with logger.live() as scales:
        live = LiveSource(fresh, scales, origin, lambda: _clock(robot))
        return read_step(step, live, until_s(DURATION_S[StepKind.REST]))


def _clock(robot: EmulatedRobot) -> datetime:
    return CALIBRATED + timedelta(microseconds=robot.now_us)
