"""Serial ports: which one a board is on, opening it, and what can be wrong with it, each with its own cure.

`--port` beats the environment variable, which beats autodetection by USB vendor and product id.
"""

from __future__ import annotations

import errno
import logging
import os
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.served_robots import served_folders

if TYPE_CHECKING:
    import serial

_LOG = logging.getLogger(__name__)

BoardName = Literal["sequencer", "logger"]
Mode = Literal["sketch", "bootloader"]
BOARDS: tuple[BoardName, ...] = ("sequencer", "logger")

BAUDRATE = 115_200  # USB CDC ignores it, but 1200 would send an Arduino Micro into its bootloader
_PLUG = {
    "sequencer": "Plug in the Arduino Micro (the sequencer) by USB",
    "logger": "Plug in the Teensy 4.1 (the logger) by USB",
}


class PortProblem(StrEnum):
    """Stable names of what is wrong with a port, or with the board that answers there, or does not."""

    NONE_FOUND = "none-found"
    AMBIGUOUS = "ambiguous"
    BOOTLOADER = "bootloader"
    MISSING = "missing"
    BUSY = "busy"
    NOT_PERMITTED = "not-permitted"
    NO_SERIAL_PORT = "no-serial-port"
    LOST = "lost"
    NO_ANSWER = "no-answer"
    OTHER_BOARD = "other-board"
    OTHER_PROTOCOL = "other-protocol"
    OTHER = "other"


class PortError(TfsatError):
    """A board's port was not found or could not be opened; `code` names the problem."""

    def __init__(
        self,
        code: PortProblem,
        *,
        what: str,
        next_step: str,
        meaning: str = "Nothing was sent; the robot is unchanged.",
    ) -> None:
        super().__init__(what=what, meaning=meaning, next_step=next_step, code=code)


@dataclass(frozen=True, slots=True)
class PortInfo:
    """A serial port of this computer, as the operating system describes it, or one of an emulated robot.

    Attributes:
        emulated: Which board of a served robot is there; None: what it is, its USB ids tell.
    """

    device: str
    vid: int | None = None
    pid: int | None = None
    serial_number: str | None = None
    description: str | None = None
    emulated: BoardName | None = None


@dataclass(frozen=True, slots=True)
class Identity:
    """What a port's USB ids say it is; only HELLO tells for certain."""

    board: BoardName
    mode: Mode


# Arduino's boards.txt (micro.vid/pid, 0x2341 Arduino LLC, 0x2A03 Arduino srl) and PJRC's udev rules.
# A Teensy in its bootloader is a HID device: it never shows up as a serial port.
_USB_IDS: Mapping[tuple[int, int], Identity] = {
    (0x2341, 0x8037): Identity("sequencer", "sketch"),
    (0x2A03, 0x8037): Identity("sequencer", "sketch"),
    (0x2341, 0x8237): Identity("sequencer", "sketch"),
    (0x2341, 0x0037): Identity("sequencer", "bootloader"),
    (0x2A03, 0x0037): Identity("sequencer", "bootloader"),
    (0x2341, 0x0237): Identity("sequencer", "bootloader"),
    (0x16C0, 0x0483): Identity("logger", "sketch"),
}


def port_variable(board: BoardName) -> str:
    """Name of the environment variable that names the board's port."""
    return f"TFSAT_{board.upper()}_PORT"


def identify(port: PortInfo) -> Identity | None:
    """Identify the board by the port's USB ids; None if it is none of ours."""
    if port.emulated is not None:
        return Identity(port.emulated, "sketch")
    if port.vid is None or port.pid is None:
        return None
    return _USB_IDS.get((port.vid, port.pid))


def system_ports() -> list[PortInfo]:
    """List the serial ports of this computer, and those of emulated robots that are served on it."""
    from serial.tools.list_ports import comports

    found = [PortInfo(p.device, p.vid, p.pid, p.serial_number, p.description) for p in comports()]
    served = [
        PortInfo(str(folder / board), description="emulated robot", emulated=board)
        for folder in served_folders()
        for board in BOARDS
        # There is no link while the cable is pulled.
        if (folder / board).exists()
    ]
    return found + served


def find_port(
    board: BoardName,
    explicit: str | None = None,
    environ: Mapping[str, str] | None = None,
    list_ports: Callable[[], Iterable[PortInfo]] = system_ports,
) -> str:
    """Find the device path of the board's port.

    Args:
        board: Which board is wanted.
        explicit: What `--port` names; then nothing is scanned and nothing is checked.
        environ: The environment; the process's own by default.
        list_ports: Gives the ports of this computer.

    Raises:
        PortError: no port looks like the board, several do, or it waits in its bootloader.
    """
    if explicit is not None:
        _LOG.debug("%s: port %s, as named", board, explicit)
        return explicit
    variable = port_variable(board)
    variables = os.environ if environ is None else environ
    if named := variables.get(variable):
        _LOG.debug("%s: port %s, by %s", board, named, variable)
        return named
    ports = list(list_ports())
    candidates = [port for port in ports if identify(port) == Identity(board, "sketch")]
    # Next to a real board an emulated one answers for nothing: it would vouch for a recording that no drop gets.
    beside = [name for other in BOARDS if (name := variables.get(port_variable(other)))]
    if any(identify(port) for port in ports if port.emulated is None):
        candidates = [port for port in candidates if port.emulated is None]
    candidates = [port for port in candidates if port.emulated is None or _same_folder(port.device, beside)]
    _LOG.debug("%s: %d of %d ports look like it", board, len(candidates), len(ports))
    if len(candidates) == 1:
        return candidates[0].device
    if candidates:  # choosing one might arm the wrong robot
        raise PortError(
            PortProblem.AMBIGUOUS,
            what=f"{len(candidates)} ports look like a {board}: {', '.join(map(_describe_port, candidates))}.",
            next_step=f"Name the one you mean with --port PORT (or {variable}=PORT), or unplug the others.",
        )
    # In its bootloader a board has other USB ids: tell it from one that is not plugged in.
    for port in ports:
        if identify(port) == Identity(board, "bootloader"):
            how: str = ""
            if board == "sequencer":
                how = Advice(": ", NextStep("flash sequencer", ("--port", port.device, "--force")))
            raise PortError(
                PortProblem.BOOTLOADER,
                what=f"The {board} on {port.device} waits in its bootloader: it runs no firmware.",
                meaning="It was just reset, or it holds no sketch. Nothing was sent.",
                next_step=Advice(
                    "Wait 10 s and run the same command again; if it stays so, flash it once more", how, "."
                ),
            )
    others = f" Other ports: {', '.join(map(_describe_port, ports))}." if ports else ""
    raise PortError(
        PortProblem.NONE_FOUND,
        what=f"No {board} found: no serial port looks like one.{others}",
        next_step=Advice(
            f"{_PLUG[board]} with a cable that carries data, or name its port with --port PORT "
            f"(or {variable}=PORT); ",
            NextStep("ports"),
            " lists them.",
        ),
    )


def _same_folder(port: str, named: Iterable[str]) -> bool:
    """Return whether every named port lies in the folder of this one."""
    return all(Path(name).parent.resolve() == Path(port).parent.resolve() for name in named)


def _describe_port(port: PortInfo) -> str:
    identity = identify(port)
    looks = identity.board if identity else (port.description or "unknown")
    serial_number = f", serial number {port.serial_number}" if port.serial_number else ""
    return f"{port.device} ({looks}{serial_number})"


def open_serial(path: str, *, read_timeout_s: float = 0.05, write_timeout_s: float = 1.0) -> serial.Serial:
    """Opens the port for this program alone; a write that is not taken ends after `write_timeout_s`.

    Pseudo-terminals work too: they have no modem lines, so DTR and RTS are left as opening sets them.

    Raises:
        PortError: missing, busy, not permitted, or no serial port; distinguished by `code`.
    """
    import serial

    # For this program alone: two readers of a link would take bytes from each other.
    try:
        return serial.Serial(
            path, BAUDRATE, timeout=read_timeout_s, write_timeout=write_timeout_s, exclusive=True
        )
    except (OSError, ValueError) as error:  # SerialException is an OSError
        raise open_error(path, _errno(error), str(error)) from error


def _errno(error: Exception) -> int | None:
    """Find the error number in an exception or the exceptions it was raised from.

    pyserial drops the number of a failed configuration, but the exception that it was handling still has it.
    """
    cause: BaseException | None = error
    while cause is not None:
        number = getattr(cause, "errno", None)
        # An error of termios has no errno attribute: its first argument is the number.
        if number is None and cause.args and type(cause).__module__ == "termios":
            number = cause.args[0]
        if isinstance(number, int):
            return number
        cause = cause.__context__
    return None


_BY_ERRNO = {
    errno.ENOENT: PortProblem.MISSING,
    errno.ENXIO: PortProblem.MISSING,
    errno.ENODEV: PortProblem.MISSING,
    errno.ENOTDIR: PortProblem.MISSING,
    errno.EBUSY: PortProblem.BUSY,
    errno.EAGAIN: PortProblem.BUSY,
    errno.EACCES: PortProblem.NOT_PERMITTED,
    errno.EPERM: PortProblem.NOT_PERMITTED,
    errno.EISDIR: PortProblem.NO_SERIAL_PORT,
    errno.ENOTTY: PortProblem.NO_SERIAL_PORT,
    errno.EINVAL: PortProblem.NO_SERIAL_PORT,
}
_WINDOWS = {"FileNotFoundError": PortProblem.MISSING, "PermissionError": PortProblem.BUSY}
"""Windows gives no errno and reports a busy port as a denied one."""
_OPENING = {
    PortProblem.MISSING: (
        "The port {path} does not exist.",
        Advice(NextStep("ports"), " lists the ports there are; plug the board in, or correct --port."),
    ),
    PortProblem.BUSY: (
        "The port {path} is in use by another program.",
        "Close the Arduino IDE's serial monitor or the other tfsat-host that has it open; try again.",
    ),
    PortProblem.NOT_PERMITTED: (
        "You are not permitted to open {path}.",
        "Join the group that owns serial ports, then log out and in: sudo usermod -aG dialout $USER\n"
        "Or, on Linux, install tools/udev/60-tfsat.rules; docs/guide/computer.md says how.",
    ),
    PortProblem.NO_SERIAL_PORT: (
        "{path} is no serial port.",
        Advice(NextStep("ports"), " lists the serial ports there are; correct --port."),
    ),
    PortProblem.OTHER: (
        "The port {path} could not be opened: {text}.",
        "Unplug the board, plug it in again, and run the same command.",
    ),
}
"""What happened and what to do."""


def open_error(path: str, code: int | None, text: str, *, platform: str = sys.platform) -> PortError:
    """Why the operating system did not open `path`; `text` are its words, for a `code` (errno) not foreseen."""
    problem = _BY_ERRNO.get(-1 if code is None else code, PortProblem.OTHER)
    if platform == "win32":
        problem = next((candidate for name, candidate in _WINDOWS.items() if name in text), problem)
    what, next_step = _OPENING[problem]
    return PortError(problem, what=what.format(path=path, text=text), next_step=next_step)
