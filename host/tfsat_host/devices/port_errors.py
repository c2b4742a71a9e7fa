"""What can be wrong with a port, each with its own cure."""

from __future__ import annotations

import errno
import sys
from collections.abc import Sequence
from enum import StrEnum

from tfsat_host.errors import TfsatError

_NOTHING_SENT = "Nothing was sent; the robot is as it was."
_PLUG = {
    "sequencer": "Plug in the Arduino Micro (the sequencer) by USB",
    "logger": "Plug in the Teensy 4.1 (the logger) by USB",
}


class PortProblem(StrEnum):
    """Stable names of the problems."""

    NONE_FOUND = "none-found"
    AMBIGUOUS = "ambiguous"
    BOOTLOADER = "bootloader"
    MISSING = "missing"
    BUSY = "busy"
    NOT_PERMITTED = "not-permitted"
    NO_SERIAL_PORT = "no-serial-port"
    LOST = "lost"
    OTHER = "other"


class PortError(TfsatError):
    """A board's port was not found or could not be opened; `code` names the problem."""

    def __init__(self, code: PortProblem, *, what: str, next_step: str, meaning: str = _NOTHING_SENT) -> None:
        super().__init__(what=what, meaning=meaning, next_step=next_step)
        self.code = code


def none_found_error(board: str, others: Sequence[str], variable: str) -> PortError:
    """Autodetection found nothing."""
    seen = f" Other ports: {', '.join(others)}." if others else ""
    return PortError(
        PortProblem.NONE_FOUND,
        what=f"No {board} found: no serial port looks like one.{seen}",
        next_step=f"{_PLUG[board]} with a cable that carries data, or name its port with --port PORT "
        f"(or {variable}=PORT); tfsat-host ports lists them.",
    )


def ambiguous_error(board: str, candidates: Sequence[str], variable: str) -> PortError:
    """Autodetection found several; choosing one might arm the wrong robot."""
    return PortError(
        PortProblem.AMBIGUOUS,
        what=f"{len(candidates)} ports look like a {board}: {', '.join(candidates)}.",
        next_step=f"Name the one you mean with --port PORT (or {variable}=PORT), or unplug the others.",
    )


def bootloader_error(board: str, device: str) -> PortError:
    """The board runs its bootloader, not the sketch."""
    how = f": tfsat-host flash sequencer --port {device} --force" if board == "sequencer" else ""
    return PortError(
        PortProblem.BOOTLOADER,
        what=f"The {board} on {device} waits in its bootloader: it runs no firmware.",
        meaning="It was just reset, or it holds no sketch. Nothing was sent.",
        next_step=f"Wait 10 s and run the same command again; if it stays so, flash it once more{how}.",
    )


def open_error(path: str, code: int | None, text: str, *, platform: str = sys.platform) -> PortError:
    """Why the operating system did not open `path`.

    Args:
        path: The port that was asked for.
        code: The operating system's errno, if it gave one.
        text: Its words, for what is not foreseen.
        platform: As `sys.platform`; Windows gives no errno and reports a busy port as a denied one.
    """
    problem = _problem(code, text, platform)
    if problem is PortProblem.MISSING:
        what = f"The port {path} does not exist."
        next_step = "tfsat-host ports lists the ports there are; plug the board in, or correct --port."
    elif problem is PortProblem.BUSY:
        what = f"The port {path} is in use by another program."
        next_step = (
            "Close the Arduino IDE's serial monitor or the other tfsat-host that has it open; try again."
        )
    elif problem is PortProblem.NOT_PERMITTED:
        what = f"You are not permitted to open {path}."
        next_step = (
            "Join the group that owns serial ports, then log out and in: sudo usermod -aG dialout $USER\n"
            "Or, on Linux, install tools/udev/60-tfsat.rules; docs/guide/computer.md says how."
        )
    elif problem is PortProblem.NO_SERIAL_PORT:
        what = f"{path} is no serial port."
        next_step = "tfsat-host ports lists the serial ports there are; correct --port."
    else:
        what = f"The port {path} could not be opened: {text}."
        next_step = "Unplug the board, plug it in again, and run the same command."
    return PortError(problem, what=what, next_step=next_step)


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


def _problem(code: int | None, text: str, platform: str) -> PortProblem:
    if platform == "win32":
        if "FileNotFoundError" in text:
            return PortProblem.MISSING
        if "PermissionError" in text:
            return PortProblem.BUSY
    return _BY_ERRNO.get(code, PortProblem.OTHER) if code is not None else PortProblem.OTHER
