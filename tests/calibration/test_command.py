"""`calibrate misalignment` as a user has it: what it writes, what it overwrites, when it measures."""

from __future__ import annotations

import argparse
import io
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime

import numpy as np
import pytest

from tests.cli.process import RunCli
from tests.devices.scripted import client, hello, live_sample, reply
from tfsat_host import __version__
from tfsat_host.calibration.file import Subject, format_axes, read_subject
from tfsat_host.calibration.misalignment import AxisEstimate
from tfsat_host.cli.calibrate import LEAD_S, STILL_S, SWING_S, Bench, PersonAtPrompt, record
from tfsat_host.cli.main import main
from tfsat_host.cli.output import Output
from tfsat_host.devices.client import Client
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.bench import EmulatedOperator
from tfsat_host.emulated.robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.protocol.enums import Board
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.limits import PROTOCOL_HASH
from tfsat_host.protocol.messages import HelloRequest, LiveReply, LiveRequest
from tfsat_host.robot import load_robot

COMMAND = ("calibrate", "misalignment", "--emulated", "--joint")
AXIS = AxisEstimate(1, 1, np.eye(3)[0], np.eye(3)[0], 0.0, 0.001, 70.0, np.zeros(3), np.zeros(3))
TAKEN = datetime(2025, 1, 2, tzinfo=UTC)


@pytest.mark.parametrize(("joint", "bodies"), [(2, [1, 2, 3, 4]), (3, [4])])
def test_the_file_says_what_was_measured_and_of_what(
    tfsat_host: RunCli, joint: int, bodies: list[int]
) -> None:
    result = tfsat_host.json(*COMMAND, joint)
    assert [axis["body"] for axis in result["axes"]] == bodies
    assert result["file"] == f"misalignment-joint-{joint}-emulated.toml"
    written = tomllib.loads((tfsat_host.folder / result["file"]).read_text())
    assert (written["joint"], written["emulated"]) == (joint, True)
    assert written["tool_version"] == __version__
    assert written["protocol_hash"] == PROTOCOL_HASH.hex()
    nominal = load_robot().joint_axis[joint - 1]
    for axis, row in zip(result["axes"], written["axis"], strict=True):
        assert row["axis_sensor"] == pytest.approx(axis["axis_sensor"], abs=1e-7)
        assert axis["nominal_sensor"] == pytest.approx(nominal)
        assert 0.0 < axis["angle_deg"] < 6.0


def test_it_does_not_overwrite_other_files(tfsat_host: RunCli) -> None:
    notes = tfsat_host.folder / "notes.toml"
    notes.write_text("mine = true\n")
    result = tfsat_host(*COMMAND, 3, "--out", notes, expect=1)
    assert "was not made by this command" in result.stderr
    assert notes.read_text() == "mine = true\n"
    tfsat_host(*COMMAND, 3, "--out", notes, "--force")
    tfsat_host(*COMMAND, 3, "--out", notes)  # its own file it may replace
    refused = tfsat_host(*COMMAND, 1, "--out", notes, expect=1)
    assert "is of joint 3 on the emulated logger" in refused.stderr


@pytest.mark.parametrize(
    ("there", "words"),
    [
        (Subject(2, "00c0ffee", emulated=False), "is of joint 2 on logger 00c0ffee"),
        (Subject(2, "656d754c41544544", emulated=False), "is of joint 2 on logger 656d"),
        (None, "does not say what it is of"),
    ],
)
def test_a_calibration_of_something_else_is_kept(
    tfsat_host: RunCli, there: Subject | None, words: str
) -> None:
    real = tfsat_host.folder / "real.toml"
    text = "# tfsat misalignment\n" if there is None else format_axes([AXIS], there, TAKEN)
    real.write_text(text)
    refused = tfsat_host(*COMMAND, 2, "--out", real, expect=1)
    assert words in refused.stderr
    assert "--force" in refused.stderr
    assert real.read_text() == text


def test_a_subject_reads_back(tfsat_host: RunCli) -> None:
    subject = Subject(3, "00c0ffee", emulated=False)
    file = tfsat_host.folder / "axes.toml"
    file.write_text(format_axes([AXIS], subject, TAKEN))
    assert read_subject(file) == subject
    assert subject.default_name() == "misalignment-joint-3.toml"
    file.write_bytes(b"\xff\xfe")
    assert read_subject(file) is None


@pytest.mark.parametrize(("yes", "lead_s"), [(True, LEAD_S), (False, 0.0)])
def test_with_yes_a_board_is_read_after_a_stated_lead(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], yes: bool, lead_s: float
) -> None:
    robot = EmulatedRobot(seed=5)
    robot.advance(SETTLE_US)
    EmulatedOperator(robot).rest()

    @contextmanager
    def open_logger(args: argparse.Namespace, out: Output) -> Iterator[LoggerClient]:
        yield LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))

    class Person(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr("tfsat_host.cli.connection.open_logger", open_logger)
    monkeypatch.setattr("sys.stdin", Person("\n\n"))
    before_us = robot.now_us
    arguments = ["calibrate", "misalignment", "--joint", "3", "--port", "x", *(["--yes"] if yes else [])]
    assert main(arguments) == 1
    said = capsys.readouterr().err
    assert "Body 4 turned at 0." in said  # nobody swung it
    assert said.count("starting 3 s from now") == (2 if yes else 0)
    took_s = (robot.now_us - before_us) * 1e-6
    assert took_s == pytest.approx(STILL_S + SWING_S + 2 * lead_s, abs=0.5)


def test_lost_samples_are_said() -> None:
    logger = scripted_logger(lost=range(300, 302))
    stderr = io.StringIO()
    out = Output(stdout=io.StringIO(), stderr=stderr)
    recording = record(Bench(logger, PersonAtPrompt(out), 0.0), 1.0, "at rest", out)
    assert recording.samples_lost == 2
    assert "Warning: 2 of 1001 samples never arrived (at rest)" in stderr.getvalue()


def test_a_recording_starts_with_samples_of_its_own() -> None:
    """What arrived after the end of the measurement before, while a person read the next task, is dropped."""
    logger = scripted_logger()
    out = Output(stdout=io.StringIO(), stderr=io.StringIO())
    recording = record(Bench(logger, PersonAtPrompt(out), 0.0), 0.5, "at rest", out)
    again = record(Bench(logger, PersonAtPrompt(out), 0.0), 0.5, "at rest", out)
    assert recording.samples_lost == again.samples_lost == 0
    assert again.t_s[-1] - again.t_s[0] == pytest.approx(0.5)


def scripted_logger(lost: range = range(0)) -> LoggerClient:
    """A logger at 1000 Hz that sends 1001 samples whenever it is asked for live ones."""
    start = 1000

    def script(request: Frame) -> Iterator[bytes]:
        nonlocal start
        if request.type == HelloRequest.TYPE:
            yield reply(request, hello(Board.LOGGER))
            return
        live = LiveRequest.decode(request.payload).enabled
        yield reply(request, LiveReply(live, 1000, 131.0, 16384.0, 4096))
        if live:
            for index in range(1001):
                if index not in lost:
                    yield live_sample(start + index)
            start += 10_000

    connected, _ = client(script)
    assert isinstance(connected, Client)
    return LoggerClient(connected, connected.hello(Board.LOGGER))


def test_without_a_joint_or_with_one_too_many(tfsat_host: RunCli) -> None:
    assert "--joint" in tfsat_host("calibrate", "misalignment", "--emulated", expect=2).stderr
    assert "4" in tfsat_host(*COMMAND, 4, expect=2).stderr
    assert tfsat_host("calibrate", expect=2).stderr


def test_without_a_logger(tfsat_host: RunCli) -> None:
    result = tfsat_host("calibrate", "misalignment", "--joint", "1", expect=1, without_ports=True)
    assert "Plug in the Teensy 4.1" in result.stderr
    assert "--emulated" in result.stderr
