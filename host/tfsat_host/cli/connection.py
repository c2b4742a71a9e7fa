"""From `--port` or `--emulated` to a board that has identified itself."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from tfsat_host.cli.advice import explained, interruptible
from tfsat_host.devices.ports import BoardName, PortError, PortProblem, find_port

if TYPE_CHECKING:
    from tfsat_host.devices.jogging import JogClient
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.devices.sequencer import SequencerClient
    from tfsat_host.devices.transport import SerialTransport, Transport
    from tfsat_host.emulated.robot import EmulatedRobot
    from tfsat_host.present.output import Output
    from tfsat_host.robot import RobotModel

AnyBoard = TypeVar("AnyBoard", bound="SequencerClient | LoggerClient")

APPEARANCE_S = 4.0
"""A board re-enumerates within two seconds of a reset."""


@contextmanager
def open_sequencer(args: argparse.Namespace, out: Output) -> Iterator[SequencerClient]:
    """The sequencer that the options name. Raises PortError, NoAnswer, WrongBoard, BuildError."""
    from tfsat_host.devices.sequencer import SequencerClient

    with _board("sequencer", args, out, SequencerClient.connect) as sequencer:
        yield sequencer


@contextmanager
def open_any_sequencer(args: argparse.Namespace, out: Output) -> Iterator[SequencerClient]:
    """Likewise, of whatever protocol: for DISARM, which is the same in all. Raises the same."""
    from tfsat_host.devices.sequencer import SequencerClient

    with _board("sequencer", args, out, SequencerClient.connect_any_protocol) as sequencer:
        yield sequencer


@contextmanager
def open_jog_client(args: argparse.Namespace, out: Output) -> Iterator[JogClient]:
    """Likewise, of this program's protocol, to move a joint. Raises the same."""
    from tfsat_host.devices.jogging import JogClient

    with _board("sequencer", args, out, JogClient.connect) as sequencer:
        yield sequencer


@contextmanager
def open_logger(args: argparse.Namespace, out: Output) -> Iterator[LoggerClient]:
    """The logger that the options name. Raises PortError, NoAnswer, WrongBoard, BuildError."""
    from tfsat_host.devices.logger import LoggerClient

    def connect(transport: Transport) -> LoggerClient:
        note = "the logger has just met its card and counts its free room …"
        return LoggerClient.connect(transport, on_busy=lambda: out.note(note))

    with _board("logger", args, out, connect) as logger:
        yield logger


@contextmanager
def _board(
    name: BoardName, args: argparse.Namespace, out: Output, connect: Callable[[Transport], AnyBoard]
) -> Iterator[AnyBoard]:
    with ExitStack() as stack:
        transport: Transport
        if args.emulated:
            from tfsat_host.emulated.robot import BoardIndex
            from tfsat_host.emulated.transport import EmulatedTransport

            robot = stack.enter_context(emulated_robot(out))
            transport = EmulatedTransport(robot, BoardIndex[name.upper()])
        else:
            transport = stack.enter_context(closing(open_port(name, args.port, out)))
            stack.enter_context(interruptible(transport.name))
        board = connect(transport)
        with explained(board, args):
            yield board


def device(board: SequencerClient | LoggerClient) -> dict[str, str | None]:
    """The port and who answers there, for `--json`."""
    return {"port": board.port, **board.identity.as_dict()}


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


@contextmanager
def emulated_robot(
    out: Output, *, model: RobotModel | None = None, as_built: bool = False
) -> Iterator[EmulatedRobot]:
    """The robot of `--emulated`: what its boards store, and its card, are kept from one command to the next.

    Args:
        out: Says that it is being built.
        model: The bodies; the drop tower robot by default.
        as_built: Nobody has calibrated it: also its scale factors, angle sensors and servos are off.

    Raises:
        BuildError: it cannot be built.
        TfsatError: what was kept is damaged.
    """
    from tfsat_host.emulated.imperfections import draw, draw_as_built
    from tfsat_host.emulated.robot import DEFAULT_SEED, SETTLE_US, EmulatedRobot
    from tfsat_host.emulated.state import KeptState

    kept = KeptState.of_user()
    before = kept.load()
    wrong = (draw_as_built if as_built else draw)(DEFAULT_SEED)
    with EmulatedRobot(
        model,
        imperfections=wrong,
        eeprom=before.eeprom,
        logger_memory=before.logger_memory,
        progress=out.note,
    ) as robot:
        before.put_card(robot)
        robot.advance(SETTLE_US)
        yield robot
        kept.save(robot, before)
