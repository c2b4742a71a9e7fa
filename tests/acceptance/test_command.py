"""`tfsat-host acceptance` as two people have it: prompts, single keys, interruption, resumption, page."""

from __future__ import annotations

import io
import json
import os
import pty
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

import pytest

from tests.acceptance.bench_in_emulation import NAMES, emulated_bench
from tests.cli.process import RunCli
from tfsat_host.acceptance.bench import Bench, Task, describe_task
from tfsat_host.acceptance.page import render_page
from tfsat_host.acceptance.record import read_acceptance
from tfsat_host.cli import acceptance as command
from tfsat_host.cli.main import main
from tfsat_host.devices.serial_ports import PortError, PortProblem
from tfsat_host.errors import TfsatError
from tfsat_host.robot import load_robot


def test_an_emulated_robot_is_accepted_with_record_and_page(tfsat_host: RunCli) -> None:
    result = json.loads(tfsat_host("acceptance", "--emulated", "--json").stdout)
    assert result["verdict"] == "accepted"
    assert result["remaining"] == []
    record = read_acceptance(tfsat_host.folder / "acceptance-emulated.json")
    assert record.logger.serial == result["logger"]["serial"]
    page = (tfsat_host.folder / "acceptance-emulated.html").read_text(encoding="utf-8")
    for text in ("ACCEPTED: 8 of 8 steps passed, emulated robot", record.logger.serial, "<svg"):
        assert text in page
    # The page asks for nothing from anywhere, and its policy forbids it.
    assert not re.search(r"https?://|<script|src=", page)


def test_a_fault_is_named_on_the_screen_and_refused(tfsat_host: RunCli) -> None:
    done = tfsat_host("acceptance", "--emulated", "--fault", "angle-2-swapped", expect=4)
    assert "the wires of joint 2's sensors are swapped (Teensy pins 20 and 21)" in done.stdout
    assert done.stdout.rstrip().splitlines()[-1].startswith("NOT ACCEPTED: motion, servos, supply (5 of 8")
    assert "tfsat-host acceptance --emulated" in done.stdout
    # Mended: only what did not pass is done again.
    again = tfsat_host("acceptance", "--emulated")
    assert again.stderr.count("done before") == 4
    assert "ACCEPTED: 8 of 8" in again.stdout
    assert tfsat_host("acceptance", "--emulated", "--only", "switches").stderr.count("done before") == 6


def test_what_rests_on_a_mended_step_is_done_again_at_once(tfsat_host: RunCli) -> None:
    done = tfsat_host("acceptance", "--emulated", "--fault", "imu-1-turned", expect=4)
    assert done.stdout.rstrip().splitlines()[-1].startswith("NOT ACCEPTED: motion (7 of 8")
    again = tfsat_host("acceptance", "--emulated")
    assert again.stderr.count("done before") == 4
    assert "ACCEPTED: 8 of 8" in again.stdout
    # Asked for alone, it ends what rests on it, and nothing is there to mend.
    alone = tfsat_host("acceptance", "--emulated", "--only", "motion", expect=4).stdout
    assert alone.rstrip().splitlines()[-1].startswith("NOT ACCEPTED: servos, supply (6 of 8")
    assert "Next: tfsat-host acceptance --emulated (done steps are kept)" in alone


def test_a_step_that_is_asked_for_again_counts_no_more_once_it_is_interrupted(
    tfsat_host: RunCli, monkeypatch: pytest.MonkeyPatch
) -> None:
    tfsat_host("acceptance", "--emulated")
    with monkeypatch.context() as patched:
        patched.setattr(Bench, "read", raising(KeyboardInterrupt()))
        stopped = tfsat_host("acceptance", "--emulated", "--only", "rest", expect=130).stderr
    assert "7 of 8 steps are kept" in stopped
    again = tfsat_host("acceptance", "--emulated")
    assert again.stderr.count("done before") == 6
    assert "Step 2 of 8: IMUs at rest: done before" not in again.stderr


def test_a_lost_link_ends_the_session_with_the_command_that_goes_on(
    tfsat_host: RunCli, monkeypatch: pytest.MonkeyPatch
) -> None:
    lost = PortError(
        PortProblem.LOST, what="The connection on robot/logger was lost.", next_step="Plug it in."
    )
    monkeypatch.setattr(Bench, "read", raising(lost))
    stopped = tfsat_host("acceptance", "--emulated", expect=130).stderr
    assert "The connection on robot/logger was lost." in stopped
    assert "1 of 8 steps are kept" in stopped
    assert "Go on at this step: tfsat-host acceptance --emulated" in stopped


def test_axes_wait_until_each_imu_is_on_its_body(tfsat_host: RunCli) -> None:
    """One on another body is not held against this body's mounting: that would be written into the robot file."""
    faults = ("--fault", "imu-3-4-swapped", "--fault", "imu-4-upside-down")
    shown = tfsat_host("acceptance", "--emulated", "--only", "motion", *faults, expect=4).stdout
    assert "IMU 3 answers where IMU 4 belongs" in shown
    assert "imu-axes: It waits for imus-by-body" in shown
    assert "sensor_to_body" not in shown


def test_a_fast_sequencer_strokes_early(tfsat_host: RunCli) -> None:
    fault = ("--only", "switches", "time", "--fault", "clock-off")
    result = json.loads(tfsat_host("acceptance", "--emulated", "--json", *fault, expect=4).stdout)
    checks = {check["name"]: check for step in result["steps"] for check in step["checks"]}
    evidence = checks["clock-ratio"]["evidence"]
    assert evidence["rate_ppm"] == pytest.approx(2000.0, abs=60.0)
    assert evidence["at_last_stroke_us"] == pytest.approx(-2.42 * 2000.0, abs=150.0)


def raising(error: BaseException) -> Callable[..., NoReturn]:
    def fail(*_: object) -> NoReturn:
        raise error

    return fail


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--emulated", "--fault", "nonsense"), "no wiring fault 'nonsense'"),
        (("--emulated", "--only", "nonsense"), "no step 'nonsense'"),
        (("--fault", "imu-2-silent"), "--fault is of the emulated robot"),
    ],
)
def test_what_does_not_exist_is_refused(tfsat_host: RunCli, arguments: tuple[str, ...], words: str) -> None:
    assert words in tfsat_host("acceptance", *arguments, expect=2).stderr


def test_a_file_that_is_no_record_is_not_overwritten(tfsat_host: RunCli) -> None:
    file = tfsat_host.folder / "acceptance-emulated.json"
    file.write_text("mine", encoding="utf-8")
    assert "--out" in tfsat_host("acceptance", "--emulated", expect=1).stderr
    assert file.read_text(encoding="utf-8") == "mine"


def test_a_finished_acceptance_is_shown_and_not_begun_anew(tfsat_host: RunCli) -> None:
    tfsat_host("acceptance", "--emulated")
    file = tfsat_host.folder / "acceptance-emulated.json"
    before = file.read_bytes()
    again = tfsat_host("acceptance", "--emulated")
    assert "ACCEPTED: 8 of 8" in again.stdout
    assert again.stderr.count("done before") == 8
    assert file.read_bytes() == before


def test_the_record_of_another_robot_is_not_overwritten(tfsat_host: RunCli) -> None:
    tfsat_host("acceptance", "--emulated", "--only", "switches", expect=4)
    file = tfsat_host.folder / "acceptance-emulated.json"
    record = json.loads(file.read_text(encoding="utf-8"))
    assert [step["name"] for step in record["steps"]] == ["boards", "switches"]
    record["logger"]["serial"] = "0123"
    file.write_text(json.dumps(record), encoding="utf-8")
    refused = tfsat_host("acceptance", "--emulated", expect=2)
    assert "is of another logger" in refused.stderr
    assert json.loads(file.read_text(encoding="utf-8")) == record
    assert "ACCEPTED" in tfsat_host("acceptance", "--emulated", "--force").stdout


def test_another_sequencer_asks_for_its_own_steps_alone(tfsat_host: RunCli) -> None:
    tfsat_host("acceptance", "--emulated")
    file = tfsat_host.folder / "acceptance-emulated.json"
    record = json.loads(file.read_text(encoding="utf-8"))
    record["sequencer"]["serial"] = "0123"
    file.write_text(json.dumps(record), encoding="utf-8")
    again = tfsat_host("acceptance", "--emulated")
    assert "boards, switches, time, servos, supply are done again" in again.stderr
    assert re.findall(r"Step \d of 8: ([^:\n]+): done before", again.stderr) == [
        "IMUs at rest",
        "IMUs and angle sensors, moved by hand",
        "A recording of 60 s",
    ]
    assert "ACCEPTED: 8 of 8" in again.stdout


def test_a_damaged_record_says_so(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('{"made_by": "tfsat-host acceptance"}', encoding="utf-8")
    with pytest.raises(TfsatError, match="damaged"):
        read_acceptance(tmp_path / "a.json")


def test_every_prompt_fits_a_small_terminal() -> None:
    for task in Task:
        lines = describe_task(task, 1, load_robot())
        rows = sum(-(-(len(line) + 2) // 80) for line in lines)
        assert rows <= 20, lines


@pytest.fixture
def people(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[bytes], tuple[int, str]]]:
    """Two people at real boards' prompts: the boards are emulated, the hands do what a program does."""
    monkeypatch.chdir(tmp_path)
    typed, terminal = pty.openpty()

    @contextmanager
    def open_boards(_args: object, _model: object, out: Any) -> Iterator[Bench]:
        with emulated_bench() as (bench, _):
            people, hands = command._TwoPeople(load_robot(), out), bench.hands

            class Both:
                def do(self, task: Task, number: int = 0) -> None:
                    people.do(task, number)
                    hands.do(task, number)

            bench.hands = Both()
            yield bench

    monkeypatch.setattr(command, "_open_boards", open_boards)

    def run(keys: bytes) -> tuple[int, str]:
        class Screen(io.StringIO):
            """Types a key at each prompt; one that was typed before it would not count."""

            left = keys

            def write(self, text: str) -> int:
                if "q: stop here" in text:
                    os.write(typed, self.left[:1])
                    self.left = self.left[1:]
                return super().write(text)

        with os.fdopen(os.dup(terminal), encoding="utf-8") as stdin, monkeypatch.context() as patch:
            screen = Screen()
            for stream in ("stdout", "stderr"):
                patch.setattr(f"sys.{stream}", screen)
            patch.setattr("sys.stdin", stdin)
            code = main(["acceptance"])
        return code, screen.getvalue()

    yield run
    os.close(typed)
    os.close(terminal)


def test_an_interrupted_acceptance_resumes_at_its_step(
    people: Callable[[bytes], tuple[int, str]], tmp_path: Path
) -> None:
    # A key each: rest; then, at the first joint, stop.
    code, screen = people(b"\nq")
    assert code == 130
    # Of an emulated robot's boards, whatever port they were found at.
    assert "2 of 8 steps are kept in acceptance-emulated.json" in screen
    assert "tfsat-host acceptance" in screen
    assert [step.name for step in read_acceptance(tmp_path / "acceptance-emulated.json").steps] == list(
        NAMES[:2]
    )
    # Enter for each of the four motions, three switches, loopback, servos, three supplies.
    code, screen = people(b"\n" * 12)
    assert code == 0, screen
    assert screen.count("done before") == 1
    assert "ACCEPTED: 8 of 8" in screen
    assert "NOW let go of both switches" in screen


def test_a_page_of_nothing_done_is_still_a_page(tfsat_host: RunCli) -> None:
    tfsat_host("acceptance", "--emulated")
    record = read_acceptance(tfsat_host.folder / "acceptance-emulated.json")
    page = render_page(record.without(NAMES))
    assert "NOT ACCEPTED" in page
