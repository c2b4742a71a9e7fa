"""Loops of which one joint is held aside while the others repeat theirs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.cli.process import RunCli
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import path_rotation, quaternion
from tfsat_host.plan.loops import sequences
from tfsat_host.plan.orbit.chain_polish import join_repeats
from tfsat_host.plan.orbit.primitives import Primitive, PrimitiveTable, Shape

CASE = "z:125.95,y:-5.19,x:-6.55"


def rotation_of_strokes(table: PrimitiveTable, primitive: Primitive) -> FloatArray:
    joints, deltas = zip(*primitive.strokes, strict=True)
    return path_rotation(table.body, joints, np.array(deltas), start_rad=table.start_rad, steps=6)


def angle_between_deg(a: FloatArray, b: FloatArray) -> float:
    return math.degrees(float(quaternion.angle(quaternion.product(quaternion.inverse(a), b))))


def random_primitives(table: PrimitiveTable) -> list[Primitive]:
    """Every held-aside order of the first three joints, 2 to 9 times, with displacements off the grid."""
    rng = np.random.default_rng(5)
    room = (table.limits_rad - table.start_rad[:, None])[:3]
    primitives = []
    for sequence in sequences(3):
        if sequence[0] == -sequence[-1]:
            shape = Shape((0, 1, 2), sequence, int(rng.integers(2, 10)))
            primitives.append(table.primitive_of(shape, rng.uniform(room[:, 0], room[:, 1])))
    assert len(primitives) == 6
    return primitives


def test_a_joint_held_aside_goes_out_and_back_once(table: PrimitiveTable) -> None:
    primitive = table.primitive_of(Shape((0, 1, 2), (1, 2, 3, -2, -3, -1), 2), np.array([0.1, 0.2, 0.3]))
    inner = [(1, 0.2), (2, 0.3), (1, -0.2), (2, -0.3)]
    assert primitive.strokes == [(0, 0.1), *inner, *inner, (0, -0.1)]


def test_a_repeated_loop_turns_as_its_strokes_do_one_by_one(
    table: PrimitiveTable, nimble_table: PrimitiveTable
) -> None:
    for robot_table in (table, nimble_table):
        for primitive in random_primitives(robot_table):
            exact = rotation_of_strokes(robot_table, primitive)
            assert angle_between_deg(exact, primitive.quaternion_xyzw) < 1e-3
            undone = rotation_of_strokes(robot_table, primitive.backwards)
            assert angle_between_deg(quaternion.inverse(exact), undone) < 1e-6
            assert angle_between_deg(undone, primitive.backwards.quaternion_xyzw) < 1e-3


def test_it_takes_the_time_of_its_strokes(table: PrimitiveTable, nimble_table: PrimitiveTable) -> None:
    for robot_table in (table, nimble_table):
        for primitive in random_primitives(robot_table):
            by_strokes = sum(
                abs(angle) / robot_table.joint_rate_rad_s[joint] for joint, angle in primitive.strokes
            )
            assert primitive.duration_s == pytest.approx(by_strokes, rel=1e-12)


def test_the_table_has_repeated_loops_and_only_of_joints_held_aside(table: PrimitiveTable) -> None:
    repeated = [table.shapes[number] for number in table.shape if table.shapes[number].repeats > 1]
    assert repeated
    assert all(shape.sequence[0] == -shape.sequence[-1] for shape in repeated)


def test_equal_neighbours_become_one_and_others_stay(table: PrimitiveTable) -> None:
    aside, plain = Shape((0, 1, 2), (1, 2, 3, -2, -3, -1)), Shape((1, 2), (1, 2, -1, -2))
    once = table.primitive_of(aside, np.array([1.0, 1.2, 1.4]))
    twice = table.primitive_of(aside._replace(repeats=2), np.array([1.3, 1.2, 1.1]))
    other = table.primitive_of(plain, np.array([1.0, 1.0]))
    first, middle, last = join_repeats(table, (once, twice, other, other))
    assert first.shape == aside._replace(repeats=3)
    assert first.displacement_rad == pytest.approx([1.2, 1.2, 1.2])
    assert angle_between_deg(rotation_of_strokes(table, first), first.quaternion_xyzw) < 1e-3
    assert middle is last is other


def test_a_joint_is_held_aside_over_three_loops(tfsat_host: RunCli) -> None:
    """Turn by 126 deg in 42.0 s: joint 1 out once, three loops of joints 2 and 3 by 90 deg, joint 1 back."""
    plan = tfsat_host.json("plan", "--target", CASE, "--history", "plan.csv")
    assert plan["reached"] and plan["duration_s"] <= 42.2
    strokes = [stroke for step in plan["steps"] for stroke in step["strokes"]]
    # Every stroke at 30 deg/s, the joint's average rate.
    assert sum(abs(stroke["angle_deg"]) for stroke in strokes) / 30.0 == pytest.approx(plan["duration_s"])
    assert [stroke["joint"] for stroke in strokes].count(1) == 2
    simulation = tfsat_host.json("simulate", "--robot", "cubesat_3u", "--history", "plan.csv")
    simulated, planned = (
        np.array(q) for q in (simulation["quaternion_xyzw"], plan["steps"][-1]["attitude_xyzw"])
    )
    assert angle_between_deg(simulated, planned) < 0.01


def test_the_screen_says_how_often_a_loop_is_repeated(tfsat_host: RunCli) -> None:
    text = " ".join(tfsat_host("plan", "--target", CASE).stdout.split())
    assert " 1:+" in text and " 3x(2:+" in text
