"""What errors of a calibration do to the final attitude: against closed forms, and against simulated flights."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tfsat_host.dynamics import Multibody, TimedMove, moved, propagate
from tfsat_host.dynamics.flying import fly_schedule, timed_moves
from tfsat_host.evaluation.attitude import integrate_rates
from tfsat_host.evaluation.budget.attitude_budget import CALIBRATED, UNCALIBRATED, Accuracies, attitude_budget
from tfsat_host.evaluation.budget.attitude_budget_table import budget_table
from tfsat_host.evaluation.budget.attitude_errors import Turned
from tfsat_host.evaluation.budget.gyro_errors import Fall, bias, fall_of, misalignment, noise, scale, timing
from tfsat_host.evaluation.budget.prediction_errors import Path as StrokePath
from tfsat_host.evaluation.budget.prediction_errors import stroke_ends, zero_point
from tfsat_host.maneuver import Schedule, four_stroke, schedule_maneuver
from tfsat_host.robot import RobotModel, load_robot

FloatArray = NDArray[np.float64]

ANGLE_DEG, FALL_S = 26.0, 2.5
DOCUMENT = Path(__file__).parents[2] / "docs" / "calibration.md"


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return load_robot()


@pytest.fixture(scope="module")
def schedule() -> Schedule:
    return schedule_maneuver(four_stroke(59.0, 70.0))


def steady_turn(axis: FloatArray, sensor_to_body: FloatArray | None = None) -> Fall:
    """26 deg about an axis that stays, at a steady rate."""
    t_s = np.linspace(0.0, FALL_S, 701)
    rate = np.radians(ANGLE_DEG) / FALL_S * np.tile(axis, (len(t_s), 1))
    return Fall.of(t_s, rate, np.eye(3) if sensor_to_body is None else sensor_to_body)


X, _, Z = np.eye(3)


def expect(found: tuple[Turned, Turned], attitude_deg: float, reorientation_deg: float, rel: float) -> None:
    for turned in found:
        assert turned.attitude_deg == pytest.approx(attitude_deg, rel=rel)
        assert turned.reorientation_deg == pytest.approx(reorientation_deg, rel=rel, abs=1e-6)


@pytest.mark.parametrize("body", [1, 2, 3])
def test_the_rates_of_each_body_lead_to_the_simulated_attitude(
    robot: RobotModel, schedule: Schedule, body: int
) -> None:
    fall = fall_of(robot, schedule, body, 280.0, FALL_S)
    simulated = fly_schedule(robot, schedule, until_s=FALL_S, base=body - 1)
    by_gyro = Rotation.from_quat(fall.attitude[:, -1])
    assert np.degrees((by_gyro.inv() * Rotation.from_quat(simulated.quaternion_xyzw)).magnitude()) < 0.01
    assert np.degrees(by_gyro.magnitude()) == pytest.approx(26.0, abs=0.3)
    by_evaluation = integrate_rates(fall.t_s, fall.rate_rad_s)[-1]
    assert (by_gyro.inv() * by_evaluation).magnitude() < 1e-5, "the budget's steps take turns to commute"


@pytest.mark.parametrize("accuracies", [CALIBRATED, UNCALIBRATED], ids=["calibrated", "uncalibrated"])
@pytest.mark.parametrize("body", [1, 2, 3])
def test_the_first_order_and_the_exact_effect_agree(
    robot: RobotModel, schedule: Schedule, body: int, accuracies: Accuracies
) -> None:
    for effect in attitude_budget(robot, schedule, body, accuracies).effects:
        exact, near = effect.exact, effect.first_order
        assert near.attitude_deg == pytest.approx(exact.attitude_deg, rel=0.05), effect.source
        assert near.reorientation_deg == pytest.approx(exact.reorientation_deg, rel=0.05, abs=1e-5), (
            effect.source
        )


def test_a_misaligned_gyro_sees_the_same_turn_about_a_turned_axis(
    robot: RobotModel, schedule: Schedule
) -> None:
    fall = fall_of(robot, schedule, 1, 280.0, FALL_S)
    whole = Rotation.from_quat(fall.attitude[:, -1])
    # C w instead of w leads to C R C^T instead of R: its angle is right, and an error across its axis turns the
    # attitude by 2 sin(angle / 2) of itself.
    both_across = 2.0**0.5 * 2.0 * np.sin(whole.magnitude() / 2.0)
    expect(misalignment(fall, np.radians(0.1)), 0.1 * both_across, 0.0, rel=1e-3)


def test_a_scale_error_is_its_share_of_a_turn_about_one_axis() -> None:
    expect(scale(steady_turn(Z), 0.002), 0.002 * ANGLE_DEG, 0.002 * ANGLE_DEG, rel=1e-3)


def test_scale_errors_are_along_the_axes_of_the_sensor() -> None:
    askew = Rotation.from_rotvec([0.0, 0.0, np.pi / 4.0]).as_matrix()
    whole, half = 0.002 * ANGLE_DEG, np.radians(ANGLE_DEG) / 2.0
    # x and y of the sensor each see cos 45 deg of the turn. What they add lies 45 deg from the turn's axis: half of its
    # square along it, half across, where the body's turn averages.
    attitude = whole * (0.5 + 0.5 * (np.sin(half) / half) ** 2) ** 0.5
    expect(scale(steady_turn(X, askew), 0.002), attitude, whole / 2.0**0.5, rel=1e-3)


def test_a_bias_adds_up_over_the_fall_but_for_what_the_turn_averages() -> None:
    half = np.radians(ANGLE_DEG) / 2.0
    along, across = 0.02 * FALL_S, 0.02 * FALL_S * np.sin(half) / half
    attitude = (along**2 + 2.0 * across**2) ** 0.5
    expect(bias(steady_turn(Z), np.radians(0.02)), attitude, along, rel=1e-3)


def test_noise_walks_at_random() -> None:
    walk = 0.005 * (FALL_S / 2.0) ** 0.5
    expect(noise(steady_turn(Z), np.radians(0.005)), 3.0**0.5 * walk, walk, rel=0.05)


def test_of_a_steady_turn_only_the_times_of_its_ends_matter() -> None:
    error = 2.0**0.5 * 1e-4 * ANGLE_DEG / FALL_S
    expect(timing(steady_turn(Z), 1e-4), error, error, rel=0.05)


@pytest.mark.parametrize("body", [1, 2, 3])
def test_errors_of_the_joint_angles_are_those_of_simulated_flights(
    robot: RobotModel, schedule: Schedule, body: int
) -> None:
    path = StrokePath.of(robot, schedule, body)
    size = np.radians(1.0)
    zeros = [(sense * size * np.eye(3)[joint], np.zeros(4)) for joint in range(3) for sense in (1, -1)]
    by_hand = np.array([[1, 0, -1, 0], [0, 1, 0, -1], [0, 0, 1, 0], [0, 0, 0, 1]])
    ends = [(np.zeros(3), sense * size * change) for change in by_hand for sense in (1, -1)]
    for found, cases in ((zero_point(path, size), zeros), (stroke_ends(path, size), ends)):
        flown = [flown_error_deg(robot, schedule, body, *case) for case in cases]
        attitude, reorientation = (
            float((np.array(errors) ** 2).sum() / 2.0) ** 0.5 for errors in zip(*flown, strict=True)
        )
        assert found[1].attitude_deg == pytest.approx(attitude, rel=1e-3)
        assert found[1].reorientation_deg == pytest.approx(reorientation, rel=1e-3)


def flown_error_deg(
    robot: RobotModel, schedule: Schedule, body: int, start_rad: FloatArray, longer_rad: FloatArray
) -> tuple[float, float]:
    """Of the final attitude and its angle, by propagation in time."""
    true, wrong = (
        final_attitude(robot, schedule, body, *case)
        for case in ((np.zeros(3), np.zeros(4)), (start_rad, longer_rad))
    )
    return tuple(
        np.degrees([(wrong * true.inv()).magnitude(), wrong.magnitude() - true.magnitude()]).tolist()
    )


def final_attitude(
    robot: RobotModel, schedule: Schedule, body: int, start_rad: FloatArray, longer_rad: FloatArray
) -> Rotation:
    moves = [
        TimedMove(move.joint, move.delta_rad + longer, move.start_s, move.end_s)
        for move, longer in zip(timed_moves(schedule), longer_rad, strict=True)
    ]
    history = moved(robot, moves, start_rad=start_rad, end_s=FALL_S)
    return Rotation.from_quat(propagate(Multibody.of(robot, body - 1), history).quaternion_xyzw[-1])


def test_the_totals_are_roots_of_sums_of_squares(robot: RobotModel, schedule: Schedule) -> None:
    budget = attitude_budget(robot, schedule, 1, CALIBRATED)
    squares = {
        measured: sum(e.exact.attitude_deg**2 for e in budget.effects if e.measured is measured)
        for measured in (True, False)
    }
    assert budget.of_gyro().attitude_deg == pytest.approx(squares[True] ** 0.5)
    assert budget.of_prediction().attitude_deg == pytest.approx(squares[False] ** 0.5)
    assert budget.of_difference().attitude_deg == pytest.approx(sum(squares.values()) ** 0.5)


def test_the_table_in_the_guide_is_the_one_that_is_computed(robot: RobotModel, schedule: Schedule) -> None:
    text = DOCUMENT.read_text(encoding="utf-8")
    shown = text.split("<!-- budget -->")[1].split("<!-- /budget -->")[0]
    assert shown.strip() == budget_table(robot, schedule).strip()
