"""`make bench-design`: the paper's whole particle swarm, beside the same objective by MuJoCo rollouts, and grids.

One core: numpy's loops over components use no more. The swarm by rollouts is measured on a sample of its maneuvers
and extrapolated; nobody waits for it.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tests.design_bench.mujoco_rollout import reorientation_by_rollout
from tfsat_host.dynamics import Multibody, path_rotation, rotation_angle_rad
from tfsat_host.plan.design import find_optimum, search
from tfsat_host.plan.grid import distribution
from tfsat_host.plan.loops import sequences
from tfsat_host.plan.problem import DesignSettings, Problem
from tfsat_host.robot import RobotModel, load_robot

SWARM_TARGET_S = 0.25
GRID_TARGET_S = 0.05
PAPERS_DEG = (58.75, 70.29)
TIMESTEPS_S = (1e-3, 1e-4)
"""A common choice, and one at which the rollout is right to some thousandths of a degree."""


class RolloutCost(NamedTuple):
    """Seconds for one rollout on average, and how far its reorientation was off at most."""

    timestep_s: float
    seconds: float
    error_deg: float


def main() -> int:
    """Prints the table; a target that is missed is said, but a busy computer is no failure."""
    parser = argparse.ArgumentParser(prog="make bench-design", description=__doc__)
    parser.add_argument("--rounds", type=int, default=7, help="the best one counts")
    parser.add_argument(
        "--rollouts", type=int, default=12, help="how many maneuvers MuJoCo flies at each time step"
    )
    parser.add_argument("--json", type=Path, help="put the figures into this file too")
    arguments = parser.parse_args()
    robot, settings = load_robot(), DesignSettings()
    problem, body = Problem.of(robot, settings), Multibody.of(robot)
    swarm_s = _best(lambda: search(problem, settings), arguments.rounds)
    optimum_s = _best(lambda: find_optimum(problem), 3)
    grids = {
        step: (
            _best(partial(distribution, body, robot.joint_limits_rad, step), arguments.rounds),
            len(distribution(body, robot.joint_limits_rad, step).angle_rad),
        )
        for step in (5.0, 1.0)
    }
    rollouts = [_rollouts(robot, arguments.rollouts, timestep_s) for timestep_s in TIMESTEPS_S]
    count = settings.swarm.particles * settings.swarm.iterations * len(sequences(len(problem.joints)))
    figures = _figures(swarm_s, optimum_s, grids, rollouts, count)
    _show(figures)
    if arguments.json:
        arguments.json.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    return 0


def _best(work: Callable[[], object], rounds: int) -> float:
    """Least wall time of `rounds`, after one that counts for nothing."""
    work()
    taken = []
    for _ in range(rounds):
        start = time.perf_counter()
        work()
        taken.append(time.perf_counter() - start)
    return min(taken)


def _rollouts(robot: RobotModel, count: int, timestep_s: float) -> RolloutCost:
    """MuJoCo on some of the swarm's maneuvers, as its particles are spread: each by both."""
    rng = np.random.default_rng(1)
    body = Multibody.of(robot)
    seconds, errors = [], []
    for number in range(count):
        alpha = np.array([*PAPERS_DEG, 0.01]) if number == 0 else rng.uniform(20.0, 70.0, 3)
        sequence = sequences(3)[int(rng.integers(len(sequences(3))))]
        strokes = [(abs(s) - 1, float(np.copysign(alpha[abs(s) - 1], s))) for s in sequence]
        flown = reorientation_by_rollout(robot, strokes, 170.0, timestep_s)
        ours = rotation_angle_rad(
            path_rotation(
                body, [joint for joint, _ in strokes], np.radians([angle for _, angle in strokes]), steps=8
            )
        )
        seconds.append(flown.wall_time_s)
        errors.append(abs(flown.reorientation_deg - float(np.degrees(ours))))
    return RolloutCost(timestep_s, float(np.mean(seconds)), max(errors))


def _figures(
    swarm_s: float,
    optimum_s: float,
    grids: dict[float, tuple[float, int]],
    rollouts: list[RolloutCost],
    count: int,
) -> dict[str, Any]:
    return {
        "cores": os.cpu_count(),
        "maneuvers_of_swarm": count,
        "swarm_s": swarm_s,
        "optimum_s": optimum_s,
        "grids": [{"step_deg": step, "maneuvers": n, "seconds": s} for step, (s, n) in grids.items()],
        "rollouts": [
            {
                **rollout._asdict(),
                "swarm_extrapolated_s": rollout.seconds * count,
                "ratio": rollout.seconds * count / swarm_s,
            }
            for rollout in rollouts
        ],
    }


def _show(figures: dict[str, Any]) -> None:
    count = figures["maneuvers_of_swarm"]
    print(f"The paper's swarm: 48 particles x 50 iterations x 30 sequences = {count} maneuvers, on one core.")
    print()
    print(f"{'':44}{'time':>12}{'ratio':>10}")
    swarm = figures["swarm_s"]
    print(
        f"{'tfsat, whole swarm (target 0.25 s)':44}{swarm:>10.3f} s{1.0:>10.0f}  {_verdict(swarm, SWARM_TARGET_S)}"
    )
    for rollout in figures["rollouts"]:
        name = f"MuJoCo rollouts, {1e3 * rollout['timestep_s']:g} ms steps (extrapolated)"
        print(f"{name:44}{rollout['swarm_extrapolated_s'] / 60:>8.1f} min{rollout['ratio']:>10.0f}")
        print(
            f"{'':4}{1e3 * rollout['seconds']:.1f} ms a rollout, measured; off by up to {rollout['error_deg']:.3f} deg"
        )
    print(f"{'tfsat, true optimum':44}{figures['optimum_s']:>10.3f} s")
    for grid in figures["grids"]:
        name = f"tfsat, {grid['step_deg']:g} deg grid of {grid['maneuvers']} maneuvers"
        target, verdict = "", ""
        if grid["step_deg"] == 5.0:
            target, verdict = " (target 50 ms)", _verdict(grid["seconds"], GRID_TARGET_S)
        print(f"{name + target:54}{1e3 * grid['seconds']:>6.1f} ms  {verdict}")


def _verdict(seconds: float, target_s: float) -> str:
    return "met" if seconds <= target_s else "MISSED"


if __name__ == "__main__":
    sys.exit(main())
