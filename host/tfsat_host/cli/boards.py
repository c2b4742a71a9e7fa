"""The boards of a command: found by its options, opened, and what their refusals mean for whoever typed it."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from tfsat_host.cli.usage import OUTPUT
from tfsat_host.devices.board_errors import BoardError
from tfsat_host.devices.jogging import JogClient
from tfsat_host.devices.logger import DropInDanger, LoggerClient, drop_in_danger
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.devices.serial_ports import (
    BOARDS,
    BoardName,
    PortError,
    PortProblem,
    find_port,
    port_variable,
)
from tfsat_host.devices.transport import SerialTransport, Transport
from tfsat_host.errors import Interrupted, RefusedError, TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.messages import LoggerStatusReply
from tfsat_host.served_robots import served_folders
from tfsat_host.servo_settings import ServoSettings, find_misfit

if TYPE_CHECKING:
    from tfsat_host.robot import RobotModel


@contextmanager
def explain_wrong_state(board: SequencerClient | LoggerClient) -> Iterator[None]:
    """Say which state the board is in where that is why it refused a request inside."""
    try:
        yield
    except BoardError as error:
        if error.code != ErrorCode.WRONG_STATE:
            raise
        what, next_step = _wrong_state(board)
        meaning, next_step = _drop_in_danger(board) or (error.meaning, next_step)
        raise error.with_words(what=what, meaning=meaning, next_step=next_step) from None


@contextmanager
def offering_emulated() -> Iterator[None]:
    """Adds to "no board found": only for commands that are not mistaken for having reached the robot."""
    try:
        yield
    except PortError as error:
        if error.code == PortProblem.NONE_FOUND:
            next_step = Advice(error.next_step, "\nTo try the command without the board: add --emulated.")
            raise error.with_words(next_step=next_step) from None
        raise


@contextmanager
def interruptible(port: str) -> Iterator[None]:
    """Ctrl-C inside becomes `Interrupted`: only here does a board go on that the user should look at."""
    try:
        yield
    except KeyboardInterrupt:
        raise Interrupted(
            what="Interrupted.",
            meaning=f"The command stopped before it was done; the board at {port} goes on in its own state.",
            next_step=Advice(NextStep("status", ("--port", port)), " shows what state that is."),
        ) from None


def warn_of_misfit(sequencer: SequencerClient, settings: ServoSettings, out: Output) -> bool:
    """Return whether the maneuver on the board fits these servo settings; warn if it does not."""
    misfit = find_misfit(sequencer.read_back().timed_strokes, settings)
    if misfit is not None:
        out.warn(
            Advice(
                f"The maneuver on the board does not fit these settings: {misfit.words}. ARM will refuse it. "
                "Upload one that fits: ",
                NextStep("upload-sequence", ("A", "B")),
            )
        )
    return misfit is None


def refuse_emulated(args: argparse.Namespace, command: str, consequence: str) -> None:
    """Raises RefusedError for `--emulated` with a command whose effect would end with the process."""
    if not args.emulated:
        return
    board = "logger" if command.startswith("record") else "sequencer"
    raise RefusedError(
        what=f"{command} --emulated is refused: the emulated robot lives in this process only.",
        meaning=f"{consequence} Nothing was done.",
        next_step=f"Keep an emulated robot running in another terminal: {NextStep('emulate')}\n"
        f"Then: {NextStep(command, ('--port', f'robot/{board}'))}",
    )


def _wrong_state(board: SequencerClient | LoggerClient) -> tuple[str, str]:
    """Describe, from the board's state, why it refused a request and what to do."""
    name = board.identity.board.name.lower()
    state = board.status().state.name.lower()
    words, cure = _WRONG_STATES.get((name, state), (state, "Wait a second"))
    return (
        f"The {name} is {words}; it does not take this request now.",
        Advice(cure, ", then the same command again."),
    )


def _drop_in_danger(board: SequencerClient | LoggerClient) -> DropInDanger | None:
    """Return the error of a drop that no card takes, which is graver than a refused request; None if none."""
    status = board.status()
    return drop_in_danger(status) if isinstance(status, LoggerStatusReply) else None


_WRITING = "still writing its EEPROM"
_DISARM = NextStep("disarm")
_WRONG_STATES = {
    ("sequencer", "safe"): (f"safe, but {_WRITING}", "Wait a second"),
    ("sequencer", "armed"): ("armed", Advice(_DISARM)),
    ("sequencer", "running"): ("running", Advice("Wait until the maneuver is over, or ", _DISARM)),
    ("sequencer", "done"): ("done: its servos hold the end pose", Advice(_DISARM)),
    ("sequencer", "jogging"): ("moving a joint", Advice(_DISARM)),
    ("sequencer", "fault"): (
        "in fault",
        Advice(NextStep("status"), " to see why and ", _DISARM, " to clear it"),
    ),
    ("logger", "recording"): ("recording already", Advice(NextStep("record stop"))),
    ("logger", "failed"): (
        "still recording into its RAM, as its card has failed",
        Advice(NextStep("record stop"), " ends that"),
    ),
    ("logger", "stopping"): ("still closing its last recording", "Wait until it is closed"),
}
"""By board and state: the state in words, and what ends it."""


AnyBoard = TypeVar("AnyBoard", bound="SequencerClient | LoggerClient")


def open_sequencer(args: argparse.Namespace, out: Output) -> AbstractContextManager[SequencerClient]:
    """Open the sequencer that the options name. Raises PortError, NoAnswer, WrongBoard, BuildError."""
    return _board("sequencer", args, out, SequencerClient.connect)


def open_any_sequencer(args: argparse.Namespace, out: Output) -> AbstractContextManager[SequencerClient]:
    """Open the sequencer that the options name, whatever its protocol.

    For DISARM, which is the same in all protocols. Raises PortError, NoAnswer, WrongBoard, BuildError.
    """
    return _board("sequencer", args, out, SequencerClient.connect_any_protocol)


def open_jog_client(args: argparse.Namespace, out: Output) -> AbstractContextManager[JogClient]:
    """Open the sequencer that the options name to move a joint; it must speak this program's protocol.

    Raises PortError, NoAnswer, WrongBoard, BuildError.
    """
    return _board("sequencer", args, out, JogClient.connect)


def open_logger(args: argparse.Namespace, out: Output) -> AbstractContextManager[LoggerClient]:
    """Open the logger that the options name. Raises PortError, NoAnswer, WrongBoard, BuildError."""
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
        with explain_wrong_state(board):
            yield board


def emulated_transports(
    out: Output, stack: ExitStack, *, model: RobotModel | None = None, as_built: bool = False
) -> dict[BoardName, Transport]:
    """Connect to both boards of the `--emulated` robot, which lives as long as `stack`; see `kept_robot`."""
    from tfsat_host.emulated.emulated_robot import BoardIndex
    from tfsat_host.emulated.emulated_transport import EmulatedTransport
    from tfsat_host.emulated.state import kept_robot

    robot = stack.enter_context(kept_robot(out.note, model=model, as_built=as_built))
    return {board: EmulatedTransport(robot, BoardIndex[board.upper()]) for board in BOARDS}


def open_port(board: BoardName, explicit: str | None, out: Output) -> SerialTransport:
    """Open the board's port; waits for it only while the emulated robot that will serve it is being started.

    Raises:
        PortError: no port, or it could not be opened.
    """
    path = find_port(board, explicit)
    _refuse_a_dead_link(path)
    # Found, not named: whoever believes that a real board is plugged in is to see that it is not.
    if explicit is None and port_variable(board) not in os.environ and Path(path).parent in served_folders():
        out.note(f"No {board} is plugged in: this is the emulated robot in {Path(path).parent}.")
    announced = False
    while True:
        try:
            return SerialTransport(path)
        except PortError as error:
            if error.code != PortProblem.MISSING or not _is_being_started(path):
                raise
        if not announced:
            out.note(f"waiting for {path} to appear …")
            announced = True
        time.sleep(0.1)


def _is_being_started(path: str) -> bool:
    """Return whether an emulated robot holds the port's folder and is still being built.

    Such a robot ends or serves.
    """
    if sys.platform == "win32":
        return False
    from tfsat_host.emulated.state import being_started

    return being_started(Path(path))


def _refuse_a_dead_link(path: str) -> None:
    """Refuse a link that a killed emulator left behind.

    It may lead to another program's terminal by now.
    """
    if sys.platform == "win32" or not Path(path).is_symlink():
        return
    from tfsat_host.emulated.state import served_by_dead_process

    if served_by_dead_process(Path(path)):
        raise PortError(
            PortProblem.MISSING,
            what=f"{path} was left behind by an emulated robot that was killed.",
            next_step=f"Start it again: {NextStep('emulate', ('--dir', str(Path(path).parent)))}",
        )


PLACE = f"""\
device:
| --port PORT  ask the board at this port only, whichever it is
| --emulated   ask the emulated robot's boards
{OUTPUT}"""
"""One port, or the emulated boards, and the output options."""


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


def absent(error: TfsatError) -> bool:
    """Nothing is plugged in."""
    return isinstance(error, PortError) and error.code == PortProblem.NONE_FOUND


def most_telling(errors: list[TfsatError]) -> TfsatError:
    """Return the first error that says more than that nothing is plugged in, else the first error.

    At least one error must be given.
    """
    return min(errors, key=absent)


def places(args: argparse.Namespace, out: Output, stack: ExitStack) -> list[Place]:
    """List the places to query; emulated boards live as long as `stack`. Raises BuildError."""
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
            partial(open_port, board, None, out),
        )
        for board in BOARDS
    ]


def _same(transport: Transport) -> Transport:
    return transport
