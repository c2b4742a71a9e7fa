"""The steps of `calibrate` in a terminal: repeated after a refusal, ended, and resumed behind what is kept."""

from __future__ import annotations

import argparse
import io
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.calibration.scripted_person import (
    COMMAND,
    FILE,
    FIRST,
    SECOND,
    Run,
    Terminal,
    do_nothing,
    interrupt_step,
    wrong_side,
)
from tests.devices.scripted import client, hello, live_sample, reply
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.evidence import Evidence, Origin
from tfsat_host.calibration.steps.step import DURATION_S, Step, StepKind, zero
from tfsat_host.cli.calibrate.bench import LEAD_S, Bench
from tfsat_host.cli.calibrate.person import record_step
from tfsat_host.cli.main import main
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.errors import RefusedError
from tfsat_host.present.output import Output
from tfsat_host.protocol.enums import Board
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.messages import HelloRequest, LiveReply, LiveRequest
from tfsat_host.robot import load_robot


def test_a_refused_step_is_repeated_after_enter(calibrate: Run, capsys: pytest.CaptureFixture[str]) -> None:
    # Attempt 2 does nothing, attempt 4 moves the wrong side.
    code, steps = calibrate(*COMMAND, stdin_text="\n\n", _2=do_nothing, _4=wrong_side)
    assert code == 0
    assert [step.key for step in steps] == ["rest", FIRST.key, FIRST.key, SECOND.key, SECOND.key]
    output = capsys.readouterr()
    assert output.err.count("Press Enter to repeat the step, q to quit") == 2
    assert "at least" in output.err, "what was wrong with the first attempt"
    assert "Joint 2" in output.out
    assert [recording.step for recording in read_calibration(FILE).recordings] == [
        "rest",
        FIRST.key,
        SECOND.key,
    ]


def test_q_after_a_refusal_keeps_what_was_accepted(
    calibrate: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    # At the first refusal the person quits: what came before stays.
    code, steps = calibrate(*COMMAND, stdin_text="q\n", _3=do_nothing)
    assert (code, len(steps)) == (1, 3)
    error_text = capsys.readouterr().err
    assert "Stopped before the last step." in error_text
    assert f"2 of 3 steps are kept in {FILE}." in error_text
    assert "tfsat-host calibrate misalignment --joint 2 --resume --port x" in error_text


def test_after_ctrl_c_resume_goes_on_behind_what_is_kept(
    calibrate: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _ = calibrate(*COMMAND, _3=interrupt_step)
    assert code == 130
    assert f"2 of 3 steps are kept in {FILE}." in capsys.readouterr().err
    code, steps = calibrate(*COMMAND, "--resume")
    assert (code, steps) == (0, [SECOND])
    assert "body 4" in capsys.readouterr().out
    code, steps = calibrate(*COMMAND)
    assert (code, steps) == (0, [FIRST, SECOND]), (
        "without --resume all is measured again, but for the fresh bias"
    )


def test_with_yes_a_refusal_ends_the_command_with_the_cure_first(
    calibrate: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    code, steps = calibrate(*COMMAND, "--yes", _3=do_nothing)
    assert (code, len(steps)) == (1, 3)
    lines = capsys.readouterr().err.splitlines()
    assert "Enter repeats" not in "\n".join(lines)
    assert lines[-1].strip().startswith("To resume after the kept steps: tfsat-host calibrate")
    assert "run this command again" in lines[-2]


def test_what_refuses_a_step_is_said_not_taken_for_an_answer(
    calibrate: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse_step(_step: Step, _do: Callable[[Step], None]) -> None:
        raise RefusedError(what="The sequencer is armed.", meaning="Nothing moved.", next_step="Disarm it.")

    code, _ = calibrate(*COMMAND, _2=refuse_step)
    assert code == RefusedError.exit_code
    error_text = capsys.readouterr().err
    assert "The sequencer is armed." in error_text and f"1 of 3 steps is kept in {FILE}." in error_text


def test_nothing_is_written_when_the_first_step_is_refused(
    calibrate: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _ = calibrate(*COMMAND, "--yes", _1=lambda _step, do: do(FIRST))
    assert code == 1
    assert "not still" in capsys.readouterr().err
    # Nothing was accepted, so that no file is made.
    assert list(Path().iterdir()) == []
    code, _ = calibrate(*COMMAND, _1=interrupt_step)
    assert code == 130
    assert "0 of 3 steps kept" in capsys.readouterr().err
    assert list(Path().iterdir()) == []


def test_json_is_one_object_also_after_a_refusal(calibrate: Run, capsys: pytest.CaptureFixture[str]) -> None:
    code, _ = calibrate(*COMMAND, "--json", stdin_text="\n\n", _2=do_nothing)
    output = capsys.readouterr()
    assert code == 1
    assert "error" in json.loads(output.out)
    assert output.err == ""


def test_a_slipped_sensor_is_told_and_its_zero_taken_anew(
    calibrate: Run, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    zero_command = ("calibrate", "zero", "--joint", "1", "--port", "x", "--yes")
    assert calibrate(*zero_command)[0] == 0
    # Any disagreement of the two sensors counts as a slip.
    monkeypatch.setattr("tfsat_host.calibration.zero.MAX_DISAGREEMENT_RAD", -1.0)  # as if one had slipped
    assert calibrate(*zero_command)[0] == 1
    error_text = capsys.readouterr().err
    assert "tfsat-host calibrate zero --joint 1 --anew --port x" in error_text
    assert calibrate(*zero_command, "--anew")[0] == 0


@pytest.mark.parametrize(("yes", "lead_s"), [(True, LEAD_S), (False, 0.0)])
def test_with_yes_a_board_is_read_after_a_stated_lead(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    yes: bool,
    lead_s: float,
) -> None:
    monkeypatch.chdir(tmp_path)
    robot = EmulatedRobot(seed=5)
    robot.advance(SETTLE_US)
    robot.hold((1, 2, 3, 4))

    @contextmanager
    def open_logger(_args: argparse.Namespace, _out: Output) -> Iterator[LoggerClient]:
        yield LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))

    monkeypatch.setattr("tfsat_host.cli.calibrate.bench.open_logger", open_logger)
    monkeypatch.setattr("sys.stdin", Terminal("\n"))
    before_us = robot.now_us
    assert main(["calibrate", "bias", "--port", "x", *(["--yes"] if yes else [])]) == 0
    error_text = capsys.readouterr().err
    assert ("Reading starts in 3 s." in error_text) is yes
    assert ("Press Enter to start" in error_text) is not yes
    took_s = (robot.now_us - before_us) * 1e-6
    # The rest itself, and the lead before it.
    assert took_s == pytest.approx(DURATION_S[StepKind.REST] + lead_s, abs=0.5)


def test_lost_samples_are_said() -> None:
    stderr = io.StringIO()
    evidence = record_zero(scripted_logger(lost=range(300, 302)), Output(stdout=io.StringIO(), stderr=stderr))
    assert evidence.counts.samples_lost == 2
    assert "Warning: 2 of 5001 samples lost (Zero point of joint 1)" in stderr.getvalue()


def test_a_recording_starts_with_samples_of_its_own() -> None:
    """Start a recording with its own samples.

    Those that arrived after the previous step, while a person read the next task, are dropped.
    """
    logger = scripted_logger()
    out = Output(stdout=io.StringIO(), stderr=io.StringIO())
    first, again = record_zero(logger, out), record_zero(logger, out)
    # What came between the two steps is in neither.
    assert first.counts.samples_lost == again.counts.samples_lost == 0
    assert again.counts.t_us[-1] - again.counts.t_us[0] == pytest.approx(5e6)


class Idle:
    """Somebody who does nothing."""

    lead_s = 0.0

    def begin(self, step: Step) -> None:
        """Nothing."""


def record_zero(logger: LoggerClient, out: Output) -> Evidence:
    """Record the zero step of joint 1 from the logger's samples."""
    model = load_robot()
    nothing_known = solve((), model)
    bench = Bench(logger, Idle(), Origin("", "", True, "", ""))
    return record_step(zero(1), bench, nothing_known, model, out)


def scripted_logger(lost: range = range(0)) -> LoggerClient:
    """Return a logger at 1000 Hz that sends 5001 samples whenever it is asked for live ones."""
    start = 1000

    def script(request: Frame) -> Iterator[bytes]:
        nonlocal start
        if request.type == HelloRequest.TYPE:
            yield reply(request, hello(Board.LOGGER))
            return
        live = LiveRequest.decode(request.payload).enabled
        yield reply(
            request, LiveReply(live, 1000, 131.0, 16384.0, 4096, 3, bytes([0x68] * 4), (0,) * 4, (0,) * 6)
        )
        if live:
            for index in range(5001):
                if index not in lost:
                    yield live_sample(start + index)
            start += 10_000

    connected, _ = client(script)
    return LoggerClient(connected, connected.hello(Board.LOGGER))
