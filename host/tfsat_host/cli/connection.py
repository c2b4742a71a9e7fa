"""From `--port` or `--emulated` to a board that has identified itself."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from tfsat_host.cli.advice import explained, interruptible
from tfsat_host.devices.ports import BOARDS, BoardName, PortError, PortProblem, find_port

if TYPE_CHECKING:
    from tfsat_host.devices.jogging import JogClient
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.devices.sequencer import SequencerClient
    from tfsat_host.devices.transport import SerialTransport, Transport
    from tfsat_host.present.output import Output
    from tfsat_host.robot import RobotModel

AnyBoard = TypeVar("AnyBoard", bound="SequencerClient | LoggerClient")

APPEARANCE_S = 4.0
"""A board re-enumerates within two seconds of a reset."""


def open_sequencer(args: argparse.Namespace, out: Output) -> AbstractContextManager[SequencerClient]:
    """The sequencer that the options name. Raises PortError, NoAnswer, WrongBoard, BuildError."""
    from tfsat_host.devices.sequencer import SequencerClient

    return _board("sequencer", args, out, SequencerClient.connect)


def open_any_sequencer(args: argparse.Namespace, out: Output) -> AbstractContextManager[SequencerClient]:
    """Likewise, of whatever protocol: for DISARM, which is the same in all. Raises the same."""
    from tfsat_host.devices.sequencer import SequencerClient

    return _board("sequencer", args, out, SequencerClient.connect_any_protocol)


def open_jog_client(args: argparse.Namespace, out: Output) -> AbstractContextManager[JogClient]:
    """Likewise, of this program's protocol, to move a joint. Raises the same."""
    from tfsat_host.devices.jogging import JogClient

    return _board("sequencer", args, out, JogClient.connect)


def open_logger(args: argparse.Namespace, out: Output) -> AbstractContextManager[LoggerClient]:
    """The logger that the options name. Raises PortError, NoAnswer, WrongBoard, BuildError."""
    from tfsat_host.devices.logger import LoggerClient

    note = "the logger has just met its card and counts its free room …"
    return _board("logger", args, out, partial(LoggerClient.connect, on_busy=lambda: out.note(note)))


@contextmanager
def _board(
    name: BoardName, args: argparse.Namespace, out: Output, connect: Callable[[Transport], AnyBoard]
) -> Iterator[AnyBoard]:
    with ExitStack() as stack:
        transport: Transport
        if args.emulated:
            transport = emulated_transports(out, stack)[name]
        else:
            transport = stack.enter_context(closing(open_port(name, args.port, out)))
            stack.enter_context(interruptible(transport.name))
        board = connect(transport)
        with explained(board, args):
            yield board


def emulated_transports(
    out: Output, stack: ExitStack, *, model: RobotModel | None = None, as_built: bool = False
) -> dict[BoardName, Transport]:
    """Both boards' links of the robot of `--emulated`, which lives as long as `stack`; see `kept_robot`."""
    from tfsat_host.emulated.robot import BoardIndex
    from tfsat_host.emulated.state import kept_robot
    from tfsat_host.emulated.transport import EmulatedTransport

    robot = stack.enter_context(kept_robot(out.note, model=model, as_built=as_built))
    return {board: EmulatedTransport(robot, BoardIndex[board.upper()]) for board in BOARDS}


def open_port(board: BoardName, explicit: str | None, out: Output) -> SerialTransport:
    """The board's port, open. One that is not there yet is waited for: a board that was just plugged in, or
    an emulated one that was just started, takes a moment to show up.

    Raises:
        PortError: no port, or it could not be opened.
    """
    from tfsat_host.devices.transport import SerialTransport

    path = find_port(board, explicit)
    _refuse_a_dead_link(path)
    deadline_s = time.monotonic() + APPEARANCE_S
    noted = False
    while True:
        try:
            return SerialTransport(path)
        except PortError as error:
            if error.code != PortProblem.MISSING or (
                time.monotonic() > deadline_s and not _is_being_started(path)
            ):
                raise
        if not noted:
            out.note(f"waiting for {path} to appear …")
            noted = True
        time.sleep(0.1)


def _is_being_started(path: str) -> bool:
    """An emulated robot holds the port's folder and is still being built; it ends or serves."""
    if sys.platform == "win32":
        return False
    from tfsat_host.emulated.served_folder import being_started

    return being_started(Path(path))


def _refuse_a_dead_link(path: str) -> None:
    """A killed emulator's link may lead to another program's terminal by now."""
    if sys.platform == "win32" or not Path(path).is_symlink():
        return
    from tfsat_host.emulated.served_folder import served_by_dead_process

    if served_by_dead_process(Path(path)):
        raise PortError(
            PortProblem.MISSING,
            what=f"{path} was left behind by an emulated robot that was killed.",
            next_step=f"Start it again: tfsat-host emulate --dir {Path(path).parent}",
        )
