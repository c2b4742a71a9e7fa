"""The table of motion primitives: what each claims is what its strokes do."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.dynamics.random_robots import random_robot
from tfsat_host.dynamics import path_rotation, quaternion
from tfsat_host.plan.grid import OrbitError
from tfsat_host.plan.orbit.primitives import PrimitiveTable, primitive_table
from tfsat_host.robot import RobotModel


def test_every_primitive_turns_as_its_strokes_do(table: PrimitiveTable, nimble_table: PrimitiveTable) -> None:
    for robot_table in (table, nimble_table):
        for index in np.random.default_rng(3).integers(0, len(robot_table), 40):
            primitive = robot_table.primitive(int(index))
            joints, deltas = zip(*primitive.strokes, strict=True)
            exact = path_rotation(
                robot_table.body, joints, np.array(deltas), start_rad=robot_table.start_rad, steps=6
            )
            error = quaternion.product(quaternion.inverse(exact), primitive.quaternion_xyzw)
            assert np.degrees(quaternion.angle(error)) < 1e-3
            assert np.bincount(joints, deltas).tolist() == pytest.approx([0.0] * (max(joints) + 1))


@pytest.mark.parametrize(("seed", "limit_deg"), [(0, 90.0), (0, 180.0), (2, 90.0), (2, 180.0)])
def test_a_primitive_is_right_to_a_ten_thousandth_of_a_degree_whatever_the_robot(
    tmp_path: Path, seed: int, limit_deg: float
) -> None:
    robot = random_robot(tmp_path, seed, 3)
    limits_rad = np.radians([[-limit_deg, limit_deg]] * 2)
    robot_table = primitive_table(replace(robot, joint_limits_rad=limits_rad), limit_deg / 3.0)
    for index in range(0, len(robot_table), 4):
        primitive = robot_table.primitive(index)
        joints, deltas = zip(*primitive.strokes, strict=True)
        exact = path_rotation(
            robot_table.body, joints, np.array(deltas), start_rad=robot_table.start_rad, steps=40
        )
        error = quaternion.product(quaternion.inverse(exact), primitive.quaternion_xyzw)
        assert np.degrees(quaternion.angle(error)) < 1.5e-4


def test_durations_are_the_strokes_at_the_joints_rates(cubesat: RobotModel, table: PrimitiveTable) -> None:
    for index in (0, len(table) // 2, len(table) - 1):
        primitive = table.primitive(index)
        travel_deg = np.degrees(sum(abs(angle) for _, angle in primitive.strokes))
        assert primitive.duration_s == pytest.approx(travel_deg / 30.0)
        assert (
            table.primitive_of(primitive.shape, primitive.displacement_rad).duration_s == primitive.duration_s
        )


def test_only_useful_ones_are_kept_and_of_equals_the_fastest(table: PrimitiveTable) -> None:
    vectors = np.degrees(quaternion.logarithm(table.rotation))
    assert np.linalg.norm(vectors, axis=0).min() >= 0.02
    cells = np.round(vectors / 0.25)
    assert np.unique(cells, axis=1).shape[1] == len(table) < table.made
    assert (np.diff(table.duration_s) >= 0.0).all()


def test_limits_hold(nimble_table: PrimitiveTable) -> None:
    for index in np.random.default_rng(4).integers(0, len(nimble_table), 40):
        primitive = nimble_table.primitive(int(index))
        assert np.degrees(np.abs(primitive.displacement_rad)).max() <= 90.0 + 1e-9


def test_two_joints_are_enough(tmp_path: Path) -> None:
    table = primitive_table(random_robot(tmp_path, 7, 3), 15.0)
    assert {len(shape.joints) for shape in table.shapes} == {2}


def test_a_robot_that_cannot_turn_is_told_so(cubesat: RobotModel) -> None:
    parallel = replace(cubesat, joint_limits_rad=np.radians([[0.0, 0.1]] * 3))
    with pytest.raises(OrbitError, match="turns it by"):
        primitive_table(parallel, 0.1)
    with pytest.raises(OrbitError, match="Fewer than two joints"):
        primitive_table(parallel, 5.0)
