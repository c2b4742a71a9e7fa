"""`tfsat-host status`: state of both boards, and what blocks a drop."""

from __future__ import annotations

import argparse
from contextlib import ExitStack, closing

from tfsat_host.cli.boards import PLACE, Place, absent, interruptible, most_telling, places
from tfsat_host.cli.usage import add_options
from tfsat_host.devices.client import Client
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.devices.serial_ports import BoardName
from tfsat_host.errors import Interrupted, TfsatError
from tfsat_host.present.boards_status import BOARDS, BoardsStatus
from tfsat_host.present.logger_state import LoggerReport, attention
from tfsat_host.present.output import Output
from tfsat_host.present.sequencer_state import SequencerReport
from tfsat_host.protocol.enums import Board
from tfsat_host.quantity import record

_USAGE = f"""
--full  for people: also ports, servo settings, strokes of the last run, and counters
{PLACE}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options that select the boards: those found, one port, or the emulated ones."""
    add_options(parser, _USAGE)


def run(args: argparse.Namespace, out: Output) -> int:
    """Ask every board that can be reached; one that is missing is a note, not a failure, if another answers."""
    sequencer: SequencerReport | None = None
    logger: LoggerReport | None = None
    errors: list[tuple[BoardName | None, TfsatError]] = []
    with ExitStack() as stack:
        for place in places(args, out, stack):
            try:
                report = _ask(place)
            except Interrupted:
                raise
            except TfsatError as error:
                errors.append((place.expected, error))
                continue
            board: BoardName = "sequencer" if isinstance(report, SequencerReport) else "logger"
            if place.expected not in (None, board):
                out.warn(f"{place.said_by} is the {board}'s port, not the {place.expected}'s: correct it.")
            # A board at another's port is taken only where its own port gave none.
            if isinstance(report, SequencerReport):
                sequencer = report if place.expected in (None, board) else sequencer or report
            else:
                logger = report if place.expected in (None, board) else logger or report
    if sequencer is None and logger is None:
        raise most_telling([error for _, error in errors])
    for _, reason in errors:
        out.note(reason.what)
    unreached = {missed: reason for missed, reason in errors if missed is not None and not absent(reason)}
    status = BoardsStatus(sequencer, logger, unreached)
    out.result(record(BOARDS, status), lambda: status.show(out, full=args.full))
    # For people the screen begins with them.
    if out.json_mode and logger is not None:
        _warn(logger, out)
    return 0


def _warn(logger: LoggerReport, out: Output) -> None:
    from tfsat_host.run.logger_recordings import RAM_WARNING

    out.warn_each(attention(logger.status))
    if logger.status.ram_holds_drop:
        out.warn(RAM_WARNING)


def _ask(place: Place) -> SequencerReport | LoggerReport:
    """Ask the board at the other end for its report."""
    with closing(place.connect()) as transport, interruptible(transport.name):
        client = Client(transport)
        identity = client.hello()
        if identity.board == Board.SEQUENCER:
            return SequencerReport.ask(SequencerClient(client, identity))
        return LoggerReport.ask(LoggerClient(client, identity))
