"""What a preflight knows: answers of both boards, a short recording, the run's files and the computer's clock."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from typing import Generic, Literal, TypeVar

from tfsat_host.arrays import IntArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.evidence import Origin
from tfsat_host.devices.board_identity import BoardIdentity
from tfsat_host.devices.sequencer import StoredManeuver, StoredSettings
from tfsat_host.maneuver import Schedule
from tfsat_host.plan.tower_checks import Check as FacilityCheck
from tfsat_host.protocol.limits import RING_BLOCKS
from tfsat_host.protocol.messages import LoggerSettings, LoggerStatusReply, SequencerStatusReply
from tfsat_host.robot import RobotModel

Known = TypeVar("Known")
Status = TypeVar("Status", SequencerStatusReply, LoggerStatusReply)
Clock = Callable[[], float]
_TICK_S = 1e-3
"""Uptimes are whole milliseconds."""


@dataclass(frozen=True, slots=True)
class Missing:
    """Something that could not be had.

    Attributes:
        reason: Why, a sentence.
        next_step: What to do about it.
    """

    reason: str
    next_step: str


@dataclass(frozen=True, slots=True)
class Failed(Missing):
    """Something that was tried and went wrong: a finding, not a want of evidence."""


class Unreached(Exception):
    """A check cannot be made for want of evidence."""

    def __init__(self, missing: Missing) -> None:
        super().__init__(missing.reason)
        self.missing = missing


def require(evidence: Known | Missing) -> Known:
    """Return the evidence that a check needs. Raises Unreached: it is missing."""
    if isinstance(evidence, Missing):
        raise Unreached(evidence)
    return evidence


@dataclass(frozen=True, slots=True)
class Pace:
    """A board's clock against the computer's over the preflight.

    Attributes:
        board_s: Time that passed on the board.
        computer_s: Time that passed on the computer.
        doubt_s: By how much their difference is unsure: how long the answers took, and the board's milliseconds.
    """

    board_s: float
    computer_s: float
    doubt_s: float


@dataclass(frozen=True, slots=True)
class Moment(Generic[Status]):
    """A status, and when it was asked for and had, on the transport's clock."""

    status: Status
    asked_s: float
    had_s: float

    @classmethod
    def of(cls, ask: Callable[[], Status], now_s: Clock) -> Moment[Status]:
        """Asks for a status. Raises what `ask` raises."""
        asked_s = now_s()
        status = ask()
        return cls(status, asked_s, now_s())


@dataclass(frozen=True, eq=False)
class Answers(Generic[Status]):
    """What a board answered, from the beginning of the preflight to its end.

    Attributes:
        first: Before any recording of the preflight's own.
        last: At the end.
    """

    first: Moment[Status]
    last: Moment[Status]

    @property
    def status(self) -> Status:
        """At the beginning."""
        return self.first.status

    @property
    def later(self) -> Status:
        """At the end."""
        return self.last.status

    @property
    def pace(self) -> Pace | None:
        """How fast the board's clock ran; None: it restarted meanwhile."""
        first, last = self.first, self.last
        board_s = (last.status.uptime_ms - first.status.uptime_ms) / 1000
        # Uptime went backwards: the board restarted in between.
        if board_s < 0.0:
            return None
        # Between the midpoints of the two exchanges; half of each round trip and one tick remain as doubt.
        middle = (last.asked_s + last.had_s - first.asked_s - first.had_s) / 2
        doubt_s = (last.had_s - last.asked_s + first.had_s - first.asked_s) / 2 + _TICK_S
        return Pace(board_s, middle, doubt_s)


@dataclass(frozen=True, eq=False)
class SequencerAnswers(Answers[SequencerStatusReply]):
    """What the sequencer answered.

    Attributes:
        maneuver: As read back; Missing: what was read does not fit its own CRC.
        settings: Of the servos.
    """

    maneuver: StoredManeuver | Missing
    settings: StoredSettings


@dataclass(frozen=True, slots=True)
class Trial:
    """A short recording as it was read back from the card.

    Attributes:
        verdict: Of the decoder.
        samples, samples_dropped: By its footer.
        samples_lost, blocks_lost: By the decoder, on the card too.
        duration_s: From the first sample to the last.
        stall_max_ms: Longest time that the card took nothing.
        ring_peak_blocks, ring_blocks: Most blocks that ever waited, and how many the ring holds.
    """

    verdict: str
    samples: int
    samples_dropped: int
    samples_lost: int
    blocks_lost: int
    duration_s: float = 0.0
    stall_max_ms: int = 0
    ring_peak_blocks: int = 0
    ring_blocks: int = RING_BLOCKS


@dataclass(frozen=True, slots=True)
class RunningRecording:
    """A recording that was begun before, watched.

    Attributes:
        session: Its id.
        watched_s: For how long.
        blocks: That the card took meanwhile.
        samples_dropped: Since its beginning.
        ring_peak_blocks, ring_blocks: Most blocks that ever waited, and how many the ring holds.
        block_s: Time that a block stands for.
    """

    session: int
    watched_s: float
    blocks: int
    samples_dropped: int
    ring_peak_blocks: int
    ring_blocks: int
    block_s: float


@dataclass(frozen=True, eq=False)
class LiveSamples:
    """Live samples of some seconds.

    Attributes:
        counts: Raw.
        index: (n,) number of each sample since the logger started.
    """

    counts: Counts
    index: IntArray


@dataclass(frozen=True, eq=False)
class LoggerAnswers(Answers[LoggerStatusReply]):
    """What the logger answered.

    Attributes:
        computer_unix_s: The computer's time of day when `status` came.
        settings: In force.
        live: None came: Missing.
        card: What the card did with a short recording, or with one that runs already; Failed: it did not take one.
        recording_since: When the last recording began; None: the logger's clock was not set.
        left: What the preflight could not put back as it was; empty: nothing.
    """

    computer_unix_s: float
    settings: LoggerSettings
    live: LiveSamples | Missing
    card: Trial | RunningRecording | Missing
    recording_since: datetime | None
    left: str


@dataclass(frozen=True, slots=True)
class Reference:
    """The image that a board should run.

    Attributes:
        crc: CRC-32/ISO-HDLC, 8 hexadecimal digits.
        source: Where it is from, such as a file.
        calibrated: It is what the board ran when its sensors were calibrated, which need not be the right one.
    """

    crc: str
    source: str
    calibrated: bool = False


@dataclass(frozen=True, slots=True)
class AcceptedRobot:
    """What a record of an acceptance says.

    Attributes:
        file: Of the record.
        at: When its last step was done.
        sequencer_serial, logger_serial: Of the boards that were accepted.
        parts_sha256: `hash_wired_parts` of the robot that it was held against.
        remaining: Steps that were not passed.
    """

    file: str
    at: datetime
    sequencer_serial: str
    logger_serial: str
    parts_sha256: str
    remaining: tuple[str, ...]


NOT_ASKED = Missing("It was not asked.", "See protocol.")


@dataclass(frozen=True, slots=True)
class BoardEvidence:
    """One board.

    Attributes:
        name: For people and in names of checks.
        image: What it should run.
        identity: By HELLO; Missing: it did not answer.
    """

    name: Literal["sequencer", "logger"]
    image: Reference | Missing
    identity: BoardIdentity | Missing = NOT_ASKED


@dataclass(frozen=True, eq=False)
class Evidence:
    """Everything: what the boards are checked against, and, once they were asked, what they answered.

    Attributes:
        robot: By design.
        schedule: What the run is to fly.
        facility: Its checks; Missing: there is no schedule.
        sequencer_board, logger_board: Who they are, and what they should run.
        recordings: For how many the card must have room.
        now: By the computer's clock.
        newest_file: The youngest of the run's files, and its name: the clock must not be behind it.
        sequencer, logger: What they answered; Missing: not reached, or of another protocol.
        origin: Whose sensors hang on the logger; None: not reached.
        calibration: The run's certificate.
        calibration_file: Its name, for people and commands.
        acceptance: Of the robot on the bench; Missing: there is none, or it cannot be read.
        servos_too: Whether the servos' calibration counts.
    """

    robot: RobotModel
    schedule: Schedule | Missing
    facility: tuple[FacilityCheck, ...] | Missing
    sequencer_board: BoardEvidence
    logger_board: BoardEvidence
    recordings: int
    now: datetime
    newest_file: tuple[datetime, str] | None
    sequencer: SequencerAnswers | Missing = NOT_ASKED
    logger: LoggerAnswers | Missing = NOT_ASKED
    origin: Origin | None = None
    calibration: Calibration | Missing = NOT_ASKED
    calibration_file: str = ""
    acceptance: AcceptedRobot | Missing = NOT_ASKED
    servos_too: bool = True

    @property
    def runs_natively(self) -> bool:
        """Whether some board is no board: the robot is an emulated one."""
        identities = (self.sequencer_board.identity, self.logger_board.identity)
        return any(not isinstance(board, Missing) and board.runs_natively for board in identities)


def origin_of_logger(identity: BoardIdentity, who_am_i: bytes) -> Origin:
    """Whose sensors hang on a connected logger, by its HELLO and the IMUs' `who_am_i` in its status."""
    return Origin(
        identity.serial, who_am_i.hex(), identity.runs_natively, identity.firmware, identity.image_crc
    )
