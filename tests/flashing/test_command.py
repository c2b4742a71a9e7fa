"""`tfsat-host flash sequencer` with the real avrdude, or one that records, and a board at pseudo-terminals."""

from __future__ import annotations

import io
import json
import sys
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.cli.process import RunCli
from tests.devices.scripted import hello
from tests.flashing.desk import Desk
from tfsat_host.cli.main import main
from tfsat_host.protocol.enums import Board, SequencerState
from tfsat_host.protocol.messages import DisarmRequest

# 1000 bytes: the last page of 128 is not full, so its padding must not count for the CRC.
IMAGE = bytes(range(250)) * 4
CRC = f"{zlib.crc32(IMAGE):08x}"


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def flash(*arguments: object, expect: int = 0) -> int:
    assert main(["flash", "sequencer", *map(str, arguments)]) == expect
    return expect


def flash_json(capsys: pytest.CaptureFixture[str], *arguments: object, expect: int = 0) -> Any:
    capsys.readouterr()
    flash(*arguments, "--json", expect=expect)
    return json.loads(capsys.readouterr().out)


def test_the_real_avrdude_writes_what_the_hex_holds(
    desk: Desk, image: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.image_bytes = len(IMAGE)
    flash("--hex", image)
    output = capsys.readouterr()
    assert desk.written == IMAGE
    # The port of the sketch goes, the bootloader's comes, and the sketch's is back at the end.
    assert (
        desk.listed_devices[0] == "sketch"
        and "bootloader" in desk.listed_devices
        and desk.listed_devices[-1] == "sketch"
    )
    assert f"runs image {CRC}" in output.out
    for words in (
        "Waking the bootloader",
        "Writing 1000 bytes to",
        "avrdude: writing",
        "Waiting for the new",
    ):
        assert words in output.err


def test_the_real_avrdude_notices_what_was_not_kept(
    desk: Desk, image: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # Written, but read back with a wrong bit: only verification can tell.
    desk.bootloader.damage = True
    error = flash_json(capsys, "--hex", image, expect=1)["error"]
    assert error["code"] == "verify-failed"
    assert "What was read back from the board is not what was written" in error["what"]
    assert "bootloader is intact" in error["meaning"]
    assert f"tfsat-host flash sequencer --force --hex {image}" in error["next_step"]


def test_avrdude_is_called_as_the_arduino_ide_calls_it(
    desk: Desk, image: Path, fake_avrdude: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    boot = desk.bootloader_pty.name
    plan = flash_json(capsys, "--hex", image, "--dry-run")
    assert not desk.sketch_pty.touched and not fake_avrdude.exists()
    assert (plan["dry_run"], plan["flashed"], plan["image_crc"], plan["image_bytes"]) == (
        True, False, CRC, 1000,
    )  # fmt: skip
    assert plan["before"]["image_crc"] == "00c0ffee"
    # The fake writes nothing: the board still reports another CRC, and success must not be claimed.
    desk.sketch.identity = replace(hello(), image_crc=int(CRC, 16) ^ 1)
    error = flash_json(capsys, "--hex", image, expect=1)["error"]
    assert json.loads(fake_avrdude.read_text()) == [
        # boards.txt of the Arduino IDE, micro: avr109 at 57600 baud; -D: no chip erase.
        "-p", "atmega32u4", "-c", "avr109", "-P", boot, "-b", "57600", "-D", "-U", f"flash:w:{image}:i",
    ]  # fmt: skip
    assert plan["command"][1:] == [
        word.replace(boot, "BOOTLOADER_PORT") for word in json.loads(fake_avrdude.read_text())
    ]
    assert error["code"] == "other-image"


def test_the_same_image_is_refused_unless_forced(
    desk: Desk, image: Path, fake_avrdude: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.sketch.identity = replace(hello(), image_crc=int(CRC, 16))
    error = flash_json(capsys, "--hex", image, expect=4)["error"]
    assert error["code"] == "already-running"
    assert CRC in error["what"]
    # A touch alone ends the running sketch, and with it the servo pulses.
    assert not desk.sketch_pty.touched and not fake_avrdude.exists()
    result = flash_json(capsys, "--hex", image, "--force")
    assert result["flashed"] is True
    assert result["device"]["image_crc"] == CRC
    assert fake_avrdude.exists()


@pytest.mark.parametrize("state", [state for state in SequencerState if state != SequencerState.SAFE])
def test_a_board_that_is_not_safe_is_never_flashed(
    desk: Desk, image: Path, fake_avrdude: Path, capsys: pytest.CaptureFixture[str], state: SequencerState
) -> None:
    desk.sketch.state = state
    # Not even --force: in any other state servos may hold joints, and flashing lets them go.
    error = flash_json(capsys, "--hex", image, "--force", "--yes", expect=4)["error"]
    assert error["code"] == "not-safe"
    assert f"is {state.name.lower()}; it is flashed only while it is safe" in error["what"]
    assert not desk.sketch_pty.touched and not fake_avrdude.exists()
    # Flashing never disarms by itself: a person decides to give up a drop that is ready.
    assert DisarmRequest.TYPE not in desk.sketch.requests
    port_arguments = ("--port", desk.sketch_pty.name)
    error = flash_json(capsys, "--hex", image, *port_arguments, expect=4)["error"]
    assert error["next_step"].startswith(f"tfsat-host disarm --port {desk.sketch_pty.name}, then")


def test_the_logger_is_never_flashed(
    desk: Desk, image: Path, fake_avrdude: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # The logger behind the sequencer's USB ids: what HELLO says counts.
    desk.sketch.identity = hello(board=Board.LOGGER)
    error = flash_json(capsys, "--hex", image, "--force", "--yes", expect=1)["error"]
    assert error["code"] == "other-board"
    assert not desk.sketch_pty.touched and not fake_avrdude.exists()


def test_another_protocol_is_disarmed_after_a_question(
    desk: Desk, image: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    desk.image_bytes = len(IMAGE)
    desk.sketch.identity = hello(protocol_hash=bytes(8))
    # Armed, which this host cannot read: only HELLO and DISARM are the same in every protocol.
    desk.sketch.state = SequencerState.ARMED
    monkeypatch.setattr(sys, "stdin", Terminal("no\n"))
    flash("--hex", image, expect=4)
    assert "speaks another protocol" in capsys.readouterr().err
    assert desk.sketch.state == SequencerState.ARMED and not desk.sketch_pty.touched
    monkeypatch.setattr(sys, "stdin", Terminal("y\n"))
    flash("--hex", image)
    assert DisarmRequest.TYPE in desk.sketch.requests
    assert desk.written == IMAGE


def test_a_silent_board_needs_force_and_an_answer(
    desk: Desk, image: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    # Each attempt is shortened; their number is not.
    monkeypatch.setattr("tfsat_host.devices.client.ATTEMPT_TIMEOUT_S", 0.05)
    desk.image_bytes = len(IMAGE)
    desk.sketch.silent = True
    error = flash_json(capsys, "--hex", image, "--yes", expect=4)["error"]
    assert error["code"] == "silent" and "add --force" in error["next_step"]
    # --force without a terminal to answer at and without --yes.
    flash("--hex", image, "--force", expect=2)
    assert not desk.sketch_pty.touched
    monkeypatch.setattr(sys, "stdin", Terminal("yes\n"))
    flash("--hex", image, "--force")
    assert "does not answer; its state is not known" in capsys.readouterr().err
    assert desk.written == IMAGE


def test_a_board_in_its_bootloader_is_written_without_a_touch(
    desk: Desk, image: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    desk.image_bytes = len(IMAGE)
    # A bootloader runs no sketch: nothing tells which board it is.
    desk.waits = True
    error = flash_json(capsys, "--hex", image, "--yes", expect=4)["error"]
    assert error["code"] == "silent" and "waits in its bootloader" in error["what"]
    result = flash_json(capsys, "--hex", image, "--yes", "--force")
    assert not desk.sketch_pty.touched
    assert (result["before"], result["device"]["port"]) == (None, desk.sketch_pty.name)
    assert desk.written == IMAGE


@pytest.mark.parametrize(
    ("says", "reason"),
    [
        ("avrdude OS error: cannot open port /dev/ttyACM0: Permission denied", "not permitted to open"),
        ("avrdude OS error: cannot open port /dev/ttyACM0: No such file", "could not be opened"),
        ("avrdude: butterfly_recv(): programmer is not responding", "did not answer"),
        # No known complaint: the exit code and the text must do.
        ("something new", "avrdude failed with exit code 3"),
    ],
)
def test_what_avrdude_complains_of_is_explained(
    desk: Desk,
    image: Path,
    fake_avrdude: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    says: str,
    reason: str,
) -> None:
    monkeypatch.setenv("FAKE_AVRDUDE_SAYS", says)
    monkeypatch.setenv("FAKE_AVRDUDE_EXIT", "3")
    error = flash_json(capsys, "--hex", image, expect=1)["error"]
    assert error["code"] == "avrdude-failed"
    assert reason in error["what"] and says in error["what"]
    assert "flash sequencer" in error["next_step"]


def test_without_avrdude_the_board_is_not_touched(
    desk: Desk, image: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "")
    error = flash_json(capsys, "--hex", image, expect=1)["error"]
    assert error["code"] == "avrdude-missing"
    for system in ("apt install avrdude", "brew install avrdude", "winget install"):
        assert system in error["next_step"]
    # The loader is looked for first: the board is not even asked.
    assert desk.sketch.requests == []


def test_emulated_boards_are_not_flashed(
    desk: Desk, image: Path, capsys: pytest.CaptureFixture[str], tfsat_host: RunCli
) -> None:
    # CRC 0 is the core on a computer, which has no flash.
    desk.sketch.identity = replace(hello(), image_crc=0)
    error = flash_json(capsys, "--hex", image, "--force", "--yes", expect=4)["error"]
    assert error["code"] == "emulated"
    assert not desk.sketch_pty.touched
    refused = tfsat_host("flash", "sequencer", "--emulated", expect=4)
    assert "tfsat-host emulate --sequencer avr" in refused.stderr
