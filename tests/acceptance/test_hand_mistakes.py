"""What hands do wrong is told as that, and no wire is blamed for it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.acceptance.bench_in_emulation import accept, emulated_bench
from tfsat_host.acceptance import emulated_hands
from tfsat_host.acceptance.bench import Bench, Task
from tfsat_host.emulated.emulated_robot import EmulatedRobot
from tfsat_host.emulated.manual_motion import Leg, Motion, Operator

Do = Callable[[Task, int], None]


def instead(bench: Bench, mistake: Callable[[Do, Task, int], None]) -> None:
    """Let the hands make this mistake; it is given what they would do."""
    right = bench.hands.do

    class Hands:
        def do(self, task: Task, number: int = 0) -> None:
            mistake(right, task, number)

    bench.hands = Hands()


def blocking(bench: Bench, *steps: str) -> str:
    return " ".join(check.sentence for check in accept(bench, steps).checks if check.blocks)


def move(angle_deg: float, duration_s: float) -> Callable[[float], Motion]:
    legs = (Leg(np.deg2rad(angle_deg), duration_s, 0.5), Leg(0.0, duration_s, 0.5))
    return lambda _angle: Motion(legs, Operator.steady(), seed=1)


@pytest.mark.parametrize(
    ("angle_deg", "duration_s", "words"),
    [(25.0, 2.0, "Joint 1 was opened by 25 deg only"), (90.0, 5.0, "open when the reading ended")],
)
def test_a_joint_that_was_hardly_opened_or_too_slowly(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    angle_deg: float,
    duration_s: float,
    words: str,
) -> None:
    monkeypatch.setattr(emulated_hands, "_there_and_back", move(angle_deg, duration_s))
    with emulated_bench() as (bench, _):
        found = blocking(bench, "motion")
    assert words in found
    assert "Nothing was concluded" in found
    # It is asked for again before it is given up.
    assert capsys.readouterr().out.count("Once more") == 2


def test_the_wrong_joint_is_asked_for_again_and_then_right(capsys: pytest.CaptureFixture[str]) -> None:
    tries = 0

    def first_the_other(right: Do, task: Task, number: int) -> None:
        nonlocal tries
        tries += task is Task.OPEN_AND_CLOSE and number == 1
        right(task, 2 if (task, number, tries) == (Task.OPEN_AND_CLOSE, 1, 1) else number)

    with emulated_bench() as (bench, _):
        instead(bench, first_the_other)
        assert not blocking(bench, "rest", "motion")
    assert "Joint 2 was opened, not joint 1. Once more:" in capsys.readouterr().out


def test_a_tilt_the_other_way_is_no_mounting(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(emulated_hands, "TILT_RAD", -np.pi / 2)
    with emulated_bench() as (bench, _):
        found = blocking(bench, "rest", "motion")
    assert "all IMUs saw the robot tilt about body -x, not x" in found
    assert "mounted otherwise" not in found


@pytest.mark.parametrize("seed", range(1, 5))
def test_a_careful_persons_hands_blame_nothing(monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    person = Operator.human(seed)
    monkeypatch.setattr(emulated_hands, "_motion", lambda *legs: Motion(legs, person, seed))
    with emulated_bench() as (bench, _):
        assert not blocking(bench, "rest", "motion")


def test_servo_power_that_was_left_on_is_told() -> None:
    with emulated_bench() as (bench, robot):

        def leave_it_on(right: Do, task: Task, number: int) -> None:
            right(task, number)
            if task is Task.PRESS_BOTH_UNPOWERED:
                power_servos(robot)

        instead(bench, leave_it_on)
        assert "Servo power was on" in blocking(bench, "boards", "switches", "time")


def power_servos(robot: EmulatedRobot) -> None:
    for joint in (1, 2, 3):
        robot.faults.servo(joint, None)


def test_one_switch_that_is_kept_pressed_leaves_the_sequencer_safe() -> None:
    with emulated_bench() as (bench, robot):

        def let_one_go(right: Do, task: Task, number: int) -> None:
            if task is Task.LET_GO:
                robot.set_switch(1, False)
            else:
                right(task, number)

        instead(bench, let_one_go)
        assert "not let go within 60 s" in blocking(bench, "boards", "switches", "time")
        assert bench.sequencer.status().state.name == "SAFE"
