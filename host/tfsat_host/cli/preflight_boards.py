"""Both boards of a preflight: found, asked, and left as they were; one that is missing is evidence, no error."""

from __future__ import annotations

import argparse
import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, TypeVar

from tfsat_host.cli.output import Output
from tfsat_host.devices.discovery import BoardName, port_variable
from tfsat_host.errors import TfsatError

if TYPE_CHECKING:
    from types import FrameType

    from tfsat_host.calibration.certificate.certificate import Calibration
    from tfsat_host.cli.preflight_files import RunFiles
    from tfsat_host.devices.client import Client
    from tfsat_host.devices.identity import BoardIdentity
    from tfsat_host.devices.sequencer import SequencerClient
    from tfsat_host.devices.transport import Transport
    from tfsat_host.preflight.evidence import Evidence, LoggerAnswers, Missing, SequencerAnswers
    from tfsat_host.preflight.trial import Trace

_SIGNALS = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]


@contextmanager
def interruptible_by_signals() -> Iterator[None]:
    """A closed terminal or a `kill` is a Ctrl-C: a recording that was begun is ended and removed."""

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = {number: signal.signal(number, interrupt) for number in _SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def transports(
    args: argparse.Namespace, files: RunFiles, stack: ExitStack, out: Output
) -> dict[BoardName, Transport | TfsatError]:
    """Both boards' links, closed with `stack`; why not, for one that is not to be had. Raises BuildError."""
    from tfsat_host.cli.connection import emulated_robot, open_port

    if args.emulated:
        from tfsat_host.devices.logger import LoggerClient
        from tfsat_host.emulated.robot import BoardIndex
        from tfsat_host.emulated.transport import EmulatedTransport

        robot = stack.enter_context(emulated_robot(out, model=files.robot, as_built=True))
        logger = EmulatedTransport(robot, BoardIndex.LOGGER)
        # It came to power with this command: nobody could have told it the time.
        LoggerClient.connect(logger).set_clock(time.time_ns() // 1000)
        return {"sequencer": EmulatedTransport(robot, BoardIndex.SEQUENCER), "logger": logger}
    found: dict[BoardName, Transport | TfsatError] = {}
    named: dict[BoardName, str | None] = {"sequencer": args.port, "logger": args.logger_port}
    for board, port in named.items():
        try:
            if board == "logger" and port is None and args.port is not None:
                _require_named_logger()
            found[board] = stack.enter_context(closing(open_port(board, port, out)))
        except TfsatError as error:
            found[board] = error
    return found


def _require_named_logger() -> None:
    """An explicit `--port` scans no others. Raises PortError unless the environment names the logger."""
    from tfsat_host.devices.port_errors import PortError, PortProblem

    variable = port_variable("logger")
    if not os.environ.get(variable):
        raise PortError(
            PortProblem.NONE_FOUND,
            what="The logger was not asked: --port names the sequencer only.",
            next_step=f"Name the logger's port too: --logger-port PORT (or {variable}=PORT).",
        )


@dataclass(frozen=True, slots=True)
class _Link:
    """A board that said who it is, whatever protocol it speaks."""

    client: Client
    identity: BoardIdentity

    @property
    def now_s(self) -> Callable[[], float]:
        """The transport's clock."""
        return self.client.transport.now_s


def _link(board: BoardName, transport: Transport | TfsatError) -> _Link | Missing:
    from tfsat_host.devices.client import Client
    from tfsat_host.preflight.asking import unanswered
    from tfsat_host.protocol.enums import Board

    if isinstance(transport, TfsatError):
        return unanswered(transport)
    client = Client(transport)
    try:
        return _Link(client, client.identify(Board[board.upper()]))
    except TfsatError as error:
        return unanswered(error)


Answers = TypeVar("Answers")


def _asked(link: _Link | Missing, ask: Callable[[_Link], Answers]) -> Answers | Missing:
    """What it answers, if it speaks this protocol; Missing else. Raises NotNow."""
    from tfsat_host.preflight.asking import NotNow, unanswered
    from tfsat_host.preflight.evidence import Missing

    if isinstance(link, Missing):
        return link
    if not link.identity.speaks_this_protocol:
        name = link.identity.board.name.lower()
        return Missing(
            f"The {name} speaks another protocol: it can be asked for nothing more.", "See protocol."
        )
    try:
        return ask(link)
    except NotNow:
        raise
    except TfsatError as error:
        return unanswered(error)


def ask_boards(
    args: argparse.Namespace, files: RunFiles, trace: Trace, stack: ExitStack, out: Output, now: datetime
) -> Evidence:
    """All that both boards and the files say.

    Args:
        args: The command's.
        files: Of the run.
        trace: Told what is left on the logger.
        stack: Closes the ports.
        out: For progress.
        now: The computer's time of day.

    Raises:
        NotNow: the sequencer is armed or moves.
        KeyboardInterrupt: `trace` says what is left.
    """
    from tfsat_host.cli.calibration_notice import origin_of_logger
    from tfsat_host.preflight.asking import begin_sequencer, end_sequencer
    from tfsat_host.preflight.evidence import BoardEvidence, Evidence, Missing

    opened = transports(args, files, stack, out)
    at_sequencer = _link("sequencer", opened["sequencer"])
    begun = _asked(at_sequencer, lambda link: begin_sequencer(_sequencer(link), link.now_s))
    at_logger = _link("logger", opened["logger"])
    emulated = any(
        isinstance(link, _Link) and link.identity.runs_natively for link in (at_logger, at_sequencer)
    )
    calibration, name = files.calibration(emulated=emulated)
    logger = _asked(at_logger, lambda link: _ask_logger(link, calibration, trace, out))
    sequencer: SequencerAnswers | Missing
    if isinstance(begun, Missing):
        sequencer = begun
    else:
        first = begun
        sequencer = _asked(at_sequencer, lambda link: end_sequencer(first, _sequencer(link), link.now_s))
    origin = None
    if not isinstance(at_logger, Missing) and not isinstance(logger, Missing):
        origin = origin_of_logger(at_logger.identity, logger.later.who_am_i)
    images = files.images()
    return Evidence(
        sequencer_board=BoardEvidence("sequencer", _identity(at_sequencer), images[0]),
        logger_board=BoardEvidence("logger", _identity(at_logger), images[1]),
        sequencer=sequencer,
        logger=logger,
        origin=origin,
        robot=files.robot,
        schedule=files.schedule,
        facility=files.facility(),
        calibration=calibration,
        calibration_file=name,
        recordings=args.drops,
        now=now,
        newest_file=files.newest(),
    )


def _identity(link: _Link | Missing) -> BoardIdentity | Missing:
    return link.identity if isinstance(link, _Link) else link


def _sequencer(link: _Link) -> SequencerClient:
    from tfsat_host.devices.sequencer import SequencerClient

    return SequencerClient(link.client, link.identity)


def _ask_logger(link: _Link, calibration: Calibration | Missing, trace: Trace, out: Output) -> LoggerAnswers:
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.preflight.asking import WATCH_S, ask_logger

    with out.progress("reading the sensors, recording onto the card", total=WATCH_S) as advance:
        return ask_logger(
            LoggerClient(link.client, link.identity), link.now_s, time.time, calibration, trace, advance
        )
