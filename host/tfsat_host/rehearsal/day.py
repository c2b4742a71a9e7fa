"""One drop on the emulated robot: upload, record, arm, lift, wait, release, fall, land, fetch.

It goes as a careful team would go: what a board refuses ends the day before anything is let go. Faults change what
happens at the moments between.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.sequencer import SequencerClient, UploadResult
from tfsat_host.emulated.certificate import careful_certificate
from tfsat_host.emulated.robot import FALL_S, SETTLE_US, US_PER_S, BoardIndex, EmulatedRobot
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.errors import TfsatError
from tfsat_host.maneuver import Schedule
from tfsat_host.protocol.messages import RecordStopReply, SequencerStatusReply
from tfsat_host.rehearsal.moment import Moment
from tfsat_host.rehearsal.truth import Truth
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]
Progress = Callable[[str], None]

HANG_US = 3 * US_PER_S
"""In the releaser before the lift: the biases are checked against this."""
KNOCK_US = 20_000
WAIT_US = US_PER_S
"""On the crane's hook. Real waits are minutes, in which nothing happens that a second does not show."""
GUARD_US = 100_000
"""Before and after the landing: power cuts come there."""
AFTER_LANDING_US = 900_000
TRUTH_PERIOD_US = 1000
CALIBRATED = datetime(2026, 1, 5, 8, 0, tzinfo=UTC)
"""When the emulated robot was calibrated; it is dropped an hour later."""
DROPPED = CALIBRATED + timedelta(hours=1)


@dataclass(frozen=True, eq=False)
class Drop:
    """What one rehearsed day left behind.

    Attributes:
        card: The newest recording on the card, byte by byte; empty if there is none.
        upload: Of the maneuver that flew; None: it did not come through.
        sequencer: Its status after the landing; None: it does not answer.
        recording: The logger's account of the recording; None: it does not answer, or has none.
        calibration: What a day on the bench would have told of this robot.
        truth: See `EmulatedRobot.truth`; from the start of the recording.
        released_s: Virtual time at which both switches first were open; None: nobody let go.
        landed_s: Virtual time of the landing; None: nobody let go.
        refused: What ended the day before the drop; None: nothing did.
        setbacks: What else went wrong on the way; a sentence each.
    """

    card: bytes
    upload: UploadResult | None
    sequencer: SequencerStatusReply | None
    recording: RecordStopReply | None
    calibration: Calibration
    truth: FloatArray
    released_s: float | None
    landed_s: float | None
    refused: TfsatError | None
    setbacks: tuple[str, ...]


@dataclass(eq=False)
class Day:
    """The day while it goes on; what faults act on.

    Attributes:
        robot: With its boards.
        schedule: Of the maneuver.
        sequencer: Its connection.
        logger: Its connection.
        calibration: That the drop will be evaluated with.
        skipped: Steps that a fault has the team leave out.
        setbacks: See `Drop`.
        landed_us: Virtual time of the landing.
    """

    robot: EmulatedRobot
    schedule: Schedule
    sequencer: SequencerClient
    logger: LoggerClient
    calibration: Calibration
    skipped: set[str] = field(default_factory=set)
    setbacks: list[str] = field(default_factory=list)
    landed_us: int = 0

    def reconnect(self) -> None:
        """As a program that is started anew does."""
        self.sequencer = SequencerClient.connect(EmulatedTransport(self.robot, BoardIndex.SEQUENCER))
        self.logger = LoggerClient.connect(EmulatedTransport(self.robot, BoardIndex.LOGGER))


class Trouble(Protocol):
    """What goes wrong; see `faults.fault.Fault`."""

    @property
    def name(self) -> str:
        """To type."""

    def strike(self, day: Day, moment: Moment) -> None:
        """Goes wrong, if its moment has come."""


def rehearse(
    schedule: Schedule,
    filed: RobotModel,
    truth: Truth,
    *,
    hex_path: Path | None = None,
    faults: Sequence[Trouble] = (),
    progress: Progress = lambda _: None,
) -> Drop:
    """Lives through one day, from power-up to the card on the desk.

    Args:
        schedule: What to fly.
        filed: The robot as its file has it: the calibration is in its terms.
        truth: The robot that flies.
        hex_path: The sequencer's image; None runs its core natively.
        faults: What goes wrong.
        progress: Told what is going on.

    Raises:
        TfsatError: without a fault, whatever a board refuses.
    """
    session = _session_seed(schedule, truth, hex_path, faults)
    with EmulatedRobot(
        truth.model,
        imperfections=truth.imperfections,
        seed=truth.seed,
        session_seed=session,
        hex_path=hex_path,
    ) as robot:
        robot.advance(SETTLE_US)
        day = Day(
            robot,
            schedule,
            SequencerClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER)),
            LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER)),
            careful_certificate(filed, truth.imperfections, truth.seed, CALIBRATED),
        )
        return _lived(day, truth, faults, progress)


def _lived(day: Day, truth: Truth, faults: Sequence[Trouble], progress: Progress) -> Drop:
    def at(moment: Moment) -> None:
        for fault in faults:
            fault.strike(day, moment)

    upload, refused = None, None
    try:
        upload = _made_ready(day, at, progress)
    except TfsatError as error:
        if not faults:
            raise
        refused = error
    if refused is None:
        _fallen(day, truth, at, progress)
    progress("cables plugged; the recording is closed")
    return _collected(day, upload, refused, fell=refused is None)


def _made_ready(day: Day, at: Callable[[Moment], None], progress: Progress) -> UploadResult | None:
    """Until it is armed. Raises what a board refuses."""
    robot = day.robot
    at(Moment.POWERED)
    progress("uploading, reading back")
    upload = None if "upload" in day.skipped else day.sequencer.upload(day.schedule)
    at(Moment.UPLOADED)
    progress("recording in the releaser")
    robot.record_truth(TRUTH_PERIOD_US)
    if "record" not in day.skipped:
        day.logger.start_recording(unix_us=round(DROPPED.timestamp() * US_PER_S))
        day.logger.wait_for_card()
    at(Moment.RECORDING)
    robot.advance(HANG_US)
    if "arm" not in day.skipped:
        day.sequencer.arm()
    at(Moment.ARMED)
    return upload


def _fallen(day: Day, truth: Truth, at: Callable[[Moment], None], progress: Progress) -> None:
    robot = day.robot
    progress("armed; cables pulled; the crane lifts, one switch is knocked")
    for board in BoardIndex:
        robot.set_cable(board, False)
    robot.knock(1, KNOCK_US)
    robot.advance(WAIT_US // 2)
    at(Moment.LIFTED)
    robot.advance(WAIT_US - WAIT_US // 2)
    at(Moment.RELEASE)
    progress("release, fall, landing")
    robot.drop(truth.rate_rad_s.tolist())
    fall_us = round(FALL_S * US_PER_S)
    robot.advance(fall_us // 2)
    at(Moment.FALLING)
    robot.advance(fall_us - fall_us // 2 - GUARD_US)
    at(Moment.BEFORE_LANDING)
    while robot.falling:
        robot.advance(TRUTH_PERIOD_US)
    day.landed_us = robot.now_us
    robot.advance(GUARD_US)
    at(Moment.LANDED)
    robot.advance(AFTER_LANDING_US)


def _collected(day: Day, upload: UploadResult | None, refused: TfsatError | None, *, fell: bool) -> Drop:
    """Cables plugged, power on, the recording closed, the card taken out."""
    robot = day.robot
    for board in BoardIndex:
        robot.set_power(board, True)
        robot.set_cable(board, True)
    robot.advance(SETTLE_US)
    recording, status = None, None
    try:
        day.reconnect()
        status = day.sequencer.status()
        recording = day.logger.stop_recording()
    except TfsatError as error:
        # A board that lost its power has no recording to close: its card tells what there is.
        day.setbacks.append(f"{error.what} {error.meaning}")
    return Drop(
        card=robot.card(),
        upload=upload,
        sequencer=status,
        recording=recording,
        calibration=day.calibration,
        truth=robot.truth(),
        released_s=robot.released_us / US_PER_S if fell else None,
        landed_s=day.landed_us / US_PER_S if fell else None,
        refused=refused,
        setbacks=tuple(day.setbacks),
    )


def _session_seed(schedule: Schedule, truth: Truth, hex_path: Path | None, faults: Sequence[Trouble]) -> int:
    """Another one for everything that makes another drop, the same for the same drop."""
    image = b"" if hex_path is None else hex_path.read_bytes()
    names = tuple(fault.name for fault in faults)
    drop = repr(
        (truth.seed, schedule.strokes, schedule.speed_cdeg_s, tuple(map(float, truth.rate_rad_s)), names)
    )
    return int.from_bytes(hashlib.sha256(drop.encode() + b"\0" + image).digest()[:8], "little")
