"""`upload-servos` as a user has it: a file, a question, a board that keeps what it was told."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.arduino_sequencer.conftest import board, board_library, new_board
from tests.cli.board_on_pty import BoardOnPty
from tests.cli.process import RunCli
from tests.fixtures.sequencer.board import Board
from tests.fixtures.sequencer.cable import connect
from tfsat_host.servo_settings import FACTORY, format_settings, read_settings_file

__all__ = ["board", "board_library", "new_board"]

FILE = format_settings(FACTORY).replace("frame_ms = 20.0", "frame_ms = 10")


@pytest.fixture
def narrow(tfsat_host: RunCli) -> Path:
    """Write a robot file that allows joint 1 less than 59/70 needs."""
    path = tfsat_host.folder / "narrow.toml"
    path.write_text(FILE.replace("[0.0, 90.0]", "[0, 58.994]", 1))
    return path


def test_stored_shown_and_there_already(tfsat_host: RunCli) -> None:
    (tfsat_host.folder / "servos.toml").write_text(FILE.replace("zero_us = 1000", "zero_us = 990", 1))
    process = tfsat_host("upload-servos", "servos.toml", "--emulated", "--yes")
    assert "identical: sequencer firmware" in process.stdout
    for line, old, new in (("joint 1: pulse at 0 deg", "1000", "990"), ("pulse to pulse", "20", "10")):
        (row,) = [row for row in process.stdout.splitlines() if line in row]
        assert row.split()[-2:] == [old, new]
    again = tfsat_host.json("upload-servos", "servos.toml", "--emulated")  # asks nothing: nothing changes
    assert (again["written"], again["verified"], again["generation"]) == (False, True, 1)
    assert "already" in tfsat_host("upload-servos", "servos.toml", "--emulated").stdout
    settings = tfsat_host.json("upload-servos", "--show", "--emulated")
    assert (settings["origin"], settings["frame_ms"]) == ("uploaded", 10.0)
    assert settings["servos"][0] == {
        "joint": 1, "zero_us": 990, "us_per_deg": 11.111, "reversed": False, "limits_deg": [0.0, 90.0],
    }  # fmt: skip
    assert "uploaded settings" in tfsat_host("upload-servos", "--show", "--emulated").stdout
    status = tfsat_host.json("status", "--emulated")["sequencer"]["settings"]
    assert {key: settings[key] for key in status} == status

    back = tfsat_host.json("upload-servos", "--factory", "--emulated", "--yes")
    assert (back["written"], back["generation"], back["before"]["frame_ms"]) == (True, 2, 10.0)
    assert back["servos"][0]["zero_us"] == 1000


def test_what_is_on_the_board_goes_into_a_file_and_back(tfsat_host: RunCli, narrow: Path) -> None:
    tfsat_host("upload-servos", narrow, "--emulated", "--yes")
    tfsat_host("upload-servos", "--show", "--out", "copy.toml", "--emulated")
    copy = tfsat_host.folder / "copy.toml"
    assert read_settings_file(copy)[0] == read_settings_file(narrow)[0]
    assert tfsat_host.json("upload-servos", "copy.toml", "--emulated")["written"] is False
    copy.write_text("mine")
    refused = tfsat_host("upload-servos", "--show", "--out", "copy.toml", "--emulated", expect=2)
    assert "exists already" in refused.stderr
    assert copy.read_text() == "mine"
    tfsat_host("upload-servos", "--show", "--out", "copy.toml", "--force", "--emulated")
    assert read_settings_file(copy)[0] == read_settings_file(narrow)[0]


def test_rounding_and_a_maneuver_that_does_not_fit_are_said(tfsat_host: RunCli, narrow: Path) -> None:
    process = tfsat_host("upload-servos", narrow, "--emulated", "--yes")
    assert "Warning: joint 1: limits_deg was rounded from 58.994 to 58.99 deg: " in process.stderr
    assert "stroke 1 takes joint 1 to 59 deg, but its servo settings allow 0 to 58.99 deg" in process.stderr
    result = tfsat_host.json("upload-servos", narrow, "--emulated")
    assert result["maneuver_fits"] is False
    assert len(result["notices"]) == 1
    status = tfsat_host.json("status", "--emulated")["sequencer"]
    assert status["arm_refusal"]["code"] == "no_maneuver"  # the factory's, which is not flown

    error = tfsat_host.json("upload-sequence", 59, 70, "--emulated", expect=4)["error"]
    assert error["code"] == "settings_do_not_fit"
    assert error["what"].startswith("Stroke 1 takes joint 1 to 59 deg")
    assert "upload-servos --show --emulated" in error["next_step"]
    assert tfsat_host.json("status", "--emulated")["sequencer"]["maneuver"]["origin"] == "factory"
    assert tfsat_host.json("upload-sequence", "58.99", 70, "--emulated")["verified"] is True
    assert tfsat_host.json("status", "--emulated")["sequencer"]["arm_refusal"] is None
    narrower = tfsat_host.folder / "narrower.toml"
    narrower.write_text(FILE.replace("[0.0, 90.0]", "[0, 50]", 1))
    tfsat_host("upload-servos", narrower, "--emulated", "--yes")
    status = tfsat_host.json("status", "--emulated")["sequencer"]
    assert (status["arm_refusal"]["code"], status["arm_refusal"]["number"]) == ("settings_do_not_fit", 26)
    status_text = " ".join(tfsat_host("status", "--emulated").stdout.split())
    assert status_text.startswith(
        "BLOCKED: 1 item blocks a drop - Sequencer: The stored maneuver does not fit"
    )
    assert "(refusal 26, settings_do_not_fit)" in status_text


def test_a_dry_run_touches_no_board(tfsat_host: RunCli, narrow: Path) -> None:
    result = tfsat_host.json("upload-servos", narrow, "--dry-run", "--port", "/nonexistent")
    assert (result["verified"], result["device"], result["dry_run"]) == (False, None, True)
    assert result["servos"][0]["limits_deg"] == [0.0, 58.99]
    assert "nothing was sent" in tfsat_host("upload-servos", "--factory", "--dry-run").stdout


def test_a_bad_file_is_refused_before_a_port_is_opened(tfsat_host: RunCli) -> None:
    (tfsat_host.folder / "bad.toml").write_text(FILE.replace("[0.0, 90.0]", "[0.0, 91.0]", 1))
    error = tfsat_host.json("upload-servos", "bad.toml", "--port", "/nonexistent", expect=1)["error"]
    assert error["code"] == "joint-limits"
    assert error["what"].startswith("bad.toml:11: servo of joint 1, limits_deg: 0 to 91 deg")


@pytest.mark.parametrize(
    "args",
    [
        (),
        ("x.toml", "--factory"),
        ("x.toml", "--show"),
        ("--factory", "--show"),
        ("x.toml", "--out", "y.toml"),
        ("--show", "--dry-run"),
        ("",),
    ],
)
def test_usage(tfsat_host: RunCli, args: tuple[str, ...]) -> None:
    assert tfsat_host("upload-servos", *args, "--emulated", expect=2).stdout == ""


def _answer(args: tuple[str, ...], folder: Path, answer: bytes) -> subprocess.CompletedProcess[str]:
    """Runs the command with a terminal to ask on, where `answer` is typed."""
    master, slave = pty.openpty()
    os.write(master, answer)
    process = subprocess.run(
        [sys.executable, "-m", "tfsat_host", "upload-servos", *args],
        cwd=folder,
        stdin=slave,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    os.close(slave)
    os.close(master)
    return process


def test_it_asks_before_it_changes_anything(tfsat_host: RunCli, narrow: Path) -> None:
    args = (str(narrow), "--emulated")
    refused = _answer(args, tfsat_host.folder, b"no\n")
    assert refused.returncode == 4, refused.stderr
    assert "Store the new settings" in refused.stderr
    assert "keeps its settings" in refused.stderr
    assert tfsat_host.json("upload-servos", "--show", "--emulated")["origin"] == "factory"
    assert _answer(args, tfsat_host.folder, b"y\n").returncode == 0
    assert tfsat_host.json("upload-servos", "--show", "--emulated")["origin"] == "uploaded"
    assert "No terminal" in tfsat_host("upload-servos", "--factory", "--emulated", expect=2).stderr


def test_an_armed_board_refuses_before_anybody_is_asked(
    new_board: Callable[..., Board], tfsat_host: RunCli, narrow: Path
) -> None:
    board = new_board()
    connect(board).arm()
    with BoardOnPty(board) as served:
        error = tfsat_host.json("upload-servos", narrow, "--port", served.port, expect=4)["error"]
        assert error["code"] == "wrong_state"
        assert error["what"].startswith("The sequencer is armed;")
        assert error["next_step"].startswith(f"tfsat-host disarm --port {served.port}")
        tfsat_host("disarm", "--port", served.port)
        assert tfsat_host.json("upload-servos", narrow, "--yes", "--port", served.port)["written"] is True


def test_an_emulated_robot_of_an_earlier_release_is_told_how_to_go_on(tfsat_host: RunCli) -> None:
    """Explain how to go on to users of an earlier release's emulated robot.

    Its EEPROM is of layout 1: markers of one byte at 0 and 256.
    """
    image = bytearray([0xFF]) * 1024
    image[0] = image[256] = 0xA5
    eeprom = Path(os.environ["XDG_STATE_HOME"]) / "tfsat" / "emulated" / "sequencer.eeprom"
    eeprom.parent.mkdir(parents=True, exist_ok=True)
    eeprom.write_bytes(image)
    before = tfsat_host.json("status", "--emulated")["sequencer"]
    assert before["stores_refused"] == {"maneuver": "store_old_layout", "settings": "store_old_layout"}
    assert before["stores_damaged"] == {"maneuver": False, "settings": False}
    assert before["arm_refusal"]["code"] == "store_old_layout"
    assert "upload-servos --factory" in before["arm_refusal"]["next_step"]
    tfsat_host("upload-sequence", 59, 70, "--emulated")
    between = tfsat_host.json("status", "--emulated")["sequencer"]
    assert between["stores_refused"] == {"maneuver": "none", "settings": "store_old_layout"}
    tfsat_host("upload-servos", "--factory", "--yes", "--emulated")
    assert tfsat_host.json("status", "--emulated")["sequencer"]["arm_refusal"] is None
