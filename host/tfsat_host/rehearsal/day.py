"""A rehearsed day until the drop: biases on the bench, the boards' connections, the preflight.

On the bench the gyros' biases are taken as `tfsat-host calibrate bias` takes them: the logger is asked for its samples,
the same solver makes biases of them, and the raw samples are kept. The dies are cold and gravity is in the biases. All
else in the certificate is drawn (`careful_certificate`), and it says so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

from tfsat_host.calibration.certificate.certificate import Calibration, Recording
from tfsat_host.calibration.certificate.simulated_quantities import with_measured
from tfsat_host.calibration.steps.evidence import Evidence as Rest
from tfsat_host.calibration.steps.evidence import LiveSource, file_name, read_step, sha256, to_bytes, until_s
from tfsat_host.calibration.steps.step import DURATION_S, StepKind, rest
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.sequencer import SequencerClient, StoredManeuver, Upload
from tfsat_host.emulated.emulated_certificate import careful_certificate
from tfsat_host.emulated.emulated_operator import EmulatedOperator
from tfsat_host.emulated.emulated_robot import SETTLE_US, US_PER_S, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.errors import RefusedError
from tfsat_host.flashing.image import load_image
from tfsat_host.maneuver import Schedule
from tfsat_host.plan.facility import DropTower
from tfsat_host.plan.reach_envelope import envelope_of
from tfsat_host.plan.tower_checks import Check as FacilityCheck
from tfsat_host.plan.tower_checks import check_maneuver
from tfsat_host.preflight import PreflightCheck, judge, may_drop
from tfsat_host.preflight.board_queries import ask_boards
from tfsat_host.preflight.logger_queries import Trace
from tfsat_host.preflight.preflight_evidence import (
    BoardEvidence,
    Evidence,
    Missing,
    Reference,
    origin_of_logger,
)
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.rehearsal.truth import Truth
from tfsat_host.robot import RobotModel

CALIBRATED = datetime(2026, 1, 5, 8, 0, tzinfo=UTC)
"""When the emulated robot is laid on the bench; it is dropped an hour later."""
DROPPED = CALIBRATED + timedelta(hours=1)
RECORDINGS = 10
"""The card must have room for so many, as for `tfsat-host preflight`."""
_PIECE_US = 50_000
"""Of the rest, at once: the cable holds more than twice as many samples."""


@dataclass(frozen=True, eq=False)
class PreflightOutcome:
    """What a preflight came to.

    Attributes:
        evidence: What the boards and the day's files gave.
        checks: Made of that.
    """

    evidence: Evidence
    checks: tuple[PreflightCheck, ...]

    @property
    def go(self) -> bool:
        """No check blocks a drop."""
        return may_drop(self.checks)

    @property
    def blocking(self) -> tuple[PreflightCheck, ...]:
        """The checks that block a drop."""
        return tuple(check for check in self.checks if check.blocks)


class NoGo(RefusedError):
    """The preflight says NO-GO: no robot is dropped then (exit code 4)."""

    code = "no-go"

    def __init__(self, blocking: Sequence[PreflightCheck]) -> None:
        super().__init__(
            what=f"Preflight says NO-GO: {', '.join(check.name for check in blocking)}. "
            + " ".join(check.sentence for check in blocking),
            meaning="No robot is dropped then.",
            next_step="To see what would have come of it: the same command with --despite-preflight.",
        )


@dataclass(eq=False, kw_only=True)
class DayRecord:
    """What is known of a day while it goes on, and afterwards.

    Attributes:
        calibration: That the drop is evaluated with, measured on the bench of this robot; what was only drawn of it,
            it says.
        recordings: Of the bench, by their files' names; those that the calibration names are its raw data.
        upload: Of the maneuver; None: it did not come through, or has not yet.
        preflight: Its result; None: there was none.
        setbacks: What went wrong on the way and did not end the day; a sentence each.
        injected_s: Virtual time at which each fault was injected, by its name; the day may end before.
    """

    calibration: Calibration
    recordings: Mapping[str, bytes] = field(default_factory=dict)
    upload: Upload[StoredManeuver] | None = None
    preflight: PreflightOutcome | None = None
    setbacks: list[str] = field(default_factory=list)
    injected_s: dict[str, float] = field(default_factory=dict)

    @property
    def blocking(self) -> tuple[PreflightCheck, ...]:
        """The checks of the preflight that block a drop."""
        return () if self.preflight is None else self.preflight.blocking


@dataclass(eq=False)
class Day(DayRecord):
    """While it goes on: the boards, what the team holds, and what faults act on.

    Attributes:
        robot: With its boards.
        schedule: Of the maneuver.
        sequencer: Its connection.
        logger: Its connection.
        arming: The robot will be armed.
        seed: Of the robot, from which faults draw what they leave open.
        landed_us: Virtual time of the landing.
    """

    robot: EmulatedRobot
    schedule: Schedule
    sequencer: SequencerClient = field(init=False)
    logger: LoggerClient = field(init=False)
    arming: bool = True
    seed: int = 0
    landed_us: int = 0

    def __post_init__(self) -> None:
        self.reconnect()

    def reconnect(self) -> None:
        """Reconnect to both boards as a restarted program does."""
        self.sequencer = SequencerClient.connect(EmulatedTransport(self.robot, BoardIndex.SEQUENCER))
        self.logger = LoggerClient.connect(EmulatedTransport(self.robot, BoardIndex.LOGGER))

    def unix_s(self) -> float:
        """Return the time of the team's clock, Unix time in s; compressed minutes do not count."""
        return DROPPED.timestamp() + self.robot.now_us / US_PER_S


def begin_day(
    robot: EmulatedRobot, schedule: Schedule, filed: RobotModel, truth: Truth, *, bench: bool = True
) -> Day:
    """Simulate the day from the logger's power-up on the bench until the robot hangs in the releaser.

    Both boards are started then. `filed` is the robot as its file has it: the calibration is in its terms.
    What cannot be measured in minutes is drawn from `truth`; without `bench` biases, too, which spares half
    of a day's computing time.

    Raises:
        CalibrationError: the robot did not rest.
    """
    # The bench takes only the logger; without power the sequencer gives its servos no pulses.
    robot.set_power(BoardIndex.SEQUENCER, False)
    robot.advance(SETTLE_US)
    # A certificate of the sensors as they were then: a change since the calibration is not in it.
    calibration = careful_certificate(filed, truth.calibrated or truth.imperfections, truth.seed, CALIBRATED)
    recordings: dict[str, bytes] = {}
    if bench:
        rested = _record_rest(robot)
        data, file = to_bytes(rested), file_name(rested)
        recordings[file] = data
        # Measured biases take the place of the drawn ones, with their raw data, and are drawn no longer.
        calibration = replace(
            with_measured(calibration, [rested], filed),
            recordings=(Recording(rested.step.key, rested.recorded_at, file, sha256(data)),),
            written=_clock(robot),
            simulated_quantities=tuple(name for name in calibration.simulated_quantities if name != "bias"),
        )
    # Hang it up before power comes: both switches are closed when the sequencer starts.
    robot.seat()
    robot.set_power(BoardIndex.SEQUENCER, True)
    robot.advance(SETTLE_US)
    return Day(robot, schedule, seed=truth.seed, calibration=calibration, recordings=recordings)


def _record_rest(robot: EmulatedRobot) -> Rest:
    logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
    step = rest()
    EmulatedOperator(robot).begin(step)
    origin = origin_of_logger(logger.identity, logger.status().who_am_i)

    def fresh() -> Sequence[LiveSample]:
        # Time passes only when samples are asked for, in pieces that the cable's buffer can hold.
        robot.advance(_PIECE_US)
        return logger.live_samples()

    with logger.live() as scales:
        live = LiveSource(fresh, scales, origin, lambda: _clock(robot))
        return read_step(step, live, until_s(DURATION_S[StepKind.REST]))


def _clock(robot: EmulatedRobot) -> datetime:
    return CALIBRATED + timedelta(microseconds=robot.now_us)


@dataclass(frozen=True, eq=False)
class Preflight:
    """The checks of `tfsat-host preflight`, made of the emulated boards.

    Attributes:
        schedule: What is to be flown.
        filed: The robot as its file has it.
        facility: What the facility says of that maneuver.
        image: The sequencer's; None: its core runs natively, without one.
        despite: The robot is dropped even if it says NO-GO.
    """

    schedule: Schedule
    filed: RobotModel
    facility: tuple[FacilityCheck, ...]
    image: Path | None = None
    despite: bool = False

    @classmethod
    def of(
        cls, schedule: Schedule, filed: RobotModel, tower: DropTower, image: Path | None, *, despite: bool
    ) -> Preflight:
        """Build the preflight of a maneuver in a drop tower.

        Raises EnvelopeError: its envelope cannot be computed.
        """
        envelope = envelope_of(filed, schedule, until_s=tower.fall_s)
        return cls(schedule, filed, check_maneuver(schedule, filed, tower, envelope), image, despite)

    def run(self, day: Day) -> PreflightOutcome:
        """Asks both boards; the logger records some seconds onto its card, and removes that again.

        Raises:
            TfsatError: the sequencer is armed or moves.
        """
        # The native core has no image whose CRC could be compared.
        none_named = Missing("no image was named.", "Name it with --logger-image.")
        image = none_named if self.image is None else Reference(load_image(self.image).crc, str(self.image))
        expected = Evidence(
            robot=self.filed,
            schedule=self.schedule,
            facility=self.facility,
            sequencer_board=BoardEvidence("sequencer", image),
            logger_board=BoardEvidence("logger", none_named),
            recordings=RECORDINGS,
            now=datetime.fromtimestamp(day.unix_s(), UTC),
            newest_file=None,
        )
        evidence = ask_boards(
            {
                "sequencer": EmulatedTransport(day.robot, BoardIndex.SEQUENCER),
                "logger": EmulatedTransport(day.robot, BoardIndex.LOGGER),
            },
            expected,
            lambda _: (day.calibration, "the rehearsal's calibration"),
            Trace(),
            day.unix_s,
        )
        return PreflightOutcome(evidence, judge(evidence))
