"""Servos and switches that break, as motion, status and log tell it; also with the sequencer's real image."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.emulator.fault_bench import SEED, do_nothing, fly
from tests.fixtures.emulated_drop import Act, read_card, releaser
from tfsat_host.devices.board_errors import BoardRefusal
from tfsat_host.emulated.emulated_robot import EmulatedRobot, Reset
from tfsat_host.emulated.imperfections import ideal
from tfsat_host.maneuver import Maneuver, Stroke, four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import ErrorCode, ResetCause, SequencerState
from tfsat_host.protocol.limits import RELEASE_BOUNCE_US, RELEASE_CHATTER_US
from tfsat_host.protocol.messages import SequencerStatusReply
from tfsat_host.rehearsal.faults.board_faults import WEAK_BATTERY_OHM

BOTH = pytest.mark.parametrize("sequencer", ["native", "avr"])


def record_flight(
    sequencer: str, before_drop: Act, until_us: int = 2_450_000
) -> tuple[NDArray[np.float64], SequencerStatusReply]:
    """(n, 3) true joint angles, deg, each ms from just before the release; the status at the end."""
    with releaser(seed=SEED, imperfections=ideal(), sequencer=sequencer) as (robot, board, _):
        fly(robot, board, before_drop, until_us=until_us)
        return np.rad2deg(robot.truth()[:, 1:4]), board.status()


@BOTH
def test_a_dead_servo_never_moves_its_joint_and_the_others_fly_on(sequencer: str) -> None:
    joints, status = record_flight(sequencer, lambda robot: robot.faults.servo(1, "dead"))
    assert np.ptp(joints[:, 0]) < 1e-6
    assert joints[:, 1].max() > 69.0
    assert status.state == SequencerState.DONE and status.strokes_started == 4


@BOTH
def test_a_slow_servo_has_a_quarter_of_its_rate(sequencer: str) -> None:
    joints, _ = record_flight(sequencer, lambda robot: robot.faults.servo(2, "slow"))
    good, _ = record_flight(sequencer, do_nothing)
    # A good servo is at 70 deg after 0.4 s; this one is still on its way when it is called back after 0.77 s.
    assert good[:, 1].max() == pytest.approx(70.0, abs=0.1)
    assert joints[1250, 1] - joints[1150, 1] == pytest.approx(5.0, abs=0.05)
    assert joints[:, 1].max() == pytest.approx(50.0 * 0.77, abs=0.5)
    assert joints[:, 0].max() == pytest.approx(59.0, abs=0.1)


@BOTH
def test_a_reversed_servo_goes_to_the_mirrored_angle(sequencer: str) -> None:
    joints, _ = record_flight(sequencer, lambda robot: robot.faults.servo(1, "reversed"))
    assert joints[0, 0] == pytest.approx(0.0, abs=0.1)
    # Mirrored at 45 deg: 0 is 90, and 59 is 31.
    assert joints[650, 0] == pytest.approx(90.0, abs=0.1)
    assert joints[:, 0].max() == pytest.approx(90.0, abs=0.1)
    assert joints[700:1400, 0].min() == pytest.approx(31.0, abs=0.2)


@pytest.mark.parametrize("kind", ["dead", "slow", "reversed"])
@pytest.mark.parametrize("when_us", range(700_000, 1_000_000, 37_000))
def test_a_servo_may_break_in_the_middle_of_a_stroke_without_a_jump(kind: str, when_us: int) -> None:
    """It turns with 200 deg/s at most, and no faster changes its rate than with 4000 deg/s^2."""
    with releaser(seed=SEED, imperfections=ideal()) as (robot, board, _):
        fly(robot, board, do_nothing, until_us=when_us)
        at_fault = robot.truth()[-1, 1]
        robot.faults.servo(1, kind)  # type: ignore[arg-type]
        robot.advance(200_000)
        robot.faults.servo(1, None)
        robot.advance(600_000)
        truth = robot.truth()
    joint, period_s = np.rad2deg(truth[:, 1]), np.diff(truth[:, 0])
    rates_deg_s = np.diff(joint) / period_s
    assert np.abs(rates_deg_s).max() < 200.1
    assert np.abs(np.diff(rates_deg_s)).max() < 4000 * 1.01 * period_s.max()
    if kind == "dead":
        braking_deg = 200.0**2 / 2 / 4000
        assert np.abs(joint - np.rad2deg(at_fault))[-600:-590].max() < braking_deg + 0.1


@BOTH
def test_a_servo_that_is_well_again_follows_its_pulses(sequencer: str) -> None:
    with releaser(seed=SEED, imperfections=ideal(), sequencer=sequencer) as (robot, board, _):
        fly(robot, board, lambda robot: robot.faults.servo(1, "dead"), until_us=1_000_000)
        assert robot.joint_angles_deg()[0] == pytest.approx(0.0, abs=1e-6)
        robot.faults.servo(1, None)
        robot.advance(400_000)
        assert robot.joint_angles_deg()[0] == pytest.approx(59.0, abs=0.1)


TWO_AT_ONCE = (Stroke(1, 60, 0.7), Stroke(2, 60, 0.7), Stroke(1, -60, 1.3), Stroke(2, -60, 1.3))
THREE_AT_ONCE = (Stroke(1, 60, 0.7), Stroke(2, 60, 0.7), Stroke(3, 60, 0.9), Stroke(1, -60, 1.5))


@pytest.mark.parametrize(
    ("strokes", "battery_ohm", "dips"),
    [
        (TWO_AT_ONCE, WEAK_BATTERY_OHM, False),
        (THREE_AT_ONCE, WEAK_BATTERY_OHM, True),
        (THREE_AT_ONCE, None, False),
    ],
    ids=["two, weak", "three, weak", "three, sound"],
)
def test_a_weak_battery_carries_two_servos_and_not_three(
    strokes: tuple[Stroke, ...], battery_ohm: float | None, dips: bool
) -> None:
    with releaser(seed=SEED, imperfections=ideal()) as (robot, board, _):
        schedule = schedule_maneuver(Maneuver(strokes))
        fly(robot, board, lambda robot: robot.faults.battery(battery_ohm), schedule=schedule)
        status = board.status()
    assert (status.state == SequencerState.FAULT) == dips
    assert (status.reset_cause == ResetCause.BROWN_OUT) == dips
    assert status.fault == (ErrorCode.RESET_WHILE_RUNNING if dips else ErrorCode.NONE)


@BOTH
def test_with_a_switch_stuck_closed_the_robot_falls_without_a_stroke(sequencer: str) -> None:
    joints, status = record_flight(sequencer, lambda robot: robot.faults.switch(2, "stuck-closed"))
    assert status.state == SequencerState.ARMED and status.strokes_started == 0
    assert np.ptp(joints, axis=0).max() < 1e-6


@BOTH
def test_with_a_switch_stuck_open_it_does_not_arm(sequencer: str) -> None:
    with releaser(seed=SEED, sequencer=sequencer) as (robot, board, logger):
        board.upload(schedule_maneuver(four_stroke(59, 70)))
        robot.faults.switch(1, "stuck-open")
        robot.seat()
        robot.advance(100_000)
        assert logger.status().switches_open == 0b01
        with pytest.raises(BoardRefusal, match="switch"):
            board.arm()
        robot.faults.switch(1, None)
        robot.advance(100_000)
        assert logger.status().switches_open == 0
        assert board.arm() == SequencerState.ARMED


@BOTH
@pytest.mark.parametrize("bounce_us", [5_000, 50_000, 120_000])
def test_contacts_bounce_for_as_long_as_they_are_told(sequencer: str, bounce_us: int) -> None:
    with releaser(seed=SEED, imperfections=ideal(), sequencer=sequencer) as (robot, board, logger):
        logger.start_recording()
        fly(robot, board, lambda robot: robot.faults.bounce(bounce_us))
        assert board.status().state == SequencerState.DONE
        logger.stop_recording()
        log = read_card(robot)
        released_us = robot.released_us
    noted_us = [event.t_us - released_us for event in log.events if event.name == "switch_edge"]
    assert max(noted_us) == pytest.approx(bounce_us, abs=700)
    assert len(noted_us) > bounce_us / 1000
    # The schedule counts from the first edge, but for contacts that chatter too long (protocol/tfsat.toml, [release]).
    late_us = min(event.t_us for event in log.events if event.name == "stroke") - released_us - 700_000
    if bounce_us <= RELEASE_BOUNCE_US:
        assert 0 <= late_us < 50
    else:
        assert bounce_us - RELEASE_BOUNCE_US <= late_us <= bounce_us
        assert log.release is not None
        earliest_us, latest_us = log.release.interval_us
        assert latest_us == pytest.approx(released_us + bounce_us, abs=1500)
        assert (earliest_us <= released_us + 1) == (bounce_us < RELEASE_CHATTER_US)


def test_good_contacts_bounce_for_a_few_milliseconds() -> None:
    with releaser(seed=SEED) as (robot, board, logger):
        logger.start_recording()
        fly(robot, board, do_nothing, until_us=100_000)
        logger.stop_recording()
        log = read_card(robot)
        noted_us = [event.t_us - robot.released_us for event in log.events if event.name == "switch_edge"]
    assert 2 <= len(noted_us) <= 14
    assert max(noted_us) < 4_000


@BOTH
@pytest.mark.parametrize("cause", [Reset.WATCHDOG, Reset.BROWN_OUT])
def test_a_reset_while_armed_is_survived(sequencer: str, cause: Reset) -> None:
    def reset(robot: EmulatedRobot) -> None:
        robot.reset(cause)
        robot.advance(1_000_000)

    joints, status = record_flight(sequencer, reset)
    assert status.state == SequencerState.DONE and status.strokes_started == 4
    assert status.resets_while_armed == 1
    assert joints[:, :2].max(axis=0) == pytest.approx([59.0, 70.0], abs=0.1)


@BOTH
@pytest.mark.parametrize("cause", [Reset.WATCHDOG, Reset.BROWN_OUT])
@pytest.mark.parametrize("after_us", [300_000, 800_000, 1_300_000])
def test_a_reset_while_falling_ends_the_run_with_the_joints_held(
    sequencer: str, cause: Reset, after_us: int
) -> None:
    with releaser(seed=SEED, imperfections=ideal(), sequencer=sequencer) as (robot, board, _):
        fly(robot, board, do_nothing, until_us=after_us)
        robot.reset(cause)
        robot.advance(500_000)
        held_deg = robot.joint_angles_deg()
        robot.advance(600_000)
        assert robot.joint_angles_deg() == pytest.approx(held_deg, abs=1e-6)
        status = board.status()
    assert status.state == SequencerState.FAULT
    assert status.fault == ErrorCode.RESET_WHILE_RUNNING
    assert status.reset_cause == (ResetCause.WATCHDOG if cause == Reset.WATCHDOG else ResetCause.BROWN_OUT)


@BOTH
def test_a_reset_at_the_very_release_is_a_fault_or_a_flight_and_never_a_stroke_at_a_wrong_time(
    sequencer: str,
) -> None:
    for after_us in (0, 2_000, 4_000, 6_000, 10_000):
        with releaser(seed=SEED, imperfections=ideal(), sequencer=sequencer) as (robot, board, _):
            fly(robot, board, do_nothing, until_us=after_us)
            robot.reset(Reset.BROWN_OUT)
            robot.advance(2_400_000)
            status = board.status()
            moved = np.ptp(np.rad2deg(robot.truth()[:, 1:4]), axis=0).max()
        assert status.state == SequencerState.FAULT
        assert moved < 1e-6
