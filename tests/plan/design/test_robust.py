"""Robust design: its spread against a Monte Carlo study, its optimum against a grid."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.cli.process import RunCli
from tfsat_host.plan.error_sources import error_sources
from tfsat_host.plan.maneuver_design import Robust, design
from tfsat_host.plan.parameters import Parameters, Plan, PlannedStroke
from tfsat_host.plan.problem import DesignError, DesignSettings, Problem
from tfsat_host.plan.robust import Uncertain
from tfsat_host.plan.study import Study, run_locally
from tfsat_host.robot import RobotModel, Uncertainty

FOUR = (1, 2, -1, -2)
SIX = (1, 2, 3, -1, -2, -3)


@pytest.fixture
def uncertain(drop_tower: RobotModel) -> Uncertain:
    assert drop_tower.uncertainty is not None
    return Uncertain(drop_tower, drop_tower.uncertainty)


@pytest.mark.parametrize(
    ("sequence", "displacements_deg"), [(FOUR, (59.0, 70.0, 0.0)), (SIX, (30.0, 50.0, 60.0))]
)
def test_the_spread_is_that_of_drawn_robots(
    uncertain: Uncertain, sequence: tuple[int, ...], displacements_deg: tuple[float, ...]
) -> None:
    robot = uncertain.robot
    # Enough time for all strokes of both sequences.
    problem = Problem.of(robot, DesignSettings(time_limit_s=4.0))
    spread = uncertain.spread(problem, sequence, np.radians(displacements_deg))
    size = dict(enumerate(np.radians(displacements_deg), start=1))
    strokes = [
        PlannedStroke(abs(signed_joint) - 1, math.copysign(size[abs(signed_joint)], signed_joint), 10.0 * k)
        for k, signed_joint in enumerate(sequence)
    ]
    parameters = Parameters.of(robot, Plan.of(robot, strokes, problem.speed_rad_s))
    # Four thousand robots drawn from the same uncertainties.
    outcomes = run_locally(Study(parameters, error_sources(parameters, uncertain.stated), 4000, 1), workers=1)
    assert math.degrees(spread.mean_rad) == pytest.approx(outcomes.reorientation_deg.mean(), abs=0.15)
    assert math.degrees(spread.std_rad) == pytest.approx(outcomes.reorientation_deg.std(), rel=0.06)


def test_a_robot_that_is_exactly_as_filed_has_no_spread(drop_tower: RobotModel) -> None:
    problem = Problem.of(drop_tower, DesignSettings())
    # Speed alone is uncertain: displacements are not.
    exact = Uncertain(drop_tower, Uncertainty(servo_speed_relative=0.1))
    spread = exact.spread(problem, FOUR, np.radians([59.0, 70.0, 0.0]))
    assert spread.std_rad == 0.0
    assert math.degrees(spread.mean_rad) == pytest.approx(25.9, abs=0.3)


@pytest.mark.parametrize("k", [1.0, 3.0])
def test_no_point_of_a_grid_is_better(uncertain: Uncertain, k: float) -> None:
    """Compare the robust optimum with a grid.

    Where play alone is uncertain, fewer and longer strokes pay; here the sequences of displacements that
    lead to a turn are compared.
    """
    # Play is uncertain, so that few and long strokes pay.
    stated = Uncertainty(stroke_rad=math.radians(4.0), com_m=0.002)
    robot = replace(uncertain.robot, uncertainty=stated)
    robust_design = design(robot, DesignSettings(joints=(0, 1), time_limit_s=1.6, robust=k)).robust
    assert isinstance(robust_design, Robust) and robust_design.k == k
    assert robust_design.spread.less(k) >= robust_design.of_optimum.less(k) - 1e-12
    problem = Problem.of(robot, DesignSettings(joints=(0, 1), time_limit_s=1.6))
    assert problem.keeps_time(np.radians(np.abs(robust_design.maneuver.alpha_deg)))
    best = max(
        Uncertain(robot, stated).spread(problem, FOUR, np.radians(pair)).less(k)
        # A grid of 5 deg, coarse enough that the optimum must not lie on it.
        for pair in itertools.product(np.arange(10.0, 91.0, 5.0), repeat=2)
        if problem.keeps_time(np.radians(pair))
    )
    assert robust_design.spread.less(k) >= best - 1e-9
    assert math.degrees(robust_design.spread.less(k) - best) < 0.5, "and the grid comes near it"


@pytest.mark.parametrize("k", [-1.0, math.nan, 11.0])
def test_a_k_that_means_nothing_is_refused(drop_tower: RobotModel, k: float) -> None:
    with pytest.raises(DesignError, match="not above 0 and up to 10") as refused:
        design(drop_tower, DesignSettings(robust=k))
    assert refused.value.setting == "--robust"


def test_without_uncertainties_there_is_nothing_to_be_robust_against(drop_tower: RobotModel) -> None:
    with pytest.raises(DesignError, match="no table"):
        design(replace(drop_tower, uncertainty=None), DesignSettings(robust=1.0))


def test_the_command_writes_the_robust_maneuver_and_compares(tfsat_host: RunCli) -> None:
    plain = tfsat_host.json("design", "--out", "plain.toml")
    result = tfsat_host.json("design", "--robust", 3, "--out", "robust.toml")
    assert plain["robust"] is None
    robust = result["robust"]
    assert robust["k"] == 3.0 and robust["std_deg"] < robust["optimum_std_deg"]
    assert (
        robust["mean_deg"] - 3 * robust["std_deg"]
        > robust["optimum_mean_deg"] - 3 * robust["optimum_std_deg"]
    )
    # Within a step of the sequencer's grid, 1.7 deg.
    assert result["alpha_deg"] == pytest.approx(robust["alpha_deg"], abs=1.7)
    assert result["optimum"]["reorientation_deg"] == plain["optimum"]["reorientation_deg"]
    output = tfsat_host("design", "--robust", 3, "--out", "robust.toml").stdout
    assert "With uncertainty:" in output and "\n robust " in output
