"""Which HEX is flashed, and which is not."""

from __future__ import annotations

import os
import zlib
from pathlib import Path

import pytest

from tests.flashing.conftest import hex_text
from tfsat_host.flashing.image import FLASH_BYTES, HEX, ImageError, default_hex, load_image
from tfsat_host.flashing.loader import Bars

DATA = bytes(range(100))
END = ":00000001FF\n"


def write_file(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def test_the_crc_is_that_of_the_data(tmp_path: Path) -> None:
    image = load_image(write_file(tmp_path / "a.hex", hex_text(DATA)))
    assert image.data == DATA
    assert image.crc == f"{zlib.crc32(DATA):08x}"


def test_gaps_are_erased_flash(tmp_path: Path) -> None:
    # One byte at 0 and one at 4; type 5 is a start address, which AVR images may have and nothing needs.
    text = ":0100000011EE\n:0100040022D9\n:0400000500000000F7\n" + END
    assert load_image(write_file(tmp_path / "a.hex", text)).data == b"\x11\xff\xff\xff\x22"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("hello\n", "a.hex:1: not an Intel HEX record"),
        # The right checksum is EE.
        (":0100000011EF\n" + END, "a.hex:1: damaged Intel HEX record"),
        # Too short for an address, a type and a checksum.
        (":00\n" + END, "a.hex:1: damaged"),
        (hex_text(DATA).removesuffix(END), "cut short"),
        # The Teensy's flash begins at 0x60000000: its image must not reach the Micro.
        (":020000046000" + "9A\n:0100000000FF\n" + END, "beyond 64 KiB"),
        # Types end at 5.
        (":00000007F9\n" + END, "unknown Intel HEX record"),
        (END, "holds no data"),
        ("", "cut short"),
        # One byte into the 4 KiB of the bootloader.
        (hex_text(bytes(FLASH_BYTES + 1)), "28673 bytes; the sequencer has 28672"),
    ],
)
def test_what_is_no_image_for_the_sequencer(tmp_path: Path, text: str, reason: str) -> None:
    with pytest.raises(ImageError, match=reason) as caught:
        load_image(write_file(tmp_path / "a.hex", text))
    assert "not touched" in caught.value.meaning


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(ImageError, match="No such file"):
        load_image(tmp_path / "none.hex")


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Build a checkout whose built image is newer than its sources."""
    sources = tmp_path / "firmware" / "arduino_sequencer"
    (tmp_path / HEX).parent.mkdir(parents=True)
    sources.mkdir(parents=True)
    # Times far apart: a file system's resolution does not decide.
    os.utime(write_file(sources / "arduino_sequencer.ino", ""), (1000, 1000))
    os.utime(write_file(tmp_path / HEX, ""), (2000, 2000))
    return tmp_path


def test_the_default_is_what_make_firmware_built(checkout: Path) -> None:
    assert default_hex(checkout / "host" / "tfsat_host") == checkout / HEX


def test_an_image_older_than_its_sources_is_not_the_default(checkout: Path) -> None:
    os.utime(write_file(checkout / "firmware" / "arduino_sequencer" / "x.cpp", ""), (3000, 3000))
    with pytest.raises(ImageError, match=r"is older than firmware/arduino_sequencer/x\.cpp") as caught:
        default_hex(checkout / "host" / "tfsat_host")
    assert "make firmware" in caught.value.next_step


def test_an_image_that_was_not_built_is_refused(checkout: Path) -> None:
    (checkout / HEX).unlink()
    with pytest.raises(ImageError, match="was not built yet"):
        default_hex(checkout / "host" / "tfsat_host")


def test_an_installed_package_has_no_image(tmp_path: Path) -> None:
    with pytest.raises(ImageError, match="not a checkout") as caught:
        default_hex(tmp_path / "lib" / "tfsat_host")
    assert "tfsat-host flash sequencer --hex" in caught.value.next_step


# Character by character, in the middle of words, and all at once.
@pytest.mark.parametrize("cut", [1, 3, 1000])
def test_bars_are_followed_however_they_are_cut(cut: int) -> None:
    # 50 marks are a full bar; a # after it is text.
    text = "\nWriting | " + "#" * 50 + " | 100% 0.5 s\n\nReading | " + "#" * 50 + " | 100% 0.1 s\n#done#"
    updates: list[tuple[str, int]] = []
    bars = Bars(lambda bar, marks: updates.append((bar, marks)))
    for start in range(0, len(text), cut):
        bars.feed(text[start : start + cut])
    assert updates == [("writing", 0), *[("writing", 1)] * 50, ("reading", 0), *[("reading", 1)] * 50]
