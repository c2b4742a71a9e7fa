"""Both boards of a preflight: asked, and left as they were; one that is missing is evidence, no error."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TypeVar

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.devices.board_errors import VerifyError
from tfsat_host.devices.board_identity import BoardIdentity
from tfsat_host.devices.client import BoardClient
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.sequencer import SequencerClient, StoredManeuver
from tfsat_host.devices.serial_ports import BoardName
from tfsat_host.devices.transport import Transport
from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.preflight.logger_queries import Advance, Trace, ask_logger
from tfsat_host.preflight.preflight_evidence import (
    Clock,
    Evidence,
    Missing,
    Moment,
    Reference,
    SequencerAnswers,
    origin_of_logger,
)
from tfsat_host.protocol.enums import SequencerState

Board = TypeVar("Board", bound=BoardClient)
BoardAnswers = TypeVar("BoardAnswers")
_MOVING = {
    SequencerState.ARMED: "armed",
    SequencerState.RUNNING: "flying its maneuver",
    SequencerState.JOGGING: "moving a joint",
}


class NotNow(RefusedError):
    """The sequencer is armed or moves a joint: nothing is asked of either board (exit code 4)."""

    code = "not-safe"


def ask_boards(
    opened: Mapping[BoardName, Transport | TfsatError],
    expected: Evidence,
    certificate: Callable[[bool], tuple[Calibration | Missing, str]],
    trace: Trace,
    unix_s: Clock,
    advance: Advance = lambda _seconds: None,
) -> Evidence:
    """Query both boards and return the evidence completed with their answers.

    Args:
        opened: Both links, or why there is none.
        expected: The evidence so far, with what the answers are checked against.
        certificate: Returns the run's calibration and its name, for a robot that is emulated or not.
        trace: Records what is left on the logger.
        unix_s: The computer's time of day.
        advance: Called with how many seconds of `logger.WATCH_S` went by.

    Raises:
        NotNow: the sequencer is armed or moves.
    """
    # The sequencer first: if it is armed or moves, the logger is not touched.
    at_sequencer = _identify_board(SequencerClient, opened["sequencer"])
    begun = _ask_board("sequencer", at_sequencer, _begin)
    at_logger = _identify_board(LoggerClient, opened["logger"])
    logger_board = replace(expected.logger_board, identity=_identity(at_logger))
    evidence = replace(
        expected,
        sequencer_board=replace(expected.sequencer_board, identity=_identity(at_sequencer)),
        logger_board=logger_board,
    )
    # Real and emulated robots have different certificates, and only HELLO tells which this is.
    calibration, name = certificate(evidence.runs_natively)
    logger = _ask_board(
        "logger", at_logger, lambda board: ask_logger(board, unix_s, calibration, trace, advance)
    )
    # Once more after the logger's seconds, so that both statuses span the whole preflight.
    sequencer = begun
    if not isinstance(begun, Missing):
        # The first status stood in for the last until now.
        sequencer = _ask_board(
            "sequencer", at_sequencer, lambda board: replace(begun, last=Moment.of(board.status, board.now_s))
        )
    origin = None
    if not isinstance(at_logger, Missing):
        logger_board = replace(
            logger_board, image=_logger_image(logger_board.image, at_logger.identity, calibration, name)
        )
        if not isinstance(logger, Missing):
            origin = origin_of_logger(at_logger.identity, logger.later.who_am_i)
    return replace(
        evidence,
        logger_board=logger_board,
        sequencer=sequencer,
        logger=logger,
        origin=origin,
        calibration=calibration,
        calibration_file=name,
    )


def _begin(sequencer: SequencerClient) -> SequencerAnswers:
    """Asks for everything but the end.

    Raises:
        NotNow: it is armed, runs, or moves a joint.
        BoardError, NoAnswer, PortError: of the requests.
    """
    first = Moment.of(sequencer.status, sequencer.now_s)
    if first.status.state in _MOVING:
        raise NotNow(
            what=f"The sequencer is {_MOVING[first.status.state]}.",
            meaning="A preflight comes before the arming. Neither board was asked for anything more.",
            next_step=Advice(NextStep("disarm"), ", then run this preflight again."),
        )
    maneuver: StoredManeuver | Missing
    try:
        maneuver = sequencer.read_back()
    except VerifyError as error:
        # A read-back that contradicts its own CRC is a finding, and does not end the preflight.
        maneuver = Missing(f"{error.what} {error.meaning}", error.next_step)
    # The first status stands in for the last until `ask_boards` puts that in.
    return SequencerAnswers(first, first, maneuver, sequencer.settings())


def _identify_board(kind: type[Board], transport: Transport | TfsatError) -> Board | Missing:
    """Connect to a board and identify it, whatever protocol it speaks."""
    if isinstance(transport, TfsatError):
        return _missing_board(transport)
    try:
        return kind.connect_any_protocol(transport)
    except TfsatError as error:
        return _missing_board(error)


def _identity(board: BoardClient | Missing) -> BoardIdentity | Missing:
    return board if isinstance(board, Missing) else board.identity


def _logger_image(
    named: Reference | Missing, identity: BoardIdentity, calibration: Calibration | Missing, certificate: str
) -> Reference | Missing:
    """Return the image that the logger should run: the named one, else that of its calibration."""
    if not isinstance(named, Missing) or isinstance(calibration, Missing):
        return named
    # The certificate of another logger says nothing of what this one should run.
    if calibration.subject.logger_serial != identity.serial or calibration.logger_image is None:
        return named
    return Reference(calibration.logger_image, certificate, calibrated=True)


def _ask_board(
    name: BoardName, board: Board | Missing, ask: Callable[[Board], BoardAnswers]
) -> BoardAnswers | Missing:
    """Query a board that speaks this protocol, and return its answers.

    Returns Missing if it does not, or cannot be reached. Raises NotNow.
    """
    if isinstance(board, Missing):
        return Missing(f"The {name} was not reached.", "See protocol.")
    if not board.identity.speaks_this_protocol:
        return Missing(
            f"The {name} speaks another protocol: it can be asked for nothing more.", "See protocol."
        )
    try:
        return ask(board)
    except NotNow:
        raise
    except TfsatError as error:
        return _missing_board(error)


def _missing_board(error: TfsatError) -> Missing:
    """Build the Missing of a board that could not be queried, or not to the end."""
    return Missing(error.what, error.next_step)
