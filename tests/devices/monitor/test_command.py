"""`tfsat-host monitor` next to a served robot: lines, JSON lines, a picture; one board or both; its end."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import signal
import struct
import subprocess
import sys
import termios
from collections.abc import Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from tests.cli.process import RunCli
from tests.emulated.served import TIMEOUT_S, Served
from tfsat_host.devices.board_errors import BoardRefusal
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.devices.transport import SerialTransport
from tfsat_host.present.monitor_view import UNCALIBRATED


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    monkeypatch.chdir(tmp_path)
    with Served() as process:
        yield process


@pytest.fixture
def both(robot: Served) -> dict[str, str]:
    return {
        "TFSAT_SEQUENCER_PORT": robot.announced["sequencer"],
        "TFSAT_LOGGER_PORT": robot.announced["logger"],
    }


class Monitor:
    """The command as a process that goes on; its JSON lines as they come."""

    def __init__(self, *options: str, environ: Mapping[str, str]) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tfsat_host", "monitor", "--json", *options],
            env={**os.environ, **environ},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def next(self) -> Any:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line, self.process.communicate()
        return json.loads(line)

    def until(self, board: str, key: str, value: object) -> Any:
        """Return the first line in which `board` reports `value` for `key`."""
        while True:
            line = self.next()
            if (line[board] or {}).get(key) == value:
                return line

    def interrupt(self) -> tuple[int, str]:
        self.process.send_signal(signal.SIGINT)
        _, error_text = self.process.communicate(timeout=TIMEOUT_S)
        assert "Traceback" not in error_text
        return self.process.returncode, error_text


def json_lines(text: str) -> list[Any]:
    return [json.loads(line) for line in text.splitlines()]


def test_both_boards_as_json_lines(robot: Served, both: dict[str, str], tfsat_host: RunCli) -> None:
    process = tfsat_host("monitor", "--for", "1.5", "--json", environ=both)
    lines = json_lines(process.stdout)
    assert len(lines) >= 4
    assert [line["t_s"] for line in lines] == sorted(line["t_s"] for line in lines)
    last = lines[-1]
    assert last["sequencer"]["state"] == "safe"
    assert last["sequencer"]["switches_closed"] == [True, True]
    assert last["logger"]["state"] == "idle"
    assert len(last["logger"]["bodies"]) == 4 and all(body["valid"] for body in last["logger"]["bodies"])
    assert [sensor["joint"] for sensor in last["logger"]["angle_sensors"]] == [1, 1, 2, 2, 3, 3]
    assert last["logger"]["measured_rate_hz"] == pytest.approx(280, rel=0.02)


def test_a_drop_is_seen_and_not_disturbed(robot: Served, both: dict[str, str], tfsat_host: RunCli) -> None:
    tfsat_host("upload-sequence", 59, 70, environ=both)
    tfsat_host("arm", "--yes", environ=both)
    monitor = Monitor(environ=both)
    monitor.until("sequencer", "state", "armed")
    robot.control("knock 1 20ms", "wait 100ms", "release 2", "wait 100ms", "seat", "wait 100ms", "drop")
    running = monitor.until("sequencer", "state", "running")["sequencer"]
    assert running["switches_closed"] == [False, False]
    final_line = monitor.until("sequencer", "state", "done")
    assert final_line["sequencer"]["strokes_started"] == 4
    assert final_line["sequencer"]["knocks"] == 2
    assert monitor.interrupt()[0] == 0


def test_rates_and_angles_follow_a_hand(robot: Served, both: dict[str, str]) -> None:
    robot.control("hold 3", "swing 2 40 2.0 20")
    monitor = Monitor("--port", both["TFSAT_LOGGER_PORT"], environ={})
    rates, angles = [], []
    for _ in range(15):
        line = monitor.next()
        assert line["sequencer"] is None
        rates.append(line["logger"]["bodies"][1]["rate_deg_s"][1])
        angles.append([sensor["joint_deg_uncalibrated"] for sensor in line["logger"]["angle_sensors"]])
    assert max(map(abs, rates)) > 40
    for sensor in (2, 3):
        angles_deg = [row[sensor] for row in angles]
        assert 30 < max(angles_deg) - min(angles_deg) < 50
    assert max(row[4] for row in angles) - min(row[4] for row in angles) < 2
    assert monitor.interrupt()[0] == 0


@pytest.mark.parametrize(("board", "other"), [("sequencer", "logger"), ("logger", "sequencer")])
def test_either_board_alone(robot: Served, tfsat_host: RunCli, board: str, other: str) -> None:
    port = {"sequencer": robot.sequencer, "logger": robot.logger}[board]
    lines = json_lines(tfsat_host("monitor", "--for", "0.5", "--json", "--port", port).stdout)
    assert lines[-1][board]["state"] in ("safe", "idle")
    assert lines[-1][other] is None
    people = tfsat_host("monitor", "--for", "0.5", "--port", port)
    assert f"| {board} " in people.stdout and f"| {other} " not in people.stdout


def test_a_board_that_goes_leaves_the_other_and_comes_back(robot: Served, both: dict[str, str]) -> None:
    monitor = Monitor(environ=both)
    monitor.until("logger", "state", "idle")
    robot.control("cable sequencer pull")
    lost = monitor.next()
    while "error" not in lost["sequencer"]:
        lost = monitor.next()
    assert lost["sequencer"]["error"]["code"] == "lost"
    assert lost["logger"]["state"] == "idle"
    # Its cable comes back, and so does the other board's after it: nobody types anything.
    robot.control("cable logger pull", "cable sequencer plug")
    monitor.until("sequencer", "state", "safe")
    robot.control("cable logger plug")
    monitor.until("logger", "state", "idle")
    robot.control("cable sequencer pull", "cable logger pull")
    lost = monitor.next()
    while not all("error" in (lost[board] or {}) for board in ("sequencer", "logger")):
        lost = monitor.next()
    monitor.process.send_signal(signal.SIGINT)
    last: Any = {}
    while "error" not in last:
        last = monitor.next()
    assert last["error"]["code"] == "lost"
    assert {board: error["code"] for board, error in last["error"]["lost"].items()} == dict.fromkeys(
        ("sequencer", "logger"), "lost"
    )
    assert "Sequencer: The connection on" in last["error"]["what"]
    assert "Logger: The connection on" in last["error"]["what"]
    assert monitor.process.wait(TIMEOUT_S) == 1
    assert monitor.process.communicate()[1] == "", "nothing but the errors in JSON"


@pytest.mark.parametrize("options", [(), ("--json",)])
def test_a_reader_that_goes_ends_it_quietly(
    robot: Served, both: dict[str, str], options: tuple[str, ...]
) -> None:
    """Closing the reading end of the output, as `| head -1` does, ends the monitor without an error."""
    with subprocess.Popen(
        [sys.executable, "-m", "tfsat_host", "monitor", *options],
        env={**os.environ, **both},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None and process.stderr is not None
        assert process.stdout.readline()
        process.stdout.close()
        error_text = process.stderr.read()
    assert error_text in ("", f"{UNCALIBRATED}\n")


def test_limp_servos_hold_no_angle(robot: Served, both: dict[str, str], tfsat_host: RunCli) -> None:
    assert "commanded limp" in tfsat_host("monitor", "--for", "0.5", environ=both).stdout
    with closing(SerialTransport(both["TFSAT_SEQUENCER_PORT"])) as port, pytest.raises(BoardRefusal):
        SequencerClient.connect(port).arm()
    monitor = Monitor(environ=both)
    safe = monitor.next()["sequencer"]
    assert safe["commanded_deg"] is None
    assert (safe["last_refusal"], safe["fault_explained"]) == ("no_maneuver", None)
    assert safe["last_refusal_explained"]["what"] == "No valid maneuver was uploaded."
    assert monitor.interrupt()[0] == 0
    output = tfsat_host("monitor", "--for", "0.5", environ=both).stdout
    assert "last refusal no maneuver: No valid maneuver was uploaded." in output
    tfsat_host("upload-sequence", 59, 70, environ=both)
    tfsat_host("arm", "--yes", environ=both)
    monitor = Monitor(environ=both)
    assert monitor.next()["sequencer"]["commanded_deg"] == [0, 0, 0]
    assert monitor.interrupt()[0] == 0


def test_lines_where_there_is_no_terminal(robot: Served, both: dict[str, str], tfsat_host: RunCli) -> None:
    robot.control("release 1")
    process = tfsat_host("monitor", "--for", "2.5", environ=both)
    lines = process.stdout.splitlines()
    assert len(lines) == 3
    assert "sequencer safe; switches 1 OPEN, 2 closed" in lines[0]
    assert "joints/deg (uncalibrated)" in lines[0]
    assert "uncalibrated" in process.stderr


@pytest.mark.parametrize(("columns", "rows"), [(80, 24), (120, 40)])
def test_a_picture_on_a_terminal(robot: Served, both: dict[str, str], columns: int, rows: int) -> None:
    robot.control("release 2")
    command = [sys.executable, "-m", "tfsat_host", "monitor", "--for", "1"]
    master, slave = pty.openpty()
    environ = {**os.environ, **both, "TERM": "xterm", "COLUMNS": "", "LINES": ""}
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
    with subprocess.Popen(command, stdout=slave, stderr=slave, env=environ) as process:
        os.close(slave)
        screen_bytes = b""
        try:
            while data := os.read(master, 4096):
                screen_bytes += data
        except OSError:  # Linux ends a terminal without writers so
            pass
    os.close(master)
    assert process.returncode == 0
    text = screen_bytes.decode()
    last = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text.rsplit("\x1b[2K", 1)[1])
    words = ("sequencer  safe; switches 1 closed, 2 OPEN", "logger     idle", "x / deg/s", "uncalibrated")
    for expected in (*words, "Ctrl-C ends it."):
        assert expected in last
    assert len(last.rstrip().splitlines()) < rows
    assert max(map(len, last.splitlines())) <= columns
    assert "\x1b[1A" in text, "drawn again in its place"


def test_without_any_board(tfsat_host: RunCli) -> None:
    error = tfsat_host.json("monitor", expect=1, without_ports=True)["error"]
    assert error["code"] == "none-found"


def test_a_port_that_is_not_there(tfsat_host: RunCli, monkeypatch: pytest.MonkeyPatch) -> None:
    process = tfsat_host("monitor", "--for", "1", "--port", "nope", "--json", expect=1)
    assert json.loads(process.stdout)["error"]["code"] == "missing"


def test_emulated(tfsat_host: RunCli) -> None:
    lines = json_lines(tfsat_host("monitor", "--emulated", "--for", "0.4", "--json").stdout)
    assert lines[-1]["sequencer"]["state"] == "safe" and lines[-1]["logger"]["state"] == "idle"


@pytest.mark.parametrize("duration", ["0", "-1", "inf", "soon"])
def test_a_duration_is_more_than_zero(tfsat_host: RunCli, duration: str) -> None:
    tfsat_host("monitor", f"--for={duration}", "--emulated", expect=2)
