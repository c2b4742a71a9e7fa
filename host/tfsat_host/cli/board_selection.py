"""Which boards to ask, for a command that takes whichever there are: `status` and `monitor`."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from tfsat_host.cli.options import add_output_options, port_name
from tfsat_host.devices.ports import BOARDS, BoardName, PortError, PortProblem, find_port, port_variable
from tfsat_host.errors import TfsatError
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.devices.transport import Transport


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


def add_place_options(parser: argparse.ArgumentParser) -> None:
    """One port, or the emulated boards, and the output options."""
    group = parser.add_argument_group("device").add_mutually_exclusive_group()
    group.add_argument(
        "--port", metavar="PORT", type=port_name, help="ask the board at this port only, whichever it is"
    )
    group.add_argument("--emulated", action="store_true", help="ask the emulated robot's boards")
    add_output_options(parser)


def absent(error: TfsatError) -> bool:
    """Nothing is plugged in."""
    return isinstance(error, PortError) and error.code == PortProblem.NONE_FOUND


def most_telling(errors: list[TfsatError]) -> TfsatError:
    """That nothing is plugged in tells least. At least one is given."""
    return min(errors, key=absent)


def places(args: argparse.Namespace, out: Output, stack: ExitStack) -> list[Place]:
    """Where to ask; what is emulated lives as long as `stack`. Raises BuildError."""
    from tfsat_host.cli.connection import emulated_transports, open_port
    from tfsat_host.devices.transport import SerialTransport

    if args.emulated:
        links = emulated_transports(out, stack).values()
        return [Place(None, "", partial(_same, link)) for link in links]
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
