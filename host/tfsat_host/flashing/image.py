"""The image that is to be flashed: which file, and whether it is one for the sequencer."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path

from tfsat_host.errors import TfsatError
from tfsat_host.flashing.intel_hex import read_hex

FLASH_BYTES = 28_672
"""ATmega32U4: 32 KiB less the bootloader's 4 KiB."""
HEX = Path("build", "sequencer", "arduino_sequencer.hex")
SKETCH = Path("firmware", "arduino_sequencer")
PACKAGE = Path(__file__).resolve().parents[1]
_SOURCES = (".ino", ".h", ".cpp", ".c")
_UNTOUCHED = "The board was not touched."


class ImageError(TfsatError):
    """There is no image, or none that may be flashed."""

    code = "image"


@dataclass(frozen=True, slots=True)
class Image:
    """What would be in the flash.

    Attributes:
        path: The HEX file.
        data: From address 0 to the last byte.
    """

    path: Path
    data: bytes

    @property
    def crc(self) -> str:
        """CRC-32/ISO-HDLC, 8 hexadecimal digits, as the board computes it over itself."""
        return f"{zlib.crc32(self.data):08x}"


def load_image(path: Path) -> Image:
    """Reads a HEX. Raises ImageError: no file, damaged, empty, or larger than the board's flash."""
    try:
        data = read_hex(path)
    except OSError as error:
        raise ImageError(
            what=f"{path}: {error.strerror or error}.", meaning=_UNTOUCHED, next_step="Correct --hex."
        ) from error
    except ValueError as error:
        raise ImageError(
            what=f"{error}.",
            meaning=f"This is no image for the sequencer, or it was damaged. {_UNTOUCHED}",
            next_step="Build it again: make firmware",
        ) from error
    if not data:
        raise ImageError(
            what=f"{path} holds no data.", meaning=_UNTOUCHED, next_step="Build it again: make firmware"
        )
    if len(data) > FLASH_BYTES:
        raise ImageError(
            what=f"{path} takes {len(data)} bytes; the sequencer has {FLASH_BYTES} beside its bootloader.",
            meaning=f"It holds a bootloader too, or is of another board. {_UNTOUCHED}",
            next_step="The Arduino IDE exports two files: take the one without with_bootloader in its name.",
        )
    return Image(path, data)


def default_hex(package: Path = PACKAGE) -> Path:
    """The HEX that `make firmware` has built in the checkout of this program.

    Args:
        package: The folder of `tfsat_host`.

    Raises:
        ImageError: there is no checkout, nothing was built, or it is older than its sources.
    """
    root = package.parents[1]
    if not (root / SKETCH / "arduino_sequencer.ino").is_file():
        raise ImageError(
            what="This installation of tfsat-host has no firmware image: it is not a checkout of the repository.",
            meaning=_UNTOUCHED,
            next_step="In a checkout of the same version type make firmware, then give its image here:\n"
            f"tfsat-host flash sequencer --hex {HEX.as_posix()}",
        )
    path = root / HEX
    if not path.is_file():
        raise ImageError(
            what=f"The sequencer's image {path} was not built yet.",
            meaning=_UNTOUCHED,
            next_step="make firmware, then the same command again; or name another image with --hex FILE.",
        )
    built_s = path.stat().st_mtime
    newer = [
        source
        for source in sorted((root / SKETCH).rglob("*"))
        if source.suffix in _SOURCES and source.stat().st_mtime > built_s
    ]
    if newer:
        raise ImageError(
            what=f"The sequencer's image {path} is older than {newer[0].relative_to(root).as_posix()}.",
            meaning=f"It would not do what its sources say. {_UNTOUCHED}",
            next_step="make firmware, then the same command again; or name this image with --hex to mean it.",
        )
    return path
