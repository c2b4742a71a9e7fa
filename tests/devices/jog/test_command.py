"""`tfsat-host jog` as a person has it: the word, the refusals, Ctrl-C, over a port and emulated."""

from __future__ import annotations

import io
import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from tests.cli.process import RunCli
from tests.emulated.served import TIMEOUT_S, Served
from tfsat_host.cli.main import main
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.devices.transport import SerialTransport
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.limits import JOG_IDLE_MS

JOG = ("jog", "--joint", "1", "--from", "0", "--to", "20")


@pytest.fixture
def robot(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Served]:
    """Serve a robot with the native core, or with the real image in tests that ask for it.

    Tests ask for the image in matters that the board alone decides.
    """
    monkeypatch.chdir(tmp_path)
    with Served("--exact", "--sequencer", getattr(request, "param", "native")) as process:
        process.control("hold 3")
        yield process


BOTH_SEQUENCERS = pytest.mark.parametrize("robot", ["native", "avr"], indirect=True)
LAG_DEG = 5.0
"""Between the last commanded angle, as the program saw it, and where its joint comes to rest."""


@contextmanager
def start_jog(robot: Served, *options: str) -> Iterator[subprocess.Popen[str]]:
    """Run a jog to 90 deg and yield its process once the joint has passed 3 deg."""
    command = [sys.executable, "-m", "tfsat_host", *JOG[:-1], "90", "--yes", *options]
    with subprocess.Popen(
        [*command, "--port", str(robot.sequencer)],
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        process_group=0,  # as a shell does: Ctrl-Z stops only a group that somebody can continue
    ) as process:
        # Only a joint that really moves can be stopped on its way.
        while joint_1_deg(robot) < 3:
            assert process.poll() is None, process.communicate()
            robot.control("wait 20ms")
        yield process


def commanded_deg_of(output: str) -> float:
    match = re.search(r"Joint 1 was last commanded to ([\d.]+) deg and was let go", output)
    assert match, output
    return float(match[1])


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def joint_1_deg(robot: Served) -> float:
    (reply,) = robot.control("angles")
    return float(reply.split()[1])


def is_limp(robot: Served) -> bool:
    """Return whether joint 1 is limp: it can be swung by hand, 100 ms after its servo's last pulse."""
    # 120 ms after the last pulse a servo is limp: a hand can swing the joint.
    return robot.control("wait 120ms", "swing 1 5 0.1 1")[-1].startswith("ok")


@BOTH_SEQUENCERS
def test_over_a_port_it_moves_slowly_and_ends_limp(robot: Served, tfsat_host: RunCli) -> None:
    (before,) = robot.control("time")
    result = tfsat_host.json(*JOG, "--hold", "0.5", "--yes", "--port", robot.sequencer)
    (after,) = robot.control("time")
    assert (result["joint"], result["to_deg"], result["state"]) == (1, 20, "safe")
    # 20 deg at 15 deg/s and half a second of holding.
    assert float(after.split()[1]) - float(before.split()[1]) > 20 / 15 + 0.5
    assert joint_1_deg(robot) == pytest.approx(20, abs=1)
    assert is_limp(robot)
    assert tfsat_host.json("status", "--port", robot.sequencer)["sequencer"]["state"] == "safe"


@pytest.mark.parametrize("options", [(), ("--json",)])
def test_ctrl_c_lets_it_go(robot: Served, options: tuple[str, ...]) -> None:
    with start_jog(robot, *options) as process:
        process.send_signal(signal.SIGINT)
        said_out, error_text = process.communicate(timeout=TIMEOUT_S)
    # 130: ended by a signal, as a shell expects it.
    assert process.returncode == 130
    assert "Traceback" not in error_text
    if options:
        error = json.loads(said_out)["error"]
        assert error["joint"] == 1
        commanded_deg = error["last_angle_deg"]
    else:
        assert said_out == ""
        # Where the lines break depends on the digits of the angle.
        assert "was let go on its way; the sequencer is safe" in " ".join(error_text.split())
        commanded_deg = commanded_deg_of(error_text)
    # Past the start, and let go far from the target.
    assert 3 < joint_1_deg(robot) < 80
    assert commanded_deg == pytest.approx(joint_1_deg(robot), abs=LAG_DEG)
    assert is_limp(robot)


@BOTH_SEQUENCERS
def test_a_frozen_host_stops_the_jog(robot: Served) -> None:
    with start_jog(robot) as process:
        # Stopped as by a debugger or a sleeping laptop: no order goes out any more.
        process.send_signal(signal.SIGSTOP)
        robot.control(f"wait {JOG_IDLE_MS + 500}ms")
        stopped_deg = joint_1_deg(robot)
        # The board let go by itself, long before 90 deg.
        assert stopped_deg < 60
        assert is_limp(robot)
        robot.control("wait 1s")
        process.send_signal(signal.SIGCONT)
        _, error_text = process.communicate(timeout=TIMEOUT_S)
    # Continued: it must see that it was away, and not take up its jog again.
    assert process.returncode == 1
    assert "This computer was away for" in error_text
    assert "did not restart" in error_text
    assert 0 < commanded_deg_of(error_text) <= stopped_deg + LAG_DEG
    assert is_limp(robot)


def test_ctrl_z_lets_it_go_before_the_program_stops(robot: Served) -> None:
    with start_jog(robot) as process:
        process.send_signal(signal.SIGTSTP)
        # The shell sees a stopped child.
        _, status = os.waitpid(process.pid, os.WUNTRACED)
        assert os.WIFSTOPPED(status)
        left_deg = joint_1_deg(robot)
        assert is_limp(robot)
        # Another program can have the port: nothing holds it.
        with closing(SerialTransport(str(robot.sequencer))) as port:
            assert SequencerClient.connect(port).status().state == SequencerState.SAFE
        process.send_signal(signal.SIGCONT)
        _, error_text = process.communicate(timeout=TIMEOUT_S)
    assert process.returncode == 130
    assert "Error: The jog has ended: Ctrl-Z let the joint go" in error_text
    assert commanded_deg_of(error_text) == pytest.approx(left_deg, abs=LAG_DEG)


def test_it_says_what_will_move_and_demands_the_word(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stdin", Terminal("yes\n"))
    assert main([*JOG, "--emulated"]) == 4
    output = capsys.readouterr()
    assert output.out == ""
    for words in (
        "Joint 1 will move from 0 to 20 deg at 15 deg/s (1.3 s)",
        "The other joints stay limp",
        "first pulse takes it to 0 deg at the servo's full speed",
        "bring it to 0 deg by hand first",
        "Type JOG to move it: ",
        "The emulated robot starts with each command: all its joints are at 0 deg now.",
        "Nothing was moved.",
    ):
        assert words in output.err
    assert "joint 1:" not in output.err
    monkeypatch.setattr(sys, "stdin", Terminal("JOG\n"))
    assert main([*JOG, "--emulated"]) == 0
    output = capsys.readouterr()
    assert "moved to 20 deg and let go (sequencer safe)" in output.out
    assert "joint 1:  20.00 deg, to 20 deg" in output.err


def test_without_a_terminal_nothing_moves(tfsat_host: RunCli) -> None:
    refused = tfsat_host(*JOG, "--emulated", expect=2)
    assert "add --yes" in refused.stderr
    assert "Nothing was moved." in refused.stderr


def test_an_armed_board_refuses_before_anybody_is_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tfsat_host: RunCli
) -> None:
    monkeypatch.chdir(tmp_path)
    with Served() as robot:
        tfsat_host("upload-sequence", 59, 70, "--port", robot.sequencer)
        tfsat_host("arm", "--yes", "--port", robot.sequencer)
        error = tfsat_host.json(*JOG, "--port", robot.sequencer, expect=4)["error"]
        assert error["code"] == "wrong_state"
        assert error["what"].startswith("The sequencer is armed;")
        assert error["next_step"].startswith(f"tfsat-host disarm --port {robot.sequencer}, then")
        assert tfsat_host.json("status", "--port", robot.sequencer)["sequencer"]["state"] == "armed"


def test_beyond_the_joints_limits(tfsat_host: RunCli) -> None:
    error = tfsat_host.json(*JOG[:-1], "90.5", "--emulated", "--yes", expect=4)["error"]
    assert error["code"] == "joint-limits"
    assert error["what"] == "--to 90.5 is outside joint 1's limits, 0 to 90 deg."
    assert error["next_step"].endswith(": tfsat-host upload-servos --show --emulated")


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ("--joint 4 --from 0 --to 1", "invalid choice: 4"),
        ("--joint 1 --to 1", "--from"),
        ("--joint 1 --from nan --to 1", "no angle of a joint"),
        ("--joint 1 --from 0 --to 181", "no angle of a joint"),
        ("--joint 1 --from 0 --to 1 --hold -1", "no duration"),
        ("--joint 1 --from 0 --to 1 --hold inf", "no duration"),
    ],
)
def test_arguments_that_mean_nothing(tfsat_host: RunCli, arguments: str, reason: str) -> None:
    assert reason in tfsat_host("jog", *arguments.split(), "--emulated", "--yes", expect=2).stderr
