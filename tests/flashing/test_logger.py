"""`tfsat-host flash logger` with a replacement of PJRC's loader, and a Teensy at a pseudo-terminal."""

from __future__ import annotations

import json
import sys
import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import serial.tools.list_ports

from tests.devices.scripted import hello, reply
from tests.flashing.conftest import hex_text
from tests.flashing.desk import Pty
from tfsat_host.cli.main import main
from tfsat_host.protocol.enums import Board, LoggerState
from tfsat_host.protocol.framing import FrameReceiver
from tfsat_host.protocol.messages import HelloRequest, LoggerStatusReply

# FCFB opens the flash configuration block with which every image for the i.MX RT begins.
IMAGE = b"FCFB" + bytes(range(250)) * 4
CRC = f"{zlib.crc32(IMAGE):08x}"
LOADER = """#!{python}
import json, os, sys
with open({log!r}, "w") as log:
    json.dump(sys.argv[1:], log)
print(os.environ.get("FAKE_LOADER_SAYS", "Found HalfKay Bootloader"))
sys.exit(int(os.environ.get("FAKE_LOADER_EXIT", "0")))
"""


def teensy_hex(data: bytes) -> str:
    """Format data as Intel HEX with the extended linear address that a Teensy 4's images have."""
    return ":0200000460009A\n" + hex_text(data)


class Teensy:
    """A logger's sketch, and the computer's ports; the loader's log tells that it was flashed."""

    def __init__(self, log: Path) -> None:
        self.log = log
        self.runs = zlib.crc32(IMAGE)
        self.state = LoggerState.IDLE
        self.ram_holds_drop = 0
        self.plugged = True
        self._receiver = FrameReceiver()
        self.pty = Pty(self._answer)

    def _answer(self, data: bytes) -> bytes:
        response = b""
        for frame in self._receiver.feed(data):
            if frame.type == HelloRequest.TYPE:
                # The loader's log exists once the fake has run: from then on the board runs the new image.
                crc = self.runs if self.log.exists() else 0xBEFF00
                response += reply(frame, replace(hello(Board.LOGGER), image_crc=crc))
            else:
                empty = LoggerStatusReply.decode(bytes(LoggerStatusReply.SIZE))
                response += reply(frame, replace(empty, state=self.state, ram_holds_drop=self.ram_holds_drop))
        return response

    def comports(self) -> list[SimpleNamespace]:
        """Return the ports in place of pyserial's `comports`."""
        # In its bootloader a Teensy is a HID device and has no port; a flashed one is back.
        here = self.plugged or self.log.exists()
        teensy = SimpleNamespace(
            device=self.pty.name, vid=0x16C0, pid=0x0483, serial_number=None, description="Teensy"
        )
        return [teensy] if here else []


@pytest.fixture
def teensy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Teensy]:
    folder, log = tmp_path / "bin", tmp_path / "loader.json"
    folder.mkdir()
    program = folder / "teensy_loader_cli"
    program.write_text(LOADER.format(python=sys.executable, log=str(log)))
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(folder))
    board = Teensy(log)
    monkeypatch.setattr(serial.tools.list_ports, "comports", board.comports)
    yield board
    board.pty.close()


@pytest.fixture
def logger_hex(tmp_path: Path) -> Path:
    path = tmp_path / "teensy_logger.ino.hex"
    path.write_text(teensy_hex(IMAGE))
    return path


def flash(capsys: pytest.CaptureFixture[str], *arguments: object, expect: int = 0) -> Any:
    capsys.readouterr()
    assert main(["flash", "logger", *map(str, arguments), "--json"]) == expect
    return json.loads(capsys.readouterr().out)


def test_the_loader_writes_and_the_board_says_what_it_runs(
    teensy: Teensy, logger_hex: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result = flash(capsys, "--hex", logger_hex)
    assert json.loads(teensy.log.read_text()) == ["--mcu=TEENSY41", "-w", "-v", str(logger_hex)]
    assert (result["flashed"], result["image_crc"], result["image_bytes"]) == (True, CRC, len(IMAGE))
    assert result["before"]["image_crc"] == "00beff00"
    assert result["device"]["image_crc"] == CRC
    # The second time it runs the image already.
    error = flash(capsys, "--hex", logger_hex, expect=4)["error"]
    assert error["code"] == "already-running"


def test_a_dry_run_touches_nothing(
    teensy: Teensy, logger_hex: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert flash(capsys, "--hex", logger_hex, "--dry-run")["flashed"] is False
    assert not teensy.log.exists()


def test_a_board_that_runs_something_else_is_no_success(
    teensy: Teensy, logger_hex: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # Another Teensy took the image, or the writing failed: the CRC that the board computes tells.
    teensy.runs = 0x12345678
    error = flash(capsys, "--hex", logger_hex, expect=1)["error"]
    assert error["code"] == "other-image"
    assert "12345678" in error["what"] and CRC in error["what"]


def test_nothing_is_flashed_over_a_recording_or_a_drop(
    teensy: Teensy, logger_hex: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    teensy.state = LoggerState.RECORDING
    error = flash(capsys, "--hex", logger_hex, "--force", expect=4)["error"]
    assert error["code"] == "recording" and "record stop" in error["next_step"]
    # The card failed: the RAM has the only copy of the drop, and flashing erases it.
    teensy.state, teensy.ram_holds_drop = LoggerState.FAILED, 1
    error = flash(capsys, "--hex", logger_hex, "--force", expect=4)["error"]
    assert error["code"] == "ram-holds-drop"
    assert not teensy.log.exists()


def test_a_missing_loader_is_a_hint(
    teensy: Teensy, logger_hex: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    error = flash(capsys, "--hex", logger_hex, expect=1)["error"]
    assert error["code"] == "loader-missing"
    assert "apt install teensy-loader-cli" in error["next_step"]
    assert "brew install teensy_loader_cli" in error["next_step"]


def test_a_loader_that_fails_tells_how_to_go_on(
    teensy: Teensy, logger_hex: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAKE_LOADER_EXIT", "1")
    monkeypatch.setenv("FAKE_LOADER_SAYS", "error writing to Teensy")
    error = flash(capsys, "--hex", logger_hex, expect=1)["error"]
    assert error["code"] == "loader-failed" and "error writing to Teensy" in error["what"]
    assert f"tfsat-host flash logger --force --hex {logger_hex}" in error["next_step"]


def test_a_teensy_in_its_bootloader_has_no_port_and_is_flashed_with_force(
    teensy: Teensy, logger_hex: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    teensy.plugged = False
    # Without --force a missing port is an error: the logger may simply be unplugged.
    flash(capsys, "--hex", logger_hex, expect=1)
    assert flash(capsys, "--hex", logger_hex, "--force", "--yes")["device"]["image_crc"] == CRC


@pytest.mark.parametrize(
    ("text", "words"),
    [
        # From address 0, as an AVR's; without FCFB; without its last record.
        (hex_text(IMAGE), "beyond 7936 KiB from 0x60000000 on"),
        (teensy_hex(b"nothing" * 9), "does not begin as an image for a Teensy 4.1"),
        (teensy_hex(IMAGE)[:-12], "cut short"),
    ],
)
def test_other_images_are_refused(
    text: str, words: str, teensy: Teensy, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "other.hex"
    path.write_text(text)
    error = flash(capsys, "--hex", path, expect=1)["error"]
    assert error["code"] == "image" and words in error["what"]
    assert not teensy.log.exists()
