"""Finding a board's port, opening it, and telling the port problems apart."""

from __future__ import annotations

import errno
import io
import json
import os
import pty
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NoReturn

import pytest
import serial

from tests.cli.process import RunCli
from tfsat_host.cli import ports
from tfsat_host.cli.boards import open_port
from tfsat_host.cli.main import main
from tfsat_host.devices.serial_ports import (
    BOARDS,
    BoardName,
    PortError,
    PortInfo,
    PortProblem,
    find_port,
    identify,
    open_error,
    open_serial,
)
from tfsat_host.present.output import Output

MICRO = PortInfo("/dev/ttyACM0", 0x2341, 0x8037, "HIDPC", "Arduino Micro")
MICRO_2 = PortInfo("/dev/ttyACM3", 0x2A03, 0x8037)
BOOTLOADER = PortInfo("/dev/ttyACM1", 0x2341, 0x0037)
TEENSY = PortInfo("/dev/ttyACM2", 0x16C0, 0x0483, "1234", "USB Serial")
OTHER = PortInfo("/dev/ttyS0", description="n/a")


def _list(*ports: PortInfo) -> Callable[[], list[PortInfo]]:
    return lambda: list(ports)


def _must_not_scan() -> NoReturn:
    raise AssertionError("an explicit port must not scan others")


def _problem(board: BoardName, *ports: PortInfo) -> PortError:
    with pytest.raises(PortError) as caught:
        find_port(board, environ={}, list_ports=_list(*ports))
    return caught.value


def test_the_option_beats_the_environment_and_scans_nothing() -> None:
    environ = {"TFSAT_SEQUENCER_PORT": "/dev/b", "TFSAT_LOGGER_PORT": "/dev/c"}
    assert find_port("sequencer", "/dev/a", environ, _must_not_scan) == "/dev/a"
    assert find_port("sequencer", None, environ, _must_not_scan) == "/dev/b"
    assert find_port("logger", None, environ, _must_not_scan) == "/dev/c"


def test_an_empty_variable_names_no_port() -> None:
    assert find_port("sequencer", None, {"TFSAT_SEQUENCER_PORT": ""}, _list(MICRO)) == MICRO.device


def test_each_board_is_found_among_others() -> None:
    everything = _list(OTHER, TEENSY, BOOTLOADER, MICRO)
    assert find_port("sequencer", environ={}, list_ports=everything) == MICRO.device
    assert find_port("logger", environ={}, list_ports=everything) == TEENSY.device


EMULATED = [PortInfo(f"/robot/{board}", description="emulated robot", emulated=board) for board in BOARDS]


def test_a_served_robot_is_found_while_no_board_is_plugged_in() -> None:
    assert find_port("logger", environ={}, list_ports=_list(OTHER, *EMULATED)) == "/robot/logger"
    beside_it = {"TFSAT_SEQUENCER_PORT": "/robot/sequencer"}
    assert find_port("logger", None, beside_it, _list(*EMULATED)) == "/robot/logger"


@pytest.mark.parametrize("plugged_in", [MICRO, BOOTLOADER])
def test_a_served_robot_stands_in_for_no_board_beside_a_real_one(plugged_in: PortInfo) -> None:
    """Arming asks the logger whether it records: the emulated one's answer would be about no drop."""
    error = _problem("logger", plugged_in, *EMULATED)
    assert error.code == PortProblem.NONE_FOUND
    assert "/robot/logger" in error.what


def test_a_served_robot_stands_in_for_no_board_beside_one_that_the_environment_names() -> None:
    with pytest.raises(PortError) as caught:
        find_port("logger", None, {"TFSAT_SEQUENCER_PORT": "/dev/serial0"}, _list(*EMULATED))
    assert caught.value.code == PortProblem.NONE_FOUND


def test_several_candidates_are_listed_and_none_is_chosen() -> None:
    error = _problem("sequencer", MICRO, MICRO_2)
    assert error.code == PortProblem.AMBIGUOUS
    assert MICRO.device in error.what
    assert MICRO_2.device in error.what
    assert "--port" in error.next_step


def test_a_bootloader_is_recognised() -> None:
    error = _problem("sequencer", BOOTLOADER, TEENSY)
    assert error.code == PortProblem.BOOTLOADER
    assert BOOTLOADER.device in error.what


def test_nothing_found_says_what_to_plug_in_and_what_else_is_there() -> None:
    error = _problem("logger", OTHER, MICRO)
    assert error.code == PortProblem.NONE_FOUND
    assert "Teensy" in error.next_step
    for words in ("--port", "TFSAT_LOGGER_PORT"):
        assert words in error.next_step
    assert OTHER.device in error.what
    assert "(sequencer" in error.what


def test_a_port_with_half_an_id_is_nobody() -> None:
    assert identify(PortInfo("/dev/x", vid=0x2341)) is None


@pytest.fixture
def terminal() -> Iterator[tuple[int, str]]:
    master, slave = pty.openpty()
    path = os.ttyname(slave)
    os.close(slave)
    yield master, path
    os.close(master)


def test_a_pseudo_terminal_opens_and_carries_bytes(terminal: tuple[int, str]) -> None:
    master, path = terminal
    with open_serial(path) as port:
        port.write(b"\x00\x03\x11\xff")
        assert os.read(master, 16) == b"\x00\x03\x11\xff"
        assert port.write_timeout is not None
        assert port.timeout is not None


def test_a_port_is_opened_for_one_program_alone(terminal: tuple[int, str]) -> None:
    with open_serial(terminal[1]), pytest.raises(PortError) as caught:
        open_serial(terminal[1])
    assert caught.value.code == PortProblem.BUSY


def test_what_is_no_port(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.touch()
    cases = {
        tmp_path / "none": "missing",
        file / "below": "missing",
        tmp_path: "no-serial-port",
        file: "no-serial-port",
    }
    for path, code in cases.items():
        with pytest.raises(PortError) as caught:
            open_serial(str(path))
        assert caught.value.code == code
        assert str(path) in caught.value.what


def test_not_permitted_names_the_group_and_the_rule(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_args: object, **_options: object) -> NoReturn:
        raise serial.SerialException(errno.EACCES, "could not open port: Permission denied")

    monkeypatch.setattr(serial, "Serial", refuse)
    with pytest.raises(PortError) as caught:
        open_serial("/dev/ttyACM0")
    assert caught.value.code == PortProblem.NOT_PERMITTED
    assert "dialout" in caught.value.next_step
    assert "udev" in caught.value.next_step


def test_the_port_problems_have_different_cures() -> None:
    numbers = (errno.ENOENT, errno.EBUSY, errno.EACCES, errno.EISDIR, errno.EIO)
    errors = [open_error("/dev/x", number, "words", platform="linux") for number in numbers]
    assert len({error.next_step for error in errors}) == len(numbers)
    assert "words" in errors[-1].what


@pytest.mark.parametrize(
    ("text", "code"), [("FileNotFoundError(2, …)", "missing"), ("PermissionError(13, …)", "busy")]
)
def test_windows_gives_words_instead_of_numbers(text: str, code: str) -> None:
    assert open_error("COM3", None, f"could not open port 'COM3': {text}", platform="win32").code == code


def test_ports_for_people(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(ports, "system_ports", _list(TEENSY, MICRO, OTHER, BOOTLOADER))
    assert main(["ports"]) == 0
    rows = [line for line in capsys.readouterr().out.splitlines() if "/dev/" in line]
    assert [row.split()[0] for row in rows] == sorted(
        port.device for port in (TEENSY, MICRO, OTHER, BOOTLOADER)
    )
    assert "sequencer" in rows[0]
    assert "2341:8037" in rows[0]
    assert "sequencer (bootloader)" in rows[1]
    assert "logger" in rows[2]


def test_ports_in_json(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(ports, "system_ports", _list(MICRO))
    assert main(["ports", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "ports": [
            {
                "port": "/dev/ttyACM0",
                "board": "sequencer",
                "mode": "sketch",
                "vid": 0x2341,
                "pid": 0x8037,
                "serial_number": "HIDPC",
                "description": "Arduino Micro",
            }
        ]
    }


def test_no_ports_is_a_result_with_advice(tfsat_host: RunCli) -> None:
    assert "Plug in" in tfsat_host("ports", without_ports=True).stdout
    assert tfsat_host.json("ports", without_ports=True) == {"ports": []}


def test_a_missing_port_is_said_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wait for a port only where an emulated robot is about to serve it."""

    def refuse_to_wait(_seconds: float) -> None:
        raise AssertionError("waited")

    monkeypatch.setattr("tfsat_host.cli.boards.time.sleep", refuse_to_wait)
    notes = io.StringIO()
    with pytest.raises(PortError) as caught:
        open_port("sequencer", str(tmp_path / "nope"), Output(stderr=notes))
    assert caught.value.code == PortProblem.MISSING and notes.getvalue() == ""
