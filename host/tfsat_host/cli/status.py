"""`tfsat-host status`: what the boards are doing."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.advice import Interrupted, interruptible
from tfsat_host.cli.board_state import Rows, logger_state, sequencer_state
from tfsat_host.cli.options import add_output_options, port_name
from tfsat_host.cli.output import Output, error_as_dict
from tfsat_host.devices.discovery import BoardName, PortError, PortProblem, find_port, port_variable
from tfsat_host.errors import TfsatError

if TYPE_CHECKING:
    from tfsat_host.devices.transport import Transport

BOARDS: tuple[BoardName, ...] = ("sequencer", "logger")


@dataclass(frozen=True, slots=True)
class Place:
    """Where to ask.

    Attributes:
        expected: The board that should be there; None: whichever it is.
        said_by: Who says so.
        connect: Finds and opens it. Raises PortError.
    """

    expected: BoardName | None
    said_by: str
    connect: Callable[[], Transport]


def configure(parser: argparse.ArgumentParser) -> None:
    """Which boards: those that are found, one port, or the emulated ones."""
    group = parser.add_argument_group("device").add_mutually_exclusive_group()
    group.add_argument(
        "--port", metavar="PORT", type=port_name, help="ask the board at this port only, whichever it is"
    )
    group.add_argument("--emulated", action="store_true", help="ask the emulated robot's boards")
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Asks every board that can be reached; one that is missing is said, not a failure, if another answers."""
    answers: dict[BoardName, tuple[dict[str, Any], Rows]] = {}
    errors: list[tuple[BoardName | None, TfsatError]] = []
    with ExitStack() as stack:
        for place in _places(args, out, stack):
            try:
                board, state, rows = _ask(place)
            except Interrupted:
                raise
            except TfsatError as error:
                errors.append((place.expected, error))
                continue
            if place.expected not in (None, board):
                out.warn(f"{place.said_by} is the {board}'s port, not the {place.expected}'s: correct it.")
                if board in answers:
                    continue
            answers[board] = state, rows
    if not answers:
        raise _most_telling([error for _, error in errors])
    shown: dict[str, Any] = dict.fromkeys(BOARDS)
    for missed, reason in errors:
        out.note(reason.what)
        if missed is not None and not _absent(reason):
            shown[missed] = {"error": error_as_dict(reason)}
    shown |= {board: state for board, (state, _) in answers.items()}
    out.result(shown, lambda: _show([row for _, rows in answers.values() for row in rows], out))
    return 0


def _absent(error: TfsatError) -> bool:
    return isinstance(error, PortError) and error.code == PortProblem.NONE_FOUND


def _most_telling(errors: list[TfsatError]) -> TfsatError:
    """That nothing is plugged in tells least."""
    return min(errors, key=_absent)


def _show(rows: Rows, out: Output) -> None:
    for name, text in rows:
        out.line(f"{name:<14} {text}" if name.startswith(" ") else f"{name:<10} {text}")


def _places(args: argparse.Namespace, out: Output, stack: ExitStack) -> list[Place]:
    """Where to ask; what is emulated lives as long as `stack`. Raises BuildError."""
    from tfsat_host.cli.connection import emulated_robot, open_port
    from tfsat_host.devices.transport import SerialTransport

    if args.emulated:
        from tfsat_host.emulated.robot import BoardIndex
        from tfsat_host.emulated.transport import EmulatedTransport

        robot = stack.enter_context(emulated_robot(out))
        emulated = [EmulatedTransport(robot, board) for board in BoardIndex]
        return [Place(None, "", partial(_same, transport)) for transport in emulated]
    if args.port is not None:
        return [Place(None, "", lambda: open_port("sequencer", args.port, out))]
    named = {board: os.environ.get(port_variable(board), "") for board in BOARDS}
    paths = {os.path.realpath(path) for path in named.values() if path}
    if all(named.values()) and len(paths) == 1:
        out.warn(f"{' and '.join(map(port_variable, BOARDS))} name the same port: one of them is wrong.")
        return [Place(None, "", lambda: SerialTransport(named["sequencer"]))]
    return [
        Place(
            board,
            f"{port_variable(board)}={named[board]}" if named[board] else "The port that was found",
            partial(_find_and_open, board),
        )
        for board in BOARDS
    ]


def _same(transport: Transport) -> Transport:
    return transport


def _find_and_open(board: BoardName) -> Transport:
    from tfsat_host.devices.transport import SerialTransport

    return SerialTransport(find_port(board))


def _ask(place: Place) -> tuple[BoardName, dict[str, Any], Rows]:
    """Name, state and lines of the board at the other end."""
    from tfsat_host.devices.client import Client
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.devices.sequencer import SequencerClient
    from tfsat_host.protocol.enums import Board

    with closing(place.connect()) as transport, interruptible(transport.name):
        client = Client(transport)
        identity = client.hello()
        name: BoardName = "sequencer" if identity.board == Board.SEQUENCER else "logger"
        if identity.board == Board.SEQUENCER:
            state, lines = sequencer_state(SequencerClient(client, identity))
        else:
            state, lines = logger_state(LoggerClient(client, identity))
        device = {"port": transport.name, **identity.as_dict()}
        return name, {"device": device, **state}, [(name, f"{transport.name}, {identity.describe()}"), *lines]
