"""Both boards of a preflight: asked, and left as they were; one that is missing is evidence, no error."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import TypeVar

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.devices.client import BoardIdentity, Client, VerifyError
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.ports import BoardName
from tfsat_host.devices.sequencer import SequencerClient, StoredManeuver, StoredSettings
from tfsat_host.devices.transport import Transport
from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.maneuver import Schedule
from tfsat_host.plan.tower_checks import Check as FacilityCheck
from tfsat_host.preflight.evidence import (
    BoardEvidence,
    Clock,
    Evidence,
    Missing,
    Moment,
    Reference,
    SequencerAnswers,
    origin_of_logger,
    pace_between,
    status_at,
)
from tfsat_host.preflight.logger import Advance, ask_logger
from tfsat_host.preflight.trial import Trace
from tfsat_host.protocol.enums import Board, SequencerState
from tfsat_host.protocol.messages import SequencerStatusReply
from tfsat_host.robot import RobotModel

_MOVING = {
    SequencerState.ARMED: "armed",
    SequencerState.RUNNING: "flying its maneuver",
    SequencerState.JOGGING: "moving a joint",
}


class NotNow(RefusedError):
    """The sequencer is armed or moves a joint: nothing is asked of either board (exit code 4)."""

    code = "not-safe"


@dataclass(frozen=True, eq=False)
class Expected:
    """What the boards are checked against.

    Attributes:
        robot: By design.
        schedule: What is to be flown.
        facility: The facility's checks of it.
        sequencer_image, logger_image: What they should run.
        certificate: The run's and its name, for a robot that is emulated or not.
        recordings: For how many the card must have room.
        newest_file: See `Evidence`.
        now: By the computer's clock.
    """

    robot: RobotModel
    schedule: Schedule | Missing
    facility: tuple[FacilityCheck, ...] | Missing
    sequencer_image: Reference | Missing
    logger_image: Reference | Missing
    certificate: Callable[[bool], tuple[Calibration | Missing, str]]
    recordings: int
    newest_file: tuple[datetime, str] | None
    now: datetime


@dataclass(frozen=True, slots=True)
class _Link:
    """A board that identified itself, whatever protocol it speaks."""

    client: Client
    identity: BoardIdentity

    @property
    def now_s(self) -> Clock:
        """The transport's clock."""
        return self.client.transport.now_s


@dataclass(frozen=True, slots=True)
class _Begun:
    """The sequencer's first answers."""

    client: SequencerClient
    moment: Moment[SequencerStatusReply]
    maneuver: StoredManeuver | Missing
    settings: StoredSettings

    def ended(self, now_s: Clock) -> SequencerAnswers:
        """All of them, with the status of now. Raises what its requests raise."""
        last = status_at(self.client.status, now_s)
        pace = pace_between(self.moment, last)
        return SequencerAnswers(self.moment.status, last.status, self.maneuver, self.settings, pace)


def _begin(sequencer: SequencerClient, now_s: Clock) -> _Begun:
    """Asks for everything but the end.

    Raises:
        NotNow: it is armed, runs, or moves a joint.
        BoardError, NoAnswer, PortError: of the requests.
    """
    moment = status_at(sequencer.status, now_s)
    state = moment.status.state
    if state in _MOVING:
        raise NotNow(
            what=f"The sequencer is {_MOVING[state]}.",
            meaning="A preflight comes before the arming. Neither board was asked for anything more.",
            next_step="tfsat-host disarm, then run this preflight again.",
        )
    maneuver: StoredManeuver | Missing
    try:
        maneuver = sequencer.read_back()
    except VerifyError as error:
        maneuver = Missing(f"{error.what} {error.meaning}", error.next_step)
    return _Begun(sequencer, moment, maneuver, sequencer.settings())


def ask_boards(
    opened: Mapping[BoardName, Transport | TfsatError],
    expected: Expected,
    trace: Trace,
    unix_s: Clock,
    advance: Advance = lambda _seconds: None,
) -> Evidence:
    """All that both boards answer.

    Args:
        opened: Both links, or why there is none.
        expected: What they are checked against.
        trace: Gets what is left on the logger.
        unix_s: The computer's time of day.
        advance: Called with how many seconds of `logger.WATCH_S` went by.

    Raises:
        NotNow: the sequencer is armed or moves.
    """
    at_sequencer = _link("sequencer", opened["sequencer"])
    begun = _asked(
        "sequencer",
        at_sequencer,
        lambda link: _begin(SequencerClient(link.client, link.identity), link.now_s),
    )
    at_logger = _link("logger", opened["logger"])
    emulated = any(
        isinstance(link, _Link) and link.identity.runs_natively for link in (at_logger, at_sequencer)
    )
    calibration, name = expected.certificate(emulated)
    logger = _asked(
        "logger",
        at_logger,
        lambda link: ask_logger(
            LoggerClient(link.client, link.identity), link.now_s, unix_s, calibration, trace, advance
        ),
    )
    sequencer = (
        begun
        if isinstance(begun, Missing)
        else _asked("sequencer", at_sequencer, lambda link: begun.ended(link.now_s))
    )
    origin, logger_image = None, expected.logger_image
    if not isinstance(at_logger, Missing):
        logger_image = _logger_image(expected.logger_image, at_logger.identity, calibration, name)
    if not isinstance(at_logger, Missing) and not isinstance(logger, Missing):
        origin = origin_of_logger(at_logger.identity, logger.later.who_am_i)
    return Evidence(
        sequencer_board=BoardEvidence("sequencer", _identity(at_sequencer), expected.sequencer_image),
        logger_board=BoardEvidence("logger", _identity(at_logger), logger_image),
        sequencer=sequencer,
        logger=logger,
        origin=origin,
        robot=expected.robot,
        schedule=expected.schedule,
        facility=expected.facility,
        calibration=calibration,
        calibration_file=name,
        recordings=expected.recordings,
        now=expected.now,
        newest_file=expected.newest_file,
    )


def _link(board: BoardName, transport: Transport | TfsatError) -> _Link | Missing:
    if isinstance(transport, TfsatError):
        return _unanswered(transport)
    client = Client(transport)
    try:
        return _Link(client, client.identify(Board[board.upper()]))
    except TfsatError as error:
        return _unanswered(error)


def _logger_image(
    named: Reference | Missing, identity: BoardIdentity, calibration: Calibration | Missing, certificate: str
) -> Reference | Missing:
    """What the logger should run: the image that was named, else that of its calibration."""
    if not isinstance(named, Missing) or isinstance(calibration, Missing):
        return named
    if calibration.subject.logger_serial != identity.serial or calibration.logger_image is None:
        return named
    return Reference(calibration.logger_image, certificate, calibrated=True)


def _identity(link: _Link | Missing) -> BoardIdentity | Missing:
    return link.identity if isinstance(link, _Link) else link


Answers = TypeVar("Answers")


def _asked(board: BoardName, link: _Link | Missing, ask: Callable[[_Link], Answers]) -> Answers | Missing:
    """What it answers, if it speaks this protocol; Missing else. Raises NotNow."""
    if isinstance(link, Missing):
        return Missing(f"The {board} was not reached.", "See protocol.")
    if not link.identity.speaks_this_protocol:
        return Missing(
            f"The {board} speaks another protocol: it can be asked for nothing more.", "See protocol."
        )
    try:
        return ask(link)
    except NotNow:
        raise
    except TfsatError as error:
        return _unanswered(error)


def _unanswered(error: TfsatError) -> Missing:
    """A board that could not be asked, or not to the end."""
    return Missing(error.what, error.next_step)
