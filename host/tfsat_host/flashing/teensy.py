"""Teensy's images and PJRC's command line loader, teensy_loader_cli."""

from __future__ import annotations

import shlex
from pathlib import Path

from tfsat_host.flashing.avrdude import FlashError
from tfsat_host.flashing.image import Image, ImageError
from tfsat_host.flashing.intel_hex import read_hex
from tfsat_host.flashing.ports import Computer

PROGRAM = "teensy_loader_cli"
TIMEOUT_S = 60.0
"""Erasing and writing takes some 3 s; somebody may have to find the board's button."""
REBOOT_BAUDRATE = 134
"""A Teensy whose USB serial port is set to this starts its bootloader (Teensyduino, teensy4/usb.c)."""
AGAIN = "tfsat-host flash logger --force"

_FLASH_BASE = 0x6000_0000
_FLASH_BYTES = 7936 << 10
"""Of a Teensy 4.1, beside the bootloader's restore image (imxrt1062_t41.ld)."""
_FLASH_CONFIG = b"FCFB"
"""Every image for the i.MX RT begins with it (Reference Manual, FlexSPI NOR configuration block)."""
_UNTOUCHED = "The board was not touched."
_EXPORT = (
    "arduino-cli compile --fqbn teensy:avr:teensy41:usb=serial,speed=600 --output-dir build/logger-ide \\\n  "
)


def load_image(path: Path) -> Image:
    """Reads a Teensy 4.1's HEX; its CRC is the one that the board computes, gaps being erased flash.

    Raises:
        ImageError: no file, damaged, or of another board.
    """
    export = f"{_EXPORT}firmware/teensy_logger"
    try:
        data = read_hex(path, _FLASH_BASE, _FLASH_BYTES)
    except OSError as error:
        raise ImageError(
            what=f"{path}: {error.strerror or error}.",
            meaning=_UNTOUCHED,
            next_step=f"Correct --hex, or make the image:\n{export}",
        ) from error
    except ValueError as error:
        raise _no_image(f"{error}.", export) from error
    if not data.startswith(_FLASH_CONFIG):
        raise _no_image(f"{path} does not begin as an image for a Teensy 4.1 does.", export)
    return Image(path, data)


def _no_image(what: str, export: str) -> ImageError:
    meaning = f"This is no image for the logger, or it was damaged. {_UNTOUCHED}"
    return ImageError(what=what, meaning=meaning, next_step=f"Make it again:\n{export}")


def find_loader(computer: Computer) -> str:
    """The program's path. Raises FlashError with how to install it."""
    path = computer.find_program(PROGRAM)
    if path is None:
        raise FlashError(
            "loader-missing",
            what=f"{PROGRAM} is not installed, or not on the PATH.",
            meaning="Nothing was flashed: it is what writes to a Teensy. The board was not touched.",
            next_step="Debian, Ubuntu: sudo apt install teensy-loader-cli\nmacOS: brew install teensy_loader_cli\n"
            "Then the same command again; or upload the sketch by the Arduino IDE.",
        )
    return path


def command_line(program: str, hex_path: Path) -> list[str]:
    """Waits for a Teensy 4.1 in its bootloader, writes the image, and starts it."""
    return [program, "--mcu=TEENSY41", "-w", "-v", str(hex_path)]


def run_loader(computer: Computer, command: list[str]) -> None:
    """Runs it. Raises FlashError: it could not be started, failed, or no bootloader appeared in time."""
    said: list[str] = []
    try:
        code = computer.run(command, said.append, TIMEOUT_S)
    except OSError as error:
        raise FlashError(
            "loader-failed",
            what=f"{command[0]} cannot be started: {error.strerror or error}.",
            meaning="The board waits in its bootloader, with the image that it had.",
            next_step=f"Install it anew, then: {AGAIN}",
        ) from error
    if code == 0:
        return
    words = "\n".join("".join(said).split("\n")[-6:]).strip() or "It said nothing."
    shown = f"{shlex.join(command)}\n{words}"
    if code is None and "Found HalfKay" not in words:
        raise FlashError(
            "bootloader-not-seen",
            what=f"No Teensy showed its bootloader within {TIMEOUT_S:g} s: {shown}",
            meaning="Nothing was flashed.",
            next_step=f"{AGAIN}\nand press the button on the Teensy while it waits. On Linux first: "
            "sudo cp tools/udev/60-tfsat.rules /etc/udev/rules.d/",
        )
    ended = f"did not end within {TIMEOUT_S:g} s" if code is None else f"failed with exit code {code}"
    raise FlashError(
        "loader-failed",
        what=f"{PROGRAM} {ended}: {shown}",
        meaning="The board's image may be incomplete. Its bootloader cannot be damaged.",
        next_step=f"Press the button on the Teensy, then: {AGAIN}",
    )
