"""avrdude, which speaks the bootloader's protocol: its command line, its progress, its complaints."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from pathlib import Path

from tfsat_host.errors import TfsatError
from tfsat_host.flashing.ports import Computer

PROGRAM = "avrdude"
TIMEOUT_S = 120.0
"""A whole flash takes some 5 s with its verification."""
MARKS = 50
"""Of `#` in one bar of avrdude."""

_BAR = re.compile(r"(Reading|Writing|Verifying)\s*\|")
_INTACT = "The board's bootloader is intact and waits for the next try; the sketch may be incomplete."
_AGAIN = "tfsat-host flash sequencer --force"
_WHY = (
    (
        re.compile(r"permission denied|access is denied", re.IGNORECASE),
        "You are not permitted to open the bootloader's port.",
        "Join the group that owns serial ports, then log out and in: sudo usermod -aG dialout $USER",
    ),
    (
        re.compile(r"verification (mismatch|error)|verify failed", re.IGNORECASE),
        "What was read back from the board is not what was written.",
        "Try another cable and port of the computer; if it recurs, replace the Arduino Micro.",
    ),
    (
        re.compile(r"(can't|cannot|unable to) open", re.IGNORECASE),
        "The bootloader's port could not be opened: it was gone again, or another program has it.",
        "Close the Arduino IDE and every serial monitor.",
    ),
    (
        re.compile(r"not respond|timeout|signature", re.IGNORECASE),
        "The bootloader did not answer, or not as an ATmega32U4 does.",
        "Unplug the board and plug it in again; check that it is an Arduino Micro.",
    ),
)


class FlashError(TfsatError):
    """Flashing failed; `code` names the step."""

    def __init__(self, code: str, *, what: str, meaning: str, next_step: str) -> None:
        super().__init__(what=what, meaning=meaning, next_step=next_step)
        self.code = code


def find_avrdude(computer: Computer) -> str:
    """The program's path. Raises FlashError with how to install it."""
    path = computer.find_program(PROGRAM)
    if path is None:
        raise FlashError(
            "avrdude-missing",
            what="avrdude is not installed, or not on the PATH.",
            meaning="Nothing was flashed: avrdude is what writes to an Arduino. The board was not touched.",
            next_step="Debian, Ubuntu: sudo apt install avrdude\nmacOS: brew install avrdude\n"
            "Windows: winget install AVRDudes.AVRDUDE, then a new terminal\nThen the same command again.",
        )
    return path


def command_line(program: str, port: str, hex_path: Path) -> list[str]:
    """Writes the image and reads it back, as the Arduino IDE does (boards.txt, micro: avr109 at 57600)."""
    return [
        program,
        *("-p", "atmega32u4"),
        *("-c", "avr109"),
        *("-P", port),
        *("-b", "57600"),
        "-D",
        *("-U", f"flash:w:{hex_path}:i"),
    ]


def run_avrdude(computer: Computer, command: list[str], progress: Callable[[str, int], None]) -> None:
    """Runs it.

    Args:
        computer: Runs programs.
        command: As `command_line` gives it.
        progress: Told the name of the present bar and how many of its MARKS were added.

    Raises:
        FlashError: it could not be started, failed, or hung.
    """
    said: list[str] = []
    bars = Bars(progress)

    def heard(text: str) -> None:
        said.append(text)
        bars.feed(text)

    try:
        code = computer.run(command, heard, TIMEOUT_S)
    except OSError as error:
        raise FlashError(
            "avrdude-failed",
            what=f"{command[0]} cannot be started: {error.strerror or error}.",
            meaning=_INTACT,
            next_step=f"Install avrdude anew, then: {_AGAIN}",
        ) from error
    if code != 0:
        raise _complaint(command, code, "".join(said))


class Bars:
    """Follows avrdude's bars, `Writing | ####…# | 100% 0.5 s`, however the text is cut."""

    def __init__(self, progress: Callable[[str, int], None]) -> None:
        self._progress = progress
        self._tail = ""
        self._bar: str | None = None
        self._marks = 0

    def feed(self, text: str) -> None:
        """Takes what avrdude said next."""
        for character in text:
            if self._bar is not None and character == "#" and self._marks < MARKS:
                self._marks += 1
                self._progress(self._bar, 1)
                continue
            self._tail = (self._tail + character)[-20:]
            found = _BAR.search(self._tail)
            if found:
                self._bar, self._marks, self._tail = found[1].lower(), 0, ""
                self._progress(self._bar, 0)


def _complaint(command: list[str], code: int | None, said: str) -> FlashError:
    last_words = "\n".join([line for line in said.splitlines() if line.strip()][-6:]) or "It said nothing."
    shown = f"{shlex.join(command)}\n{last_words}"
    if code is None:
        what, cure = (
            f"avrdude did not end within {TIMEOUT_S:g} s: {shown}",
            "Unplug the board and plug it in.",
        )
    else:
        for pattern, reason, remedy in _WHY:
            if pattern.search(said):
                what, cure = f"{reason} avrdude failed with exit code {code}: {shown}", remedy
                break
        else:
            what, cure = f"avrdude failed with exit code {code}: {shown}", "Unplug the board and plug it in."
    kind = "verify-failed" if "not what was written" in what else "avrdude-failed"
    return FlashError(kind, what=what, meaning=_INTACT, next_step=f"{cure}\nThen: {_AGAIN}")
