"""The distribution of four-stroke loops: the same numbers as stroke by stroke, and the paper's."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.dynamics.random_robots import random_robot
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import Multibody, path_rotation, quaternion, rotation_angle_rad
from tfsat_host.plan.grid import Distribution, OrbitError, distribution
from tfsat_host.robot import RobotModel


def of(robot: RobotModel, step_deg: float) -> Distribution:
    return distribution(Multibody.of(robot), robot.joint_limits_rad, step_deg)


def worst_deg(
    body: Multibody, loop_grid: Distribution, start: FloatArray | None = None, samples: int = 60
) -> float:
    """Return the largest angle between loops of the distribution and the same loops computed per stroke."""
    worst = 0.0
    for index in np.random.default_rng(1).integers(0, len(loop_grid.joints), samples):
        (i, j), (a, b) = loop_grid.joints[index], loop_grid.displacement_rad[index]
        exact = path_rotation(body, [i, j, i, j], np.array([a, b, -a, -b]), start_rad=start, steps=40)
        # The angle of the rotation between them.
        difference = quaternion.product(quaternion.inverse(exact), loop_grid.quaternion_xyzw[index])
        worst = max(worst, float(np.degrees(rotation_angle_rad(difference))))
    return worst


@pytest.mark.parametrize(("step_deg", "loops"), [(5.0, 1944), (1.0, 48_600), (30.0, 54), (45.0, 24)])
def test_every_loop_of_the_grid_is_right_to_a_millionth_of_a_degree(
    cubesat: RobotModel, step_deg: float, loops: int
) -> None:
    loop_grid = of(cubesat, step_deg)
    assert len(loop_grid.joints) == loops
    assert worst_deg(Multibody.of(cubesat), loop_grid) < 1e-6


def test_a_tree_of_five_bodies_starts_anywhere_and_turns_both_ways(tmp_path: Path) -> None:
    robot = random_robot(tmp_path, 2, 5)
    body, start = Multibody.of(robot), np.radians([30.0, -50.0, 0.0, 90.0])
    loop_grid = distribution(body, robot.joint_limits_rad, 20.0, start_rad=start)
    reached = np.degrees(start[loop_grid.joints] + loop_grid.displacement_rad)
    assert reached.min() >= -90.0 - 1e-9 and reached.max() <= 90.0 + 1e-9
    # 60 up and 120 down, 140 and 40, 90 and 90 (80 of them), 0 and 180.
    # For each joint: steps of 20 deg up and down that fit from its start pose.
    counts = np.array([3 + 6, 7 + 2, 4 + 4, 0 + 9])
    assert len(loop_grid.joints) == counts.sum() ** 2 - (counts**2).sum()
    assert worst_deg(body, loop_grid, start) < 1e-6


def test_a_pair_the_other_way_round_is_the_inverse(cubesat: RobotModel) -> None:
    loop_grid = of(cubesat, 15.0)
    by_loop = {
        (*pair, *np.round(np.degrees(displacement)).astype(int).tolist()): turned
        for pair, displacement, turned in zip(
            loop_grid.joints.tolist(), loop_grid.displacement_rad, loop_grid.quaternion_xyzw, strict=True
        )
    }
    body = Multibody.of(cubesat)
    for (i, j, a, b), turned in by_loop.items():
        other = by_loop[j, i, b, a]
        # Backwards is the inverse, to rounding.
        assert rotation_angle_rad(quaternion.product(turned, other)) < 1e-12
    rotation = path_rotation(body, [2, 0, 2, 0], np.radians([30.0, 75.0, -30.0, -75.0]), steps=4)
    assert np.abs(rotation - by_loop[2, 0, 30, 75]).max() < 1e-8


def test_the_paper_s_best_maneuver(cubesat: RobotModel) -> None:
    loop_grid = of(cubesat, 5.0)
    farthest = loop_grid.maneuver(loop_grid.best_by_angle)
    assert {*farthest.joints} == {1, 2}
    assert (farthest.alpha_deg, farthest.beta_deg) == pytest.approx((90.0, 90.0))
    assert farthest.reorientation_deg == pytest.approx(39.31, abs=0.15)
    assert farthest.efficiency == pytest.approx(0.1092, abs=0.0005)
    best = loop_grid.maneuver(loop_grid.best_by_efficiency)
    assert best.efficiency == pytest.approx(0.1092, abs=0.001)
    assert best.efficiency == loop_grid.efficiency.max() >= farthest.efficiency
    # Efficiency is the angle over twice both displacements.
    assert best.efficiency == pytest.approx(best.reorientation_deg / (2 * (best.alpha_deg + best.beta_deg)))


def test_every_ordered_pair_has_its_best(cubesat: RobotModel) -> None:
    loop_grid = of(cubesat, 10.0)
    best = [loop_grid.maneuver(index) for index in loop_grid.best_of_pairs()]
    assert sorted(maneuver.joints for maneuver in best) == [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)]
    assert best[0].efficiency == loop_grid.efficiency.max()
    assert [maneuver.efficiency for maneuver in best] == sorted(
        (maneuver.efficiency for maneuver in best), reverse=True
    )


def test_a_limit_that_is_no_multiple_of_the_step_is_not_on_the_grid(cubesat: RobotModel) -> None:
    loop_grid = of(cubesat, 7.0)
    assert np.degrees(loop_grid.displacement_rad).max() == pytest.approx(84.0)
    # 84 deg is the last of the grid's twelve steps.
    assert len(loop_grid.joints) == 6 * 12**2


def test_a_joint_without_room_takes_no_part(cubesat: RobotModel) -> None:
    limits = cubesat.joint_limits_rad.copy()
    limits[0] = 0.0, np.radians(4.0)
    loop_grid = of(replace(cubesat, joint_limits_rad=limits), 5.0)
    assert {*map(tuple, loop_grid.joints.tolist())} == {(1, 2), (2, 1)}


@pytest.mark.parametrize("step_deg", [0.0, -5.0, float("nan"), float("inf"), 91.0, 0.01])
def test_an_impossible_grid_is_refused(cubesat: RobotModel, step_deg: float) -> None:
    with pytest.raises(OrbitError):
        of(cubesat, step_deg)


def test_the_step_that_a_refusal_names_works(cubesat: RobotModel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tfsat_host.plan.grid._MAX_MANEUVERS", 10_000)
    with pytest.raises(OrbitError) as refusal:
        of(cubesat, 1.0)
    named = float(refusal.value.next_step.split("at least ")[1].split(" ")[0])
    # The step that the refusal names stays within the limit.
    assert 8_000 < len(of(cubesat, named).joints) <= 10_000
