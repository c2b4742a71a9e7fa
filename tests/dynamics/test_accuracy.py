"""What is promised of the error is kept: of paths by themselves, of flights by halved steps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tests.dynamics.random_robots import random_robot, random_tree, write_robot_file
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import (
    JointHistory,
    Multibody,
    TimedMove,
    history_from_moves,
    history_from_samples,
    path_rotation,
    propagate,
    propagate_within,
)
from tfsat_host.robot import load_robot

FAST = np.radians([300.0, 200.0, 400.0])


def apart_deg(a: FloatArray, b: FloatArray) -> float:
    return float(np.degrees((Rotation.from_quat(a) * Rotation.from_quat(b).inv()).magnitude().max()))


def maneuver() -> tuple[Multibody, JointHistory]:
    robot = load_robot()
    moves = [TimedMove(0, 1.0, 0.1, 0.5), TimedMove(1, 1.2, 0.5, 1.0)]
    return Multibody.of(robot), history_from_moves(robot, moves, end_s=1.2)


@pytest.mark.parametrize("size_deg", [90.0, 180.0])
def test_a_path_is_right_to_a_ten_thousandth_of_a_degree_whatever_the_robot(
    tmp_path: Path, size_deg: float
) -> None:
    worst_of_two_steps, rng = 0.0, np.random.default_rng(1)
    for number in range(6):
        body = Multibody.of(load_robot(write_robot_file(random_tree(rng, 4), tmp_path / f"{number}.toml")))
        # There and back: a closed path of two joints.
        deltas = np.radians(size_deg) * np.array([[1, 1, -1, -1], [-1, 1, 1, -1.0]])
        joints = [int(j) for j in rng.permutation(3)[:2]] * 2
        exact = path_rotation(body, joints, deltas, steps=128)
        assert apart_deg(path_rotation(body, joints, deltas), exact) < 1e-4
        worst_of_two_steps = max(
            worst_of_two_steps, apart_deg(path_rotation(body, joints, deltas, steps=2), exact)
        )
    # Two steps a stroke are too few, so that the comparison tells something.
    assert worst_of_two_steps > 1e-3


def test_a_flight_is_within_its_tolerance_along_the_whole_way() -> None:
    body, history = maneuver()
    estimate = propagate_within(body, history, initial_rate_rad_s=FAST)
    parts = propagate(body, history, initial_rate_rad_s=FAST, step_s=2e-3, order=6)
    assert estimate.within_tolerance and np.degrees(estimate.error_rad) < 1e-4
    for t_s in np.linspace(0.0, 1.2, 7):
        i, k = (int(np.abs(flight.t_s - t_s).argmin()) for flight in (estimate.flight, parts))
        if abs(estimate.flight.t_s[i] - parts.t_s[k]) < 1e-12:
            assert apart_deg(estimate.flight.quaternion_xyzw[i], parts.quaternion_xyzw[k]) < 1e-4
    assert apart_deg(estimate.flight.quaternion_xyzw[-1], parts.quaternion_xyzw[-1]) < 1e-4


def test_the_estimate_is_no_smaller_than_the_error() -> None:
    body, history = maneuver()
    exact = propagate(body, history, initial_rate_rad_s=FAST, step_s=2e-3, order=6).quaternion_xyzw[-1]
    for order in (4, 6):
        for step_s in (0.05,):
            estimate = propagate_within(
                body, history, initial_rate_rad_s=FAST, step_s=step_s, order=4 if order == 4 else 6
            )
            error_deg = apart_deg(estimate.flight.quaternion_xyzw[-1], exact)
            assert error_deg <= 1.1 * np.degrees(estimate.error_rad)
            assert error_deg > 1e-7  # there is something to estimate


def test_where_the_bound_of_steps_is_hit_it_says_so() -> None:
    body, history = maneuver()
    estimate = propagate_within(body, history, initial_rate_rad_s=100.0 * FAST, steps_max=500)
    # Not within its tolerance, and no more steps than were allowed.
    assert not estimate.within_tolerance and len(estimate.flight.t_s) <= 501
    assert np.degrees(estimate.error_rad) > 1.0


def test_one_rigid_body_tumbles_as_eulers_equations_say(tmp_path: Path) -> None:
    robot = random_robot(tmp_path, 8, 1)
    body, inertia, rate = Multibody.of(robot), robot.inertia_kg_m2[0], np.array([1.0, 2.0, 0.3])

    def tumble(_t: float, state: FloatArray) -> list[float]:
        w, vector, scalar = state[:3], state[3:6], state[6]
        # Euler's equations in the body's own axes, and its attitude.
        turn = np.linalg.solve(inertia, np.cross(inertia @ w, w))
        return [*turn, *(0.5 * (scalar * w + np.cross(vector, w))), -0.5 * (vector @ w)]

    expected = solve_ivp(tumble, (0.0, 2.0), [*rate, 0, 0, 0, 1], rtol=1e-11, atol=1e-12, method="DOP853")
    for history in (
        history_from_moves(robot, [], end_s=2.0),
        history_from_samples(np.array([0.0, 1.0, 2.0]), np.zeros((3, 0))),
        history_from_samples(np.array([0.0, 2.0]), np.zeros((2, 0)), between="linear"),
    ):
        flight = propagate_within(body, history, initial_rate_rad_s=rate).flight
        assert apart_deg(flight.quaternion_xyzw[-1], expected.y[3:, -1]) < 1e-4
        # One rigid body: energy and momentum are both constant.
        assert flight.kinetic_energy_j() == pytest.approx(0.5 * rate @ inertia @ rate)
        assert flight.momentum()[-1] == pytest.approx(inertia @ rate)


def test_what_is_no_flight_is_refused() -> None:
    body, history = maneuver()
    with pytest.raises(ValueError, match="no order 5"):
        propagate(body, history, order=5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="no attitude"):
        propagate(body, history, initial_attitude_xyzw=np.zeros(4))
    with pytest.raises(ValueError, match="no angular rate"):
        propagate(body, history, initial_rate_rad_s=np.array([0.0, np.nan, 0.0]))
    with pytest.raises(ValueError, match="cannot be kept"):
        propagate_within(body, history, tolerance_rad=0.0)


def test_an_attitude_of_any_length_is_the_attitude() -> None:
    body, history = maneuver()
    attitude = np.array([0.1, -0.2, 0.3, 0.4])
    flight, unit = (
        propagate(body, history, initial_attitude_xyzw=q, initial_rate_rad_s=FAST)
        for q in (attitude, attitude / np.linalg.norm(attitude))
    )
    assert flight.quaternion_xyzw == pytest.approx(unit.quaternion_xyzw, abs=1e-12)
    assert flight.momentum() == pytest.approx(unit.momentum(), abs=1e-12)
