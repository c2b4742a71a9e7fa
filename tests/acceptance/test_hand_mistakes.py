"""What hands do wrong is told as that, and no wire is blamed for it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.acceptance.bench_in_emulation import accept, emulated_bench
from tfsat_host.acceptance import emulated_hands
from tfsat_host.acceptance.bench import Bench, StillArmed, Task
from tfsat_host.emulated.emulated_robot import EmulatedRobot
from tfsat_host.emulated.manual_motion import Leg, Motion, Operator
from tfsat_host.errors import TfsatError
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import SequencerState

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
    assert "Joint 2 was opened, not joint 1" in capsys.readouterr().out


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


@pytest.mark.parametrize(
    "failure", [TfsatError(what="It broke.", meaning="", next_step=""), KeyboardInterrupt()]
)
def test_a_step_that_fails_with_an_armed_board_leaves_it_safe(failure: BaseException) -> None:
    """Whoever armed it: no step ends with a board that is armed, nor does Ctrl-C."""
    with emulated_bench() as (bench, robot):

        def arm_and_fail(_right: Do, _task: Task, _number: int) -> None:
            arm(bench, robot)
            raise failure

        instead(bench, arm_and_fail)
        if isinstance(failure, TfsatError):
            assert "It broke." in blocking(bench, "rest")
        else:
            with pytest.raises(KeyboardInterrupt):
                accept(bench, ["rest"])
        assert bench.sequencer.status().state == SequencerState.SAFE


def test_a_board_that_answers_and_stays_armed_ends_the_session(monkeypatch: pytest.MonkeyPatch) -> None:
    with emulated_bench() as (bench, robot):
        arm(bench, robot)
        monkeypatch.setattr(bench.sequencer, "disarm", lambda: None)
        with pytest.raises(StillArmed, match=r"It says that it is armed\."):
            bench.disarm()


def arm(bench: Bench, robot: EmulatedRobot) -> None:
    for switch in (1, 2):
        robot.set_switch(switch, True)
    robot.advance(900_000)
    bench.sequencer.upload(schedule_maneuver(four_stroke(59.0, 70.0)))
    bench.sequencer.arm()
    assert bench.sequencer.status().state == SequencerState.ARMED


def accept_with_servos(bench: Bench) -> str:
    return blocking(bench, "boards", "motion", "switches", "servos", "supply")


def test_a_joint_that_is_open_is_not_armed(capsys: pytest.CaptureFixture[str]) -> None:
    """Armed, its servo would snap it shut before any release."""
    with emulated_bench() as (bench, robot):

        def leave_open(right: Do, task: Task, number: int) -> None:
            right(task, number)
            if task is Task.PRESS_BOTH_POWERED:
                motion = Motion((Leg(np.deg2rad(60.0), 1.0),), Operator.steady(), seed=1)
                robot.operator.move_joint(2, motion)
                robot.advance(2_500_000)

        instead(bench, leave_open)
        found = accept_with_servos(bench)
        assert "Supply" in found
        assert "not at its start pose" in found
        assert robot.joint_angles_deg()[1] == pytest.approx(60.0, abs=0.1)
        assert bench.sequencer.status().state.name == "SAFE"


def test_a_supply_that_moved_nothing_has_shown_nothing() -> None:
    with emulated_bench() as (bench, robot):

        def without_power(right: Do, task: Task, number: int) -> None:
            right(task, number)
            if task is Task.PRESS_BOTH_POWERED:
                for joint in (1, 2, 3):
                    robot.faults.servo(joint, "dead")

        instead(bench, without_power)
        assert "The supply was not tried" in accept_with_servos(bench)


def test_switches_that_are_pressed_again_are_no_wire() -> None:
    with emulated_bench() as (bench, robot):

        def press_again(right: Do, task: Task, number: int) -> None:
            right(task, number)
            if task is Task.LET_GO:
                robot.advance(900_000)
                for switch in (1, 2):
                    robot.set_switch(switch, True)

        instead(bench, press_again)
        found = blocking(bench, "boards", "switches", "time")
    assert "were the switches pressed again?" in found
    assert "Teensy pin 4" not in found


def test_joints_that_are_not_half_open_move_no_servo(capsys: pytest.CaptureFixture[str]) -> None:
    with emulated_bench() as (bench, robot):

        def close_them(right: Do, task: Task, number: int) -> None:
            right(task, number)
            if task is Task.OPEN_HALF:
                for joint in (1, 2, 3):
                    robot.operator.put_joint(joint)

        instead(bench, close_them)
        found = blocking(bench, "motion", "servos")
        assert "No servo was moved" in found
        assert max(map(abs, robot.joint_angles_deg())) < 0.1


def test_an_imu_that_falls_silent_when_it_is_moved_is_found() -> None:
    with emulated_bench() as (bench, robot):

        def shake_the_plug(right: Do, task: Task, number: int) -> None:
            right(task, number)
            robot.faults.imu(2, "dead" if (task, number) == (Task.OPEN_AND_CLOSE, 2) else None)

        instead(bench, shake_the_plug)
        found = blocking(bench, "rest", "motion")
    assert "IMUs when moved: silent in some motions: IMU 2 (address 0x69" in found
    assert "belongs" not in found


def test_the_other_side_of_a_joint_and_a_turn_about_the_vertical(capsys: pytest.CaptureFixture[str]) -> None:
    tries = 0

    def hold_the_wrong_side(right: Do, task: Task, number: int) -> None:
        nonlocal tries
        right(task, number)
        tries += (task, number) == (Task.OPEN_AND_CLOSE, 1)
        if tries == 1 and task is Task.OPEN_AND_CLOSE and number == 1:
            robot.hold([1])
            robot.operator.move_joint(1, move(90.0, 2.0)(0.0))
        if task is Task.TILT and not turned:
            turned.append(True)
            robot.operator.turn(np.array([0.0, 0.0, 1.0]), move(90.0, 2.0)(0.0))

    turned: list[bool] = []
    with emulated_bench() as (bench, robot):
        instead(bench, hold_the_wrong_side)
        assert not blocking(bench, "rest", "motion")
    told = capsys.readouterr().out
    assert "The other side of joint 1 was moved; move body 1. Once more:" in told
    assert "The robot was turned about the vertical, not tilted. Once more:" in told
