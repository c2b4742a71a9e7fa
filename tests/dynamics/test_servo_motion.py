"""A move is never faster than its servo; it arrives when the schedule says, or as soon as the servo can."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import JointHistory, TimedMove, history_from_moves, history_from_samples, servo_moves
from tfsat_host.dynamics.history import overshoots
from tfsat_host.robot import load_robot

ROBOT = load_robot()
SERVO = ROBOT.servos[0]


def looked_at(history: JointHistory) -> tuple[FloatArray, FloatArray]:
    t_s = np.linspace(history.breaks_s[0], history.breaks_s[-1], 4001)
    return t_s, history.rates_rad_s(t_s)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    delta_deg=st.floats(-180.0, 180.0).filter(lambda d: abs(d) > 1e-3),
    start_s=st.floats(-1.0, 3.0),
    duration_s=st.floats(1e-3, 100.0),
)
def test_rate_and_acceleration_stay_within_the_servos(
    delta_deg: float, start_s: float, duration_s: float
) -> None:
    delta = np.radians(delta_deg)
    history = history_from_moves(
        ROBOT, [TimedMove(0, delta, start_s, start_s + duration_s)], start_rad=np.full(3, 0.2)
    )
    pieces = history.coefficients[:, :, 0]
    assert 2.0 * np.abs(pieces[0]).max() <= SERVO.acceleration_rad_s2 * (1 + 1e-9)
    _, rates = looked_at(history)
    assert np.abs(rates).max() <= SERVO.max_rate_rad_s * (1 + 1e-9)
    ends = history.angles_rad(history.breaks_s[[0, -1]])
    assert ends[0] == pytest.approx(np.full(3, 0.2))
    assert ends[1] == pytest.approx([0.2 + delta, 0.2, 0.2], abs=1e-8)
    # No jumps between the pieces.
    before, _ = history.in_piece(np.arange(len(pieces[0])), np.diff(history.breaks_s)[:, None])
    assert pytest.approx(history.coefficients[-1, 1:], abs=1e-7) == before[:, :-1, 0].T


@pytest.mark.parametrize(
    ("delta_deg", "scheduled_s", "takes_s"),
    [
        (59.0, 59 / 170, 59 / 170),
        (45.0, 45 / 170, 45 / 200 + 200 / 4000),
        (5.0, 5 / 170, 2 * (5 / 4000) ** 0.5),
        (-5.0, 0.2, 0.2),
    ],
)
def test_a_move_arrives_on_schedule_or_as_soon_as_the_servo_can(
    delta_deg: float, scheduled_s: float, takes_s: float
) -> None:
    (move,) = servo_moves(ROBOT, [TimedMove(0, np.radians(delta_deg), 0.7, 0.7 + scheduled_s)])
    assert move.end_s - move.start_s == pytest.approx(takes_s)


def test_the_next_move_of_a_late_joint_waits_and_that_of_another_does_not() -> None:
    moves = [TimedMove(0, 0.1, 0.7, 0.75), TimedMove(0, -0.1, 0.75, 0.8), TimedMove(1, 0.1, 0.75, 0.8)]
    first, back, other = servo_moves(ROBOT, moves)
    assert first.end_s > 0.75
    assert back.start_s == first.end_s and other.start_s == 0.75
    assert history_from_moves(ROBOT, moves).angles_rad(np.array([0.76, 2.0]))[:, 1] == pytest.approx(
        [0.5 * SERVO.acceleration_rad_s2 * 0.01**2, 0.1]
    )


def test_very_slow_moves_arrive_too() -> None:
    history = history_from_moves(ROBOT, [TimedMove(0, 1e-3, 0.0, 1e7)])
    assert history.angles_rad(np.array([5e6, 1e7]))[:, 0] == pytest.approx([5e-4, 1e-3])


@pytest.mark.parametrize(
    ("move", "says"),
    [
        (TimedMove(-1, 1.0, 0.0, 1.0), "no joint -1"),
        (TimedMove(3, 1.0, 0.0, 1.0), "no joint 3"),
        (TimedMove(0, np.nan, 0.0, 1.0), "not finite"),
        (TimedMove(0, 1.0, 0.0, 0.0), "takes 0"),
        (TimedMove(0, 1.0, 0.5, 2.5), "overlap"),
    ],
)
def test_what_is_no_move_is_refused(move: TimedMove, says: str) -> None:
    with pytest.raises(ValueError, match=says):
        history_from_moves(ROBOT, [TimedMove(0, 1.0, 2.0, 3.0), move])


def test_start_angles_fit_the_robot() -> None:
    with pytest.raises(ValueError, match="do not fit"):
        history_from_moves(ROBOT, [], start_rad=np.zeros(2))


def test_a_splines_overshoot_is_found_where_it_is() -> None:
    t_s = np.array([0.0, 0.1, 0.2, 0.200002, 0.3, 0.4])
    history = history_from_samples(
        t_s, np.radians(np.array([[0.0, 0.0], [1, 1], [2, 2], [2.3, 2], [3, 3], [4, 4]]))
    )
    first, second = overshoots(history)
    dense = np.linspace(0.0, 0.4, 400_001)
    between = np.interp(dense, t_s, history.angles_rad(t_s)[:, 0])
    assert first.excess_rad == pytest.approx(
        np.abs(history.angles_rad(dense)[:, 0] - between).max(), rel=0.05
    )
    assert history.rates_rad_s(np.array([first.t_s]))[0, 0] == pytest.approx(0.0, abs=1e-6)
    assert second.excess_rad < 1e-3
    lines = history_from_samples(t_s, np.zeros((6, 1)), between="linear")
    assert overshoots(lines)[0].excess_rad == 0.0


@settings(derandomize=True)
@given(
    play_rad=st.floats(0.0, 0.02),
    commanded_rad=st.lists(st.floats(0.0, 1.6), min_size=1, max_size=8),
)
def test_a_joint_stops_within_half_the_play_and_goes_no_farther_than_it_must(
    play_rad: float, commanded_rad: list[float]
) -> None:
    servo, at_rad = replace(SERVO, play_rad=play_rad), 0.0
    for target_rad in commanded_rad:
        stop_rad = servo.stop_rad(at_rad, target_rad)
        assert abs(stop_rad - target_rad) <= 0.5 * play_rad + 1e-15
        # A command within the play moves nothing, another one moves the joint towards it.
        if abs(target_rad - at_rad) <= 0.5 * play_rad:
            assert stop_rad == at_rad
        else:
            assert min(at_rad, target_rad) <= stop_rad <= max(at_rad, target_rad)
        at_rad = stop_rad
