"""What `calibrate` says and keeps when something comes between: a full disk, moved sensors, a lost recording."""

from __future__ import annotations

import json
import resource
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.calibration.scripted_person import COMMAND, FILE, FIRST, SECOND, Run, Terminal, interrupt_step
from tests.cli.process import RunCli
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.progress import MAX_DURATION_S
from tfsat_host.calibration.steps.step import Step, rest, swings, task, turn
from tfsat_host.cli.calibrate.arguments import MAX_TURN_DEG
from tfsat_host.cli.calibrate.bench import PERSON_SEED
from tfsat_host.cli.main import main
from tfsat_host.emulated.emulated_operator import EmulatedOperator
from tfsat_host.emulated.emulated_robot import DEFAULT_SEED, EmulatedRobot
from tfsat_host.emulated.imperfections import draw, draw_as_built
from tfsat_host.emulated.manual_motion import Operator

MAX_FILE_BYTES = 8192
RECORDINGS = Path("calibration-emulated-recordings")


@pytest.fixture
def full_disk() -> Iterator[Callable[..., None]]:
    """Yield a function that performs a step and then limits files to 8 KiB, as good as a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    def fill(step: Step, do: Callable[[Step], None]) -> None:
        do(step)
        # The limit bites at the next file: the step itself is already in memory.
        resource.setrlimit(resource.RLIMIT_FSIZE, (MAX_FILE_BYTES, before[1]))

    yield fill
    # The limit is of the process: it must not outlive the test.
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_step_that_cannot_be_written_is_named_and_the_certificate_is_as_before(
    calibrate: Run, capsys: pytest.CaptureFixture[str], full_disk: Callable[..., None]
) -> None:
    code, steps = calibrate(*COMMAND, "--yes", _3=full_disk)
    assert (code, steps) == (1, [rest(), FIRST, SECOND])
    error_text = capsys.readouterr().err
    assert (
        f"Error: {RECORDINGS / SECOND.key}-" in error_text
        and "could not be written: File too large." in error_text
    )
    assert f"This step was not kept; {FILE} is as before." in error_text
    assert f"2 of 3 steps are kept in {FILE}." in error_text
    assert error_text.count("tfsat-host calibrate misalignment --joint 2 --resume --port x") == 1
    # The step before it stays, as if nothing had happened.
    assert [recording.step for recording in read_calibration(FILE).recordings] == ["rest", FIRST.key]
    # No temporary file is left behind.
    assert len(list(RECORDINGS.glob("*.npz"))) == 2 and not list(RECORDINGS.glob(".*"))


def test_a_full_disk_in_json(
    calibrate: Run, capsys: pytest.CaptureFixture[str], full_disk: Callable[..., None]
) -> None:
    assert calibrate(*COMMAND, "--yes", "--json", _1=full_disk)[0] == 1
    error = json.loads(capsys.readouterr().out)["error"]
    assert error["what"].startswith(f"{RECORDINGS / 'rest'}-")
    assert error["next_step"].endswith("tfsat-host calibrate misalignment --joint 2 --resume --port x")
    assert not FILE.exists()


def test_sensors_that_were_moved_are_measured_anew_behind_a_landing(calibrate: Run) -> None:
    command = ("calibrate", "misalignment", "--joint", "3", "--port", "x", "--yes")
    todo = [rest(), *swings(3)]
    assert calibrate(*command) == (0, todo)
    before = read_calibration(FILE)
    assert before.landings == () and before.gyros[3].axes
    assert calibrate(*command, "--anew") == (0, todo), "biases too, however fresh they are"
    after = read_calibration(FILE)
    (landing,) = after.landings
    assert landing.told_by == "a person: sensors were moved"
    assert "[[landing]]" in FILE.read_text() and "a person: sensors were moved" in FILE.read_text()
    assert all(landing.at < recording.recorded_at for recording in after.recordings), (
        "nothing rests on what was before"
    )
    assert before.recordings and not {recording.sha256 for recording in before.recordings} & {
        recording.sha256 for recording in after.recordings
    }


def test_a_lost_recording_is_told_before_anything_is_measured(
    calibrate: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    assert calibrate("calibrate", "bias", "--port", "x", "--yes")[0] == 0
    (recording,) = RECORDINGS.glob("rest-*.npz")
    recording.unlink()
    capsys.readouterr()
    # The first step is interrupted: only the warning is looked at.
    assert calibrate(*COMMAND, "--yes", _1=interrupt_step)[0] == 130
    error_text = capsys.readouterr().err
    assert f"Warning: The recording {recording}" in error_text and "no longer counts" in error_text


def test_what_the_missing_zero_points_mean_is_said_before_a_motion(
    calibrate: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    assert calibrate(*COMMAND, "--yes", _1=interrupt_step)[0] == 130
    error_text = capsys.readouterr().err
    assert "Zero points of joints 1, 2, 3 are not calibrated: larger uncertainty" in error_text
    assert "tfsat-host calibrate zero --all --port x\n" in error_text
    assert calibrate("calibrate", "zero", "--all", "--port", "x", "--yes")[0] == 0
    capsys.readouterr()
    assert calibrate(*COMMAND, "--yes", _1=interrupt_step)[0] == 130
    assert "Zero points" not in capsys.readouterr().err


def test_ctrl_c_at_a_prompt_ends_its_line(calibrate: Run, capsys: pytest.CaptureFixture[str]) -> None:
    def at_the_prompt(_step: Step, _do: Callable[[Step], None]) -> None:
        # The terminal's own echo of Ctrl-C.
        sys.stderr.write("Press Enter to start, q to quit: ^C")
        raise KeyboardInterrupt

    assert calibrate(*COMMAND, _1=at_the_prompt)[0] == 130
    assert "q to quit: ^C\nError: Interrupted." in capsys.readouterr().err


@pytest.mark.usefixtures("short_steps")
def test_a_servo_sweeps_a_joint_whose_bodies_take_two_sweeps(tfsat_host: RunCli) -> None:
    result = tfsat_host.json("calibrate", "scale", "--joint", 2, "--jog", "--emulated", "--yes")
    # A sweep of joint 2 moves bodies 1 and 2 once and 3 and 4 once.
    assert [row["body"] for row in result["scales"]] == [1, 2, 3, 4]
    assert [recording["key"] for recording in result["steps"]] == [
        "rest",
        "sweep-joint-2-body-1-2",
        "sweep-joint-2-body-3-4",
    ]


@pytest.mark.usefixtures("short_steps")
def test_a_jog_that_is_not_confirmed_is_refused_by_an_interlock(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdin", Terminal("yes\n"))
    command = ["calibrate", "scale", "--joint", "1", "--jog", "--emulated"]
    # Exit code 4: an interlock refused, nothing was moved.
    assert main(command) == 4
    error_text = capsys.readouterr().err
    assert "Nothing was moved." in error_text and f"1 of 3 steps is kept in {FILE}." in error_text
    assert "tfsat-host calibrate scale --joint 1 --jog --resume --emulated" in error_text


@pytest.mark.parametrize(
    ("angle_deg", "words"),
    [
        (90.0, "in about 2 s (45 deg/s on average)"),
        (-360.0, "in about 4 s (90 deg/s on average)"),
        (720.0, "in about 8 s (90 deg/s on average)"),
    ],
)
def test_a_longer_turn_is_given_more_time(angle_deg: float, words: str) -> None:
    assert words in " ".join(task(turn("z", angle_deg)))


def test_the_longest_turn_that_is_taken_ends_in_time() -> None:
    # The longest turn that the command takes must fit into a recording.
    with EmulatedRobot() as robot:
        person = EmulatedOperator(robot, Operator.human(PERSON_SEED))
        assert person.duration_s(turn("z", MAX_TURN_DEG)) < MAX_DURATION_S


@pytest.mark.usefixtures("short_steps")
def test_an_emulated_robots_certificate_is_of_the_robot_that_was_calibrated(tfsat_host: RunCli) -> None:
    tfsat_host("calibrate", "bias", "--emulated")
    subject = read_calibration(tfsat_host.folder / FILE).subject
    assert subject.logger_serial == draw_as_built(DEFAULT_SEED).logger_serial.hex()
    # Another draw of the same seed: the robot on the bench was drawn as built.
    assert subject.logger_serial != draw(DEFAULT_SEED).logger_serial.hex()
