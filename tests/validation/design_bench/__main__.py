"""`make bench-design`: the paper's whole particle swarm, the same objective by MuJoCo rollouts, and grids.

One core: numpy's loops over components use no more. The swarm by rollouts is measured on a sample of its maneuvers
and extrapolated: it would take hours.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from functools import partial

import numpy as np

from tests.validation.design_bench.mujoco_rollout import reorientation_by_rollout
from tfsat_host.dynamics import Multibody, path_rotation, rotation_angle_rad
from tfsat_host.plan.grid import distribution
from tfsat_host.plan.loops import sequences
from tfsat_host.plan.maneuver_design import search
from tfsat_host.plan.optimum import find_optimum
from tfsat_host.plan.problem import DesignSettings, Problem
from tfsat_host.robot import RobotModel, load_robot

TIMESTEPS_S = (1e-3, 1e-4)
"""A common choice, and one at which the rollout is right to some thousandths of a degree."""


def main() -> int:
    """Prints the table: a missed target is shown, but a busy computer is no failure."""
    parser = argparse.ArgumentParser(prog="make bench-design", description=__doc__)
    parser.add_argument("--rounds", type=int, default=7, help="the best one counts")
    parser.add_argument(
        "--rollouts", type=int, default=12, help="maneuvers that MuJoCo flies at each time step"
    )
    arguments = parser.parse_args()
    robot, settings = load_robot(), DesignSettings()
    problem, body = Problem.of(robot, settings), Multibody.of(robot)
    swarm_s = _best(lambda: search(problem, settings), arguments.rounds)
    # The particle swarm evaluates every particle of every iteration for each sequence of strokes.
    count = settings.swarm.particles * settings.swarm.iterations * len(sequences(3))
    print(f"whole swarm, {count} maneuvers  {swarm_s:10.3f} s (target 0.25 s)")
    print(f"true optimum                {_best(lambda: find_optimum(problem), 3):10.3f} s")
    for step_deg in (5.0, 1.0):
        seconds = _best(partial(distribution, body, robot.joint_limits_rad, step_deg), arguments.rounds)
        print(f"grid of {step_deg:g} deg               {1e3 * seconds:10.1f} ms (target for 5 deg: 50 ms)")
    for timestep_s in TIMESTEPS_S:
        seconds, error_deg = _rollouts(robot, arguments.rollouts, timestep_s)
        print(
            f"MuJoCo, steps of {1e3 * timestep_s:g} ms: {1e3 * seconds:.1f} ms a maneuver, off by up to "
            f"{error_deg:.3f} deg; the swarm by it {seconds * count / 60:.1f} min, "
            f"{seconds * count / swarm_s:.0f} times ours"
        )
    return 0


def _best(work: Callable[[], object], rounds: int) -> float:
    """Return the shortest wall time of `rounds` calls, in s, after one uncounted warm-up call."""
    durations_s = []
    # The warm-up pays for imports and caches.
    for _ in range(rounds + 1):
        start = time.perf_counter()
        work()
        durations_s.append(time.perf_counter() - start)
    return min(durations_s[1:])


def _rollouts(robot: RobotModel, count: int, timestep_s: float) -> tuple[float, float]:
    """Seconds for one rollout on average, and the greatest error of its reorientation, as the particles are spread."""
    rng, body = np.random.default_rng(1), Multibody.of(robot)
    seconds, errors = [], []
    for _ in range(count):
        # Where the swarm starts its particles: strokes of 20 to 70 deg.
        alpha, sequence = rng.uniform(20.0, 70.0, 3), sequences(3)[int(rng.integers(len(sequences(3))))]
        strokes = [(abs(s) - 1, float(np.copysign(alpha[abs(s) - 1], s))) for s in sequence]
        rollout = reorientation_by_rollout(robot, strokes, 170.0, timestep_s)
        joints, deltas_deg = zip(*strokes, strict=True)
        ours = rotation_angle_rad(path_rotation(body, joints, np.radians(deltas_deg), steps=8))
        seconds.append(rollout.wall_time_s)
        errors.append(abs(rollout.reorientation_deg - float(np.degrees(ours))))
    return float(np.mean(seconds)), max(errors)


if __name__ == "__main__":
    sys.exit(main())
