"""The programs that write to the boards, avrdude and teensy_loader_cli, and what flashing needs of the computer."""

from __future__ import annotations

import codecs
import contextlib
import re
import shlex
import shutil
import subprocess
import threading
import time
from collections.abc import Callable, Sequence

from tfsat_host.devices.serial_ports import PortInfo, open_error, open_serial, system_ports
from tfsat_host.devices.transport import SerialTransport, Transport
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep

_CHUNK_BYTES = 256


class Computer:
    """Serial ports, programs and time; a test plays one of its own."""

    def ports(self) -> list[PortInfo]:
        """Return the serial ports that exist now."""
        return system_ports()

    def connect(self, path: str) -> Transport:
        """Open the port. Raises PortError."""
        return SerialTransport(path)

    def find_program(self, name: str) -> str | None:
        """Find the path of an installed program; None if it is not installed."""
        return shutil.which(name)

    def now_s(self) -> float:
        """Seconds from any origin."""
        return time.monotonic()

    def sleep(self, duration_s: float) -> None:
        """Lets time pass."""
        time.sleep(duration_s)

    def touch(self, path: str, baudrate: int = 1200) -> None:
        """Opens the port at this rate and closes it, DTR low: at 1200 baud, an Arduino Micro starts its bootloader.

        Raises PortError.
        """
        import serial

        port = open_serial(path)
        try:
            # The rate itself is the command: no byte is sent.
            port.baudrate = baudrate
            with contextlib.suppress(
                OSError
            ):  # a pseudo-terminal has no DTR; closing lowers it elsewhere too
                port.dtr = False
        except serial.SerialException as error:
            raise open_error(path, error.errno, str(error)) from error
        finally:
            port.close()

    def run(self, command: Sequence[str], output: Callable[[str], None], timeout_s: float) -> int | None:
        """Runs a program and passes on its output, as it comes; its exit code, None if it was ended for time.

        Raises OSError if it cannot be started.
        """
        # Undecoded and unbuffered: progress comes as single characters without line ends.
        with subprocess.Popen(
            list(command),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            bufsize=0,
        ) as process:
            assert process.stdout is not None
            overdue = threading.Event()

            def end() -> None:
                # The exit code alone does not tell a timeout from a loader that failed.
                overdue.set()
                process.kill()

            timer = threading.Timer(timeout_s, end)
            timer.start()
            # A chunk may end inside a character of several bytes.
            decoder = codecs.getincrementaldecoder("utf-8")(errors="replace")
            try:
                while chunk := process.stdout.read(_CHUNK_BYTES):
                    output(decoder.decode(chunk))
                code = process.wait()
            except BaseException:
                # After Ctrl-C too: no loader goes on in the background.
                process.kill()
                raise
            finally:
                timer.cancel()
        return None if overdue.is_set() else code


AVRDUDE = "avrdude"
AVRDUDE_TIMEOUT_S = 120.0
"""A whole flash takes some 5 s with its verification."""
MARKS = 50
"""Of `#` in one bar of avrdude."""
TEENSY_LOADER = "teensy_loader_cli"
TEENSY_TIMEOUT_S = 60.0
"""Erasing and writing takes some 3 s; it may take a person to press the board's button."""
AGAIN = {board: NextStep(f"flash {board}", ("--force",)) for board in ("sequencer", "logger")}

_LAST_LINES = 6
_BAR = re.compile(r"(Reading|Writing|Verifying)\s*\|")
_REPLUG = "Unplug the board and plug it in."
_INTACT = "The board's bootloader is intact and waits for the next try; the sketch may be incomplete."
MISSING_PROGRAMS = {
    AVRDUDE: (
        "avrdude-missing",
        "avrdude is what writes to an Arduino",
        "Debian, Ubuntu: sudo apt install avrdude\nmacOS: brew install avrdude\n"
        "Windows: winget install AVRDudes.AVRDUDE, then a new terminal\nThen the same command again.",
    ),
    TEENSY_LOADER: (
        "loader-missing",
        "it is what writes to a Teensy",
        "Debian, Ubuntu: sudo apt install teensy-loader-cli\nmacOS: brew install teensy_loader_cli\n"
        "Then the same command again; or upload the sketch by the Arduino IDE.",
    ),
}
"""A missing program's error code, what the program is for, and how to install it."""
# The first that fits counts: a port that cannot be opened may be denied, which has its own cure.
_COMPLAINTS = (
    (
        re.compile(r"permission denied|access is denied", re.IGNORECASE),
        "avrdude-failed",
        "You are not permitted to open the bootloader's port.",
        "Join the group that owns serial ports, then log out and in: sudo usermod -aG dialout $USER",
    ),
    (
        re.compile(r"verification (mismatch|error)|verify failed", re.IGNORECASE),
        "verify-failed",
        "What was read back from the board is not what was written.",
        "Try another cable and port of the computer; if it recurs, replace the Arduino Micro.",
    ),
    (
        re.compile(r"(can't|cannot|unable to) open", re.IGNORECASE),
        "avrdude-failed",
        "The bootloader's port could not be opened: it was gone again, or another program has it.",
        "Close the Arduino IDE and every serial monitor.",
    ),
    (
        re.compile(r"not respond|timeout|signature", re.IGNORECASE),
        "avrdude-failed",
        "The bootloader did not answer, or not as an ATmega32U4 does.",
        "Unplug the board and plug it in again; check that it is an Arduino Micro.",
    ),
)


class FlashError(TfsatError):
    """Flashing failed; `code` names the step."""


def run_avrdude(computer: Computer, command: list[str], progress: Callable[[str, int], None]) -> None:
    """Runs avrdude.

    `progress` gets the name of the present bar and how many of its MARKS were added.

    Raises:
        FlashError: it could not be started, failed, or hung.
    """
    output: list[str] = []
    bars = Bars(progress)

    def heard(text: str) -> None:
        output.append(text)
        bars.feed(text)

    try:
        code = computer.run(command, heard, AVRDUDE_TIMEOUT_S)
    except OSError as error:
        raise _not_started(command, error, "avrdude-failed", _INTACT, "sequencer") from error
    if code == 0:
        return
    transcript = _format_command(command, output)
    # Without a complaint that is known, the command and its last lines must do.
    kind, what, cure = "avrdude-failed", f"avrdude failed with exit code {code}: {transcript}", _REPLUG
    if code is None:
        what = f"avrdude did not end within {AVRDUDE_TIMEOUT_S:g} s: {transcript}"
    else:
        for pattern, complaint_kind, reason, remedy in _COMPLAINTS:
            if pattern.search("".join(output)):
                kind, what, cure = complaint_kind, f"{reason} {what}", remedy
                break
    next_step = Advice(f"{cure}\nThen: ", AGAIN["sequencer"])
    raise FlashError(what=what, meaning=_INTACT, next_step=next_step, code=kind)


def run_teensy_loader(computer: Computer, command: list[str]) -> None:
    """Runs it. Raises FlashError: it could not be started, failed, or no bootloader appeared in time."""
    output: list[str] = []
    try:
        code = computer.run(command, output.append, TEENSY_TIMEOUT_S)
    except OSError as error:
        waits = "The board waits in its bootloader, with the image that it had."
        raise _not_started(command, error, "loader-failed", waits, "logger") from error
    if code == 0:
        return
    transcript = _format_command(command, output)
    # The loader waits for a bootloader without limit; it names HalfKay once it has found one.
    if code is None and "Found HalfKay" not in transcript:
        raise FlashError(
            what=f"No Teensy showed its bootloader within {TEENSY_TIMEOUT_S:g} s: {transcript}",
            meaning="Nothing was flashed.",
            next_step=Advice(
                AGAIN["logger"],
                "\nand press the button on the Teensy while it waits. On Linux first: "
                "sudo cp tools/udev/60-tfsat.rules /etc/udev/rules.d/",
            ),
            code="bootloader-not-seen",
        )
    ended = f"did not end within {TEENSY_TIMEOUT_S:g} s" if code is None else f"failed with exit code {code}"
    raise FlashError(
        what=f"{TEENSY_LOADER} {ended}: {transcript}",
        meaning="The board's image may be incomplete. Its bootloader cannot be damaged.",
        next_step=Advice("Press the button on the Teensy, then: ", AGAIN["logger"]),
        code="loader-failed",
    )


class Bars:
    """Follows avrdude's bars, `Writing | ####…# | 100% 0.5 s`, however the text is cut."""

    def __init__(self, progress: Callable[[str, int], None]) -> None:
        self._progress = progress
        self._tail = ""
        self._bar: str | None = None
        self._marks = 0

    def feed(self, text: str) -> None:
        """Takes avrdude's next output."""
        for character in text:
            if self._bar is not None and character == "#" and self._marks < MARKS:
                # At most a full bar of marks; any further # is ordinary text.
                self._marks += 1
                self._progress(self._bar, 1)
                continue
            # The name of the next bar may come in pieces: keep just enough to recognize it.
            self._tail = (self._tail + character)[-20:]
            match = _BAR.search(self._tail)
            if match:
                self._bar, self._marks, self._tail = match[1].lower(), 0, ""
                self._progress(self._bar, 0)


def _format_command(command: list[str], output: list[str]) -> str:
    """Format the command line and the last lines of its output."""
    lines = [line for line in "".join(output).splitlines() if line.strip()][-_LAST_LINES:]
    return "\n".join([shlex.join(command), *(lines or ["It printed nothing."])])


def _not_started(command: list[str], error: OSError, code: str, meaning: str, board: str) -> FlashError:
    return FlashError(
        what=f"{command[0]} cannot be started: {error.strerror or error}.",
        meaning=meaning,
        next_step=Advice("Install it again, then: ", AGAIN[board]),
        code=code,
    )
