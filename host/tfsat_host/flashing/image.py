"""The image that is to be flashed: Intel HEX, which file, and whether it is one for the board.

`tools/firmware/image_report.py` reads with this too, by a plain interpreter: nothing but Python is needed here.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path

from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep

FLASH_BYTES = 28_672
"""ATmega32U4: 32 KiB less the bootloader's 4 KiB."""
HEX = Path("build", "sequencer", "arduino_sequencer.hex")
SKETCH = Path("firmware", "arduino_sequencer")
PACKAGE = Path(__file__).resolve().parents[1]
_SOURCES = (".ino", ".h", ".cpp", ".c")
_UNTOUCHED = "The board was not touched."
_BUILD = "Build it again: make firmware"

_TEENSY_FLASH_BASE = 0x6000_0000
_TEENSY_FLASH_BYTES = 7936 << 10
"""Of a Teensy 4.1, without the bootloader's restore image (imxrt1062_t41.ld)."""
_TEENSY_FLASH_CONFIG = b"FCFB"
"""Every image for the i.MX RT begins with it (Reference Manual, FlexSPI NOR configuration block)."""
_TEENSY_EXPORT = (
    "arduino-cli compile --fqbn teensy:avr:teensy41:usb=serial,speed=600 --output-dir build/logger-ide \\\n"
    "  firmware/teensy_logger"
)

_DATA, _END = 0, 1
_EXTENDED_SHIFTS = {2: 4, 4: 16}
"""Of the address that such a record gives to all that follow."""
_START_ADDRESSES = (3, 5)


class ImageError(TfsatError):
    """There is no image, or none that may be flashed."""

    code = "image"


@dataclass(frozen=True, slots=True)
class Image:
    """What would be in the flash.

    Attributes:
        path: The HEX file.
        data: From the flash's first address to the last byte.
    """

    path: Path
    data: bytes

    @property
    def crc(self) -> str:
        """CRC-32/ISO-HDLC, 8 hexadecimal digits, as the board computes it over itself; gaps are erased flash."""
        return f"{zlib.crc32(self.data):08x}"


def load_image(path: Path) -> Image:
    """Reads the sequencer's HEX. Raises ImageError: no file, damaged, empty, or larger than the board's flash."""
    data = _read(path, "sequencer", "Correct --hex.", _BUILD)
    if not data:
        raise ImageError(what=f"{path} holds no data.", meaning=_UNTOUCHED, next_step=_BUILD)
    if len(data) > FLASH_BYTES:
        raise ImageError(
            what=f"{path} takes {len(data)} bytes; the sequencer has {FLASH_BYTES} without its bootloader.",
            meaning=f"It holds a bootloader too, or is of another board. {_UNTOUCHED}",
            next_step="The Arduino IDE exports two files: take the one without with_bootloader in its name.",
        )
    return Image(path, data)


def load_teensy_image(path: Path) -> Image:
    """Reads a Teensy 4.1's HEX. Raises ImageError: no file, damaged, or of another board."""
    cure = f"Make it again:\n{_TEENSY_EXPORT}"
    missing = f"Correct --hex, or make the image:\n{_TEENSY_EXPORT}"
    data = _read(path, "logger", missing, cure, _TEENSY_FLASH_BASE, _TEENSY_FLASH_BYTES)
    if not data.startswith(_TEENSY_FLASH_CONFIG):
        raise _no_image(f"{path} does not begin as an image for a Teensy 4.1 does.", "logger", cure)
    return Image(path, data)


def default_hex(package: Path = PACKAGE) -> Path:
    """Return the path of the HEX that `make firmware` has built in the checkout of this program.

    Raises:
        ImageError: there is no checkout, nothing was built, or it is older than its sources.
    """
    root = package.parents[1]
    if not (root / SKETCH / "arduino_sequencer.ino").is_file():
        raise ImageError(
            what="This installation of tfsat-host has no firmware image: it is not a checkout of the repository.",
            meaning=_UNTOUCHED,
            next_step=Advice(
                "In a checkout of the same version type make firmware, then give its image here:\n",
                NextStep("flash sequencer", ("--hex", HEX.as_posix())),
            ),
        )
    path = root / HEX
    if not path.is_file():
        raise ImageError(
            what=f"The sequencer's image {path} was not built yet.",
            meaning=_UNTOUCHED,
            next_step="make firmware, then the same command again; or name another image with --hex FILE.",
        )
    # An image older than a source would not do what the checkout says.
    built_s = path.stat().st_mtime
    for source in sorted((root / SKETCH).rglob("*")):
        if source.suffix in _SOURCES and source.stat().st_mtime > built_s:
            raise ImageError(
                what=f"The sequencer's image {path} is older than {source.relative_to(root).as_posix()}.",
                meaning=f"It would not do what its sources say. {_UNTOUCHED}",
                next_step="make firmware, then the same command again; or name this image with --hex to mean it.",
            )
    return path


def _read(
    path: Path, board: str, missing: str, damaged: str, base: int = 0, most_bytes: int = 1 << 16
) -> bytes:
    """Read the HEX image of a board. Raises ImageError.

    `missing` and `damaged` are the next steps that the error gives for a missing or damaged file.
    """
    try:
        return read_hex(path, base, most_bytes)
    except OSError as error:
        what = f"{path}: {error.strerror or error}."
        raise ImageError(what=what, meaning=_UNTOUCHED, next_step=missing) from error
    except ValueError as error:
        raise _no_image(f"{error}.", board, damaged) from error


def _no_image(what: str, board: str, cure: str) -> ImageError:
    meaning = f"This is no image for the {board}, or it was damaged. {_UNTOUCHED}"
    return ImageError(what=what, meaning=meaning, next_step=cure)


def read_hex(path: Path, base: int = 0, most_bytes: int = 1 << 16) -> bytes:
    """Read an Intel HEX image, as objcopy and the Arduino IDE write it.

    The image starts at address `base`; gaps are 0xFF.

    Raises:
        ValueError: a record is damaged, unknown or not within `most_bytes` from `base` on, or the last one is
            missing.
        OSError: the file cannot be read.
    """
    image = bytearray()
    extended = 0
    for number, line in enumerate(path.read_text(encoding="ascii", errors="replace").split(), start=1):
        kind, address, data = _record(line, f"{path}:{number}")
        if kind == _END:
            return bytes(image)
        if kind == _DATA:
            # A record has 16 bits of its address; the last extended record has the rest.
            start = extended + address - base
            end = start + len(data)
            if start < 0 or end > most_bytes:
                span = f"{most_bytes >> 10} KiB" + (f" from 0x{base:08x} on" if base else "")
                raise ValueError(f"{path}:{number}: the image reaches beyond {span}")
            # Fill gaps as erased flash reads, so that the CRC is the one that the board computes.
            image.extend(b"\xff" * (end - len(image)))
            image[start:end] = data
        elif kind in _EXTENDED_SHIFTS:
            # Segment addresses are shifted by 4 bits, linear ones by 16.
            extended = int.from_bytes(data, "big") << _EXTENDED_SHIFTS[kind]
        elif kind not in _START_ADDRESSES:
            raise ValueError(f"{path}:{number}: unknown Intel HEX record")
    # Only the end record shows that the file is whole.
    raise ValueError(f"{path}: the file was cut short: it has no end record")


def _record(line: str, place: str) -> tuple[int, int, bytes]:
    """Kind, address and data."""
    try:
        record = bytes.fromhex(line.removeprefix(":"))
    except ValueError as error:
        raise ValueError(f"{place}: not an Intel HEX record") from error
    # Length, address, kind, data, checksum: all bytes sum to 0 modulo 256.
    if not line.startswith(":") or len(record) < 5 or len(record) != record[0] + 5 or sum(record) & 0xFF:
        raise ValueError(f"{place}: damaged Intel HEX record")
    return record[3], int.from_bytes(record[1:3], "big"), record[4:-1]
