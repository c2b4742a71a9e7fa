"""Makes a board's refusal fit the command that met it: the state it is in, and commands that can be typed as shown."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from tfsat_host.errors import Interrupted, RefusedError
from tfsat_host.protocol.enums import ErrorCode

if TYPE_CHECKING:
    from tfsat_host.devices.logger import DropInDanger, LoggerClient
    from tfsat_host.devices.sequencer import SequencerClient

_DEVICE_COMMAND = re.compile(
    r"tfsat-host (?:status|disarm|arm|jog|upload-servos|upload-sequence 59 70|record (?:start|stop)|"
    r"log (?:list|(?:fetch|erase)(?: (?:ram|all|\d+))?)|logger-settings(?! --help))"
)


def device_option(args: argparse.Namespace) -> str:
    """The device option as the user gave it, with a space before; empty when there was none."""
    if args.emulated:
        return " --emulated"
    return f" --port {shlex.quote(args.port)}" if args.port is not None else ""


@contextmanager
def explained(board: SequencerClient | LoggerClient, args: argparse.Namespace) -> Iterator[None]:
    """Adds to a board's error raised inside: the state where that is the reason, and the device option."""
    from tfsat_host.devices.client import BoardError

    try:
        yield
    except BoardError as error:
        if error.code == ErrorCode.WRONG_STATE:
            error.what, error.next_step = _wrong_state(board)
            error.meaning, error.next_step = _drop_in_danger(board) or (error.meaning, error.next_step)
        error.next_step = _DEVICE_COMMAND.sub(lambda found: found[0] + device_option(args), error.next_step)
        raise


@contextmanager
def offering_emulated() -> Iterator[None]:
    """Adds to "no board found": only for commands that are not mistaken for having reached the robot."""
    from tfsat_host.devices.ports import PortError, PortProblem

    try:
        yield
    except PortError as error:
        if error.code == PortProblem.NONE_FOUND:
            error.next_step += "\nTo try the command without the board: add --emulated."
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
            next_step=f"tfsat-host status --port {shlex.quote(port)} shows what state that is.",
        ) from None


def refuse_emulated(args: argparse.Namespace, command: str, consequence: str) -> None:
    """Raises RefusedError for `--emulated` with a command whose effect would end with the process."""
    if not args.emulated:
        return
    board = "logger" if command.startswith("record") else "sequencer"
    raise RefusedError(
        what=f"{command} --emulated is refused: the emulated robot lives in this process only.",
        meaning=f"{consequence} Nothing was done.",
        next_step="Keep an emulated robot running in another terminal: tfsat-host emulate\n"
        f"Then: tfsat-host {command} --port robot/{board}",
    )


def _wrong_state(board: SequencerClient | LoggerClient) -> tuple[str, str]:
    """What happened, and what to do: from the state that the board is in."""
    name = board.identity.board.name.lower()
    state = board.status().state.name.lower()
    words, cure = _WRONG_STATES.get((name, state), (state, "Wait a second"))
    return (
        f"The {name} is {words}; it does not take this request now.",
        f"{cure}, then the same command again.",
    )


def _drop_in_danger(board: SequencerClient | LoggerClient) -> DropInDanger | None:
    """What is worse than a refused request: a drop that no card takes."""
    from tfsat_host.devices.logger import drop_in_danger
    from tfsat_host.protocol.messages import LoggerStatusReply

    status = board.status()
    return drop_in_danger(status) if isinstance(status, LoggerStatusReply) else None


_WRITING = "still writing its EEPROM"
_WRONG_STATES = {
    ("sequencer", "safe"): (f"safe, but {_WRITING}", "Wait a second"),
    ("sequencer", "armed"): ("armed", "tfsat-host disarm"),
    ("sequencer", "running"): ("running", "Wait until the maneuver is over, or tfsat-host disarm"),
    ("sequencer", "done"): ("done: its servos hold the end pose", "tfsat-host disarm"),
    ("sequencer", "jogging"): ("moving a joint", "tfsat-host disarm"),
    ("sequencer", "fault"): ("in fault", "tfsat-host status to see why and tfsat-host disarm to clear it"),
    ("logger", "recording"): ("recording already", "tfsat-host record stop"),
    ("logger", "failed"): (
        "still recording into its RAM, as its card has failed",
        "tfsat-host record stop ends that",
    ),
    ("logger", "stopping"): ("still closing its last recording", "Wait until it is closed"),
}
"""By board and state: the state in words, and what ends it."""
