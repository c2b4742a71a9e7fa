"""Targets approached with feedback: what can be relied on, whatever the robot, the target and the errors."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tfsat_host.dynamics import path_rotation, quaternion
from tfsat_host.plan.orbit.orbit_flight import (
    AttitudeSensor,
    Flight,
    drawn_robot,
    fly,
    fly_primitive,
    open_loop_error_rad,
)
from tfsat_host.plan.orbit.orbit_planner import Planner
from tfsat_host.plan.orbit.primitives import PrimitiveTable
from tfsat_host.robot import RobotModel

DEG = float(np.radians(1.0))


def errors(flight: Flight) -> list[float]:
    return [flight.start_error_rad, *(step.error_rad for step in flight.steps)]


@pytest.mark.parametrize("seed", range(2))
def test_greedy_lookup_never_loses_ground_when_the_model_is_right(
    nimble_table: PrimitiveTable, table: PrimitiveTable, seed: int
) -> None:
    target = Rotation.random(random_state=seed).as_quat()
    for primitive_table in (nimble_table, table):
        flight = fly(Planner.of(primitive_table, "greedy", 2.0 * DEG, trim=False, most=60), target)
        assert flight.steps
        # Every step brings the error down.
        assert (np.diff(errors(flight)) < 0.0).all()
        for step in flight.steps:
            # Without noise the measured error is the true one.
            assert np.degrees(step.error_rad) == pytest.approx(np.degrees(step.measured_error_rad))


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.prove)])
def test_a_nimble_robot_reaches_any_target_in_few_primitives(nimble_table: PrimitiveTable, seed: int) -> None:
    target = Rotation.random(random_state=seed).as_quat()
    start = Rotation.random(random_state=100 + seed).as_quat()
    for method in ("greedy", "search"):
        flight = fly(Planner.of(nimble_table, method, 0.1 * DEG), target, initial_xyzw=start)
        assert flight.reached and flight.outcome == "within tolerance"
        assert len(flight.steps) <= 6
        assert flight.error_rad <= 0.1 * DEG


@pytest.mark.parametrize("target_deg", [(170.0, 0.0, 0.0), (-60.0, 10.0, -8.0), (20.0, -15.0, 12.0)])
def test_the_cubesat_reaches_what_only_detours_lead_to(
    table: PrimitiveTable, target_deg: tuple[float, ...]
) -> None:
    target = Rotation.from_euler("ZYX", target_deg, degrees=True).as_quat()
    flight = fly(Planner.of(table, "search", DEG), target)
    assert flight.reached and len(flight.steps) <= 30


def test_the_steps_are_what_was_flown(cubesat: RobotModel, table: PrimitiveTable) -> None:
    plant = drawn_robot(cubesat, 1.0, 4)
    target = Rotation.from_euler("ZYX", [60.0, 0.0, 0.0], degrees=True).as_quat()
    flight = fly(Planner.of(table, "search", DEG), target, plant=plant)
    attitude = np.array([0.0, 0.0, 0.0, 1.0])
    for step in flight.steps:
        joints, deltas = zip(*step.primitive.strokes, strict=True)
        # The attitude is the product of the strokes that were flown.
        attitude = quaternion.product(attitude, path_rotation(plant, joints, np.array(deltas)))
        assert np.abs(attitude - step.attitude_xyzw).max() < 1e-12
    expected = (Rotation.from_quat(attitude).inv() * Rotation.from_quat(target)).magnitude()
    assert flight.error_rad == pytest.approx(expected)
    assert flight.duration_s == pytest.approx(sum(step.primitive.duration_s for step in flight.steps))


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.prove)])
def test_feedback_beats_open_loop_when_the_model_is_wrong(
    cubesat: RobotModel, table: PrimitiveTable, seed: int
) -> None:
    plant = drawn_robot(cubesat, 3.0, seed)
    target = Rotation.from_euler("ZYX", [90.0, 0.0, 0.0], degrees=True).as_quat()
    planner = Planner.of(table, "search", 0.5 * DEG)
    flight = fly(planner, target, plant=plant)
    blind = open_loop_error_rad(planner, target, plant=plant)
    assert flight.reached
    # Blind, it ends outside of the tolerance; with feedback, inside of it.
    assert blind > 2.0 * flight.tolerance_rad > flight.error_rad


def test_without_an_error_open_loop_is_as_good(table: PrimitiveTable) -> None:
    target = Rotation.from_euler("ZYX", [90.0, 0.0, 0.0], degrees=True).as_quat()
    planner = Planner.of(table, "search", 0.5 * DEG)
    assert open_loop_error_rad(planner, target, plant=table.body) <= 0.5 * DEG


def test_when_nothing_helps_any_more_it_says_what_is_possible(table: PrimitiveTable) -> None:
    target = Rotation.from_euler("ZYX", [90.0, 0.0, 0.0], degrees=True).as_quat()
    flight = fly(Planner.of(table, "greedy", 1e-4 * DEG, trim=False), target)
    assert flight.outcome == "no progress" and not flight.reached
    assert flight.error_rad == flight.least_error_rad > 1e-4 * DEG
    possible = fly(Planner.of(table, "greedy", 1.05 * flight.least_error_rad, trim=False), target)
    assert possible.reached
    trimmed = fly(Planner.of(table, "greedy", 1e-4 * DEG), target)
    # A trim of the last loop reaches what the grid alone does not.
    assert trimmed.reached


def test_the_most_primitives_are_kept_to(table: PrimitiveTable) -> None:
    target = Rotation.from_euler("ZYX", [180.0, 0.0, 0.0], degrees=True).as_quat()
    flight = fly(Planner.of(table, "greedy", DEG, trim=False, most=2), target)
    assert flight.outcome == "primitives used up" and len(flight.steps) == 2 and not flight.reached


def test_noise_above_the_tolerance_does_not_pass_for_success(table: PrimitiveTable) -> None:
    target = Rotation.from_euler("ZYX", [30.0, 0.0, 0.0], degrees=True).as_quat()
    believed = 0
    for seed in range(6):
        planner = Planner.of(table, "greedy", 0.5 * DEG, trim=False, most=25)
        flight = fly(planner, target, sensing=AttitudeSensor(0.5 * DEG, seed))
        # What is reached is judged by the truth, not by the noisy measurement.
        assert flight.reached == (flight.error_rad <= 0.5 * DEG)
        believed += flight.outcome == "within tolerance" and not flight.reached
        assert (flight.outcome == "within tolerance") == (flight.steps[-1].measured_error_rad <= 0.5 * DEG)
    # At least one flight believed to be there and was not.
    assert believed


def test_at_the_target_nothing_moves(table: PrimitiveTable) -> None:
    flight = fly(Planner.of(table, "search", DEG), np.array([0.0, 0.0, 0.0, -2.0]))
    assert flight.reached and flight.steps == () and flight.duration_s == 0.0


def test_a_drawn_robot_differs_as_its_file_says(cubesat: RobotModel, table: PrimitiveTable) -> None:
    shifts_mm = np.array(
        [1e3 * (drawn_robot(cubesat, 1.0, seed).com_m - table.body.com_m) for seed in range(60)]
    )
    assert shifts_mm.std() == pytest.approx(1.5, rel=0.1)
    assert abs(shifts_mm.mean()) < 0.2
    twice_mm = 1e3 * (drawn_robot(cubesat, 2.0, 0).com_m - table.body.com_m)
    # Twice the uncertainty is twice the shift, drawn from the same numbers.
    assert twice_mm == pytest.approx(2.0 * shifts_mm[0])


def test_backwards_undoes_a_primitive_on_any_robot(cubesat: RobotModel, table: PrimitiveTable) -> None:
    plant = drawn_robot(cubesat, 3.0, 1)
    for index in (0, 1000, len(table) - 1):
        primitive = table.primitive(index)
        there = fly_primitive(plant, table, primitive)
        back = fly_primitive(plant, table, primitive.backwards)
        # There and back: the rotation itself, not just its angle.
        assert quaternion.angle(quaternion.product(there, back)) < 1e-9
