"""One drop on the emulated robot: upload, record, arm, lift, release, fall, land."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.sequencer import SequencerClient, UploadResult
from tfsat_host.emulated.certificate import careful_certificate
from tfsat_host.emulated.robot import SETTLE_US, US_PER_S, BoardIndex, EmulatedRobot
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.maneuver import Schedule
from tfsat_host.protocol.messages import RecordStopReply, SequencerStatusReply

FloatArray = NDArray[np.float64]
Progress = Callable[[str], None]

WAIT_US = 3 * US_PER_S
"""In the releaser before the drop: the bias is read from this; real waits are minutes."""
KNOCK_US = 20_000
AFTER_LANDING_US = US_PER_S
TRUTH_PERIOD_US = 1000
RESIDUAL_RATE_DEG_S = (-0.73, -0.48, -0.77)
"""Of body 3 about its axes after the paper's release (sec. Result): the robot does not leave the releaser at rest."""
CALIBRATED = datetime(2026, 1, 5, 8, 0, tzinfo=UTC)
"""When the emulated robot was calibrated; it is dropped an hour later."""
DROPPED = CALIBRATED + timedelta(hours=1)
RESIDUAL_RATE_RAD_S = tuple(np.deg2rad(RESIDUAL_RATE_DEG_S))


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """What one rehearsed drop left behind.

    Attributes:
        card: The recording file, byte by byte.
        upload: Of the maneuver that flew.
        sequencer: The sequencer's status after landing.
        recording: The logger's account of the recording.
        calibration: What a day on the bench would have told of this robot.
        truth: See `EmulatedRobot.truth`; from the start of the recording.
        released_s: Virtual time at which both switches first were open.
        landed_s: Virtual time of the landing.
    """

    card: bytes
    upload: UploadResult
    sequencer: SequencerStatusReply
    recording: RecordStopReply
    calibration: Calibration
    truth: FloatArray
    released_s: float
    landed_s: float


def rehearse(
    schedule: Schedule,
    *,
    seed: int,
    hex_path: Path | None = None,
    residual_rate_rad_s: Sequence[float] = RESIDUAL_RATE_RAD_S,
    progress: Progress = lambda _: None,
) -> Rehearsal:
    """Flies `schedule` on the emulated robot, from the upload to the closed recording.

    Args:
        schedule: What to fly.
        seed: For the robot's imperfections, noise and contact bounce.
        hex_path: The sequencer's image; None runs its core natively.
        residual_rate_rad_s: Of body 3, its frame, at release; the paper's by default.
        progress: Told what is going on.

    Raises:
        TfsatError: whatever a board refuses, as on the day of the drop.
    """
    session_seed = _session_seed(schedule, seed, hex_path, residual_rate_rad_s)
    with EmulatedRobot(seed=seed, session_seed=session_seed, hex_path=hex_path) as robot:
        robot.advance(SETTLE_US)
        sequencer = SequencerClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER))
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        progress("uploading, reading back")
        upload = sequencer.upload(schedule)
        progress("recording in the releaser")
        robot.record_truth(TRUTH_PERIOD_US)
        logger.start_recording(unix_us=round(DROPPED.timestamp() * US_PER_S))
        robot.advance(WAIT_US)
        sequencer.arm()
        progress("armed; cables pulled; the crane lifts, one switch is knocked")
        for board in BoardIndex:
            robot.set_cable(board, False)
        robot.knock(1, KNOCK_US)
        robot.advance(US_PER_S)
        progress("release, fall, landing")
        robot.drop(residual_rate_rad_s)
        while robot.falling:
            robot.advance(TRUTH_PERIOD_US)
        landed_us = robot.now_us
        robot.advance(AFTER_LANDING_US)
        progress("cables plugged; the recording is closed")
        for board in BoardIndex:
            robot.set_cable(board, True)
        robot.advance(SETTLE_US)
        recording = logger.stop_recording()
        return Rehearsal(
            card=robot.card(),
            upload=upload,
            sequencer=sequencer.status(),
            recording=recording,
            calibration=careful_certificate(robot.model, robot.imperfections, seed, CALIBRATED),
            truth=robot.truth(),
            released_s=robot.released_us / US_PER_S,
            landed_s=landed_us / US_PER_S,
        )


def _session_seed(schedule: Schedule, seed: int, hex_path: Path | None, rate_rad_s: Sequence[float]) -> int:
    """Another one for everything that makes another drop, the same for the same drop."""
    image = b"" if hex_path is None else hex_path.read_bytes()
    drop = repr((seed, schedule.strokes, schedule.speed_cdeg_s, tuple(map(float, rate_rad_s)))).encode()
    return int.from_bytes(hashlib.sha256(drop + b"\0" + image).digest()[:8], "little")
