"""The searches of the campaign: both ways to move by time limit, ten times longer ones, free joint rates."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from tests.validation.joints_together.collocation import FreePath, FreeRates, RateLimits
from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import Multibody, quaternion
from tfsat_host.dynamics.history import history_from_samples
from tfsat_host.dynamics.propagate import Propagation
from tfsat_host.plan.facility import load_tower
from tfsat_host.plan.maneuver_design import design
from tfsat_host.plan.problem import DesignSettings, Problem
from tfsat_host.plan.together import OverlappingStrokes
from tfsat_host.plan.together_result import TogetherProposal, propose_together
from tfsat_host.plan.tower_room import TowerRoom
from tfsat_host.robot import RobotModel, load_robot

LONGER: Final = 10
"""Times as many evolutions as `design --together` has."""
INTERVALS: Final = 100
DRAWN_STARTS: Final = 5
"""Beside the design's own strokes."""


class TimeLimitRow(NamedTuple):
    """Reorientation in deg by time limit in s, within the tower's limits and without."""

    time_limit_s: float
    one_at_a_time_deg: float
    together_deg: float
    one_at_a_time_free_deg: float
    together_free_deg: float


class LongSearchRow(NamedTuple):
    """The design's search against one with `LONGER` times as many evolutions, other seeds."""

    search: str
    design_deg: float
    longer_deg: float
    gain_deg: float


class FreeRatesRow(NamedTuple):
    """Strokes against free joint rates within the same greatest rate and acceleration."""

    servos: str
    strokes_deg: float
    free_deg: float
    gain_deg: float
    converged: str
    disagreement_deg: float


@dataclass(frozen=True)
class Setting:
    """A search that is tried for longer."""

    name: str
    robot: str
    in_tower: bool
    settings: DesignSettings


def _limits(*limit_deg: float) -> DesignSettings:
    return DesignSettings(limit_deg=limit_deg)


SETTINGS: Final = (
    Setting("drop tower, 1.5 s", "drop_tower", True, DesignSettings()),
    Setting("1.5 s, without the tower", "drop_tower", False, DesignSettings()),
    Setting("drop tower, 1.0 s", "drop_tower", True, DesignSettings(time_limit_s=1.0)),
    Setting("drop tower, 1.25 s", "drop_tower", True, DesignSettings(time_limit_s=1.25)),
    Setting("drop tower, joints 1 and 2", "drop_tower", True, DesignSettings(joints=(0, 1))),
    Setting("drop tower, up to 40 deg", "drop_tower", True, _limits(40.0, 40.0, 40.0)),
    Setting("CubeSat, 12 s", "cubesat_3u", False, DesignSettings(time_limit_s=12.0)),
)


def propose(time_limit_s: float) -> TogetherProposal:
    """Design for a time limit as `design --together --time-limit` does."""
    return propose_together(load_robot(), DesignSettings(time_limit_s=time_limit_s), Path("maneuver.toml"))


def time_limit_row(time_limit_s: float) -> TimeLimitRow:
    """Both ways to move within a time limit."""
    proposal = propose(time_limit_s)
    assert proposal.unlimited is not None
    # The tower leaves less time than some limits: within it one joint at a time is designed for that, too.
    free = design(load_robot(), DesignSettings(time_limit_s=time_limit_s))
    return TimeLimitRow(
        time_limit_s,
        proposal.sequential.reorientation_deg,
        proposal.written.reorientation_deg,
        free.round_candidate(free.optimum).reorientation_deg,
        proposal.unlimited.reorientation_deg,
    )


def long_search_row(setting: Setting) -> LongSearchRow:
    """Search for `LONGER` times as long."""
    robot = load_robot(setting.robot)
    room = TowerRoom(robot, load_tower()) if setting.in_tower else None
    settings = setting.settings
    if room is not None:
        settings = replace(settings, time_limit_s=min(settings.time_limit_s, room.max_moving_s))
    space = OverlappingStrokes(Problem.of(robot, settings), room)
    free = OverlappingStrokes(space.problem)

    def best_deg(seeds: range) -> float:
        found = []
        for seed in seeds:
            # As the design does: summits without the tower's limits lead to some of those within.
            starts = [] if room is None else free.summits(seed)
            best = space.carry_to_grid(space.summits(seed, starts)[0])
            found.append(float(np.linalg.norm(space.fly(best[..., None])[0])))
        return math.degrees(max(found))

    design, longer = best_deg(range(1, 2)), best_deg(range(101, 101 + LONGER))
    return LongSearchRow(setting.name, design, longer, longer - design)


def free_rates_row(ramps: bool) -> tuple[FreeRatesRow, FreePath]:
    """Compare strokes with free joint rates; `ramps`: with the robot file's acceleration, else without limit."""
    robot = load_robot()
    problem = Problem.of(robot, DesignSettings())
    rate, acceleration = problem.speed_rad_s, math.inf
    name = "170 deg/s, no ramps"
    if ramps:
        # The rate at which the file's servo cruises in a stroke of 90 deg at its average speed.
        acceleration = float(problem.acceleration_rad_s2[0])
        stroke_s = float(problem.stroke_s(np.full(3, 0.5 * math.pi))[0])
        rate = 0.5 * acceleration * (stroke_s - math.sqrt(stroke_s**2 - 2.0 * math.pi / acceleration))
        name = f"{math.degrees(rate):.1f} deg/s, ramps of {math.degrees(acceleration):.0f} deg/s²"
    else:
        # So steep that no path sees it.
        steep = np.full(3, 1e6)
        problem = replace(problem, max_rate_rad_s=np.full(3, rate), acceleration_rad_s2=steep)
    space = OverlappingStrokes(problem)
    summit = space.summits(1)[0]
    candidate = space.candidates(summit[:, None])
    strokes_deg = math.degrees(float(np.linalg.norm(space.fly(candidate)[0])))
    limits = RateLimits(rate, acceleration, (0.0, 0.5 * math.pi), problem.time_limit_s)
    program = FreeRates(robot, limits, INTERVALS)
    rng = np.random.default_rng(1)
    starts = [candidate[..., 0]] + [space.candidates(rng.random((9, 1)))[..., 0] for _ in range(DRAWN_STARTS)]
    paths = [program.find_best(program.stroke_rates(_strokes(start))) for start in starts]
    found = [path for path in paths if path.converged]
    best = max(found, key=lambda path: path.reorientation_rad)
    free_deg = math.degrees(best.reorientation_rad)
    disagreement = abs(free_deg - fly_free_path_deg(robot, best, problem.time_limit_s))
    converged = f"{len(found)} of {len(paths)}"
    return FreeRatesRow(name, strokes_deg, free_deg, free_deg - strokes_deg, converged, disagreement), best


def fly_free_path_deg(robot: RobotModel, path: FreePath, duration_s: float) -> float:
    """Return the reorientation in deg of a path of constant joint rates, by tfsat's own dynamics."""
    angles = path_angles_rad(path, duration_s)
    history = history_from_samples(np.linspace(0.0, duration_s, len(angles)), angles, between="linear")
    course = Propagation(Multibody.of(robot), history, None, None, step_s=0.005, order=6)
    return math.degrees(float(quaternion.angle(course.attitudes()[-1])))


def path_angles_rad(path: FreePath, duration_s: float) -> FloatArray:
    """Return the joint angles (n + 1, joints) at the ends of the intervals."""
    steps = path.rates_rad_s * duration_s / len(path.rates_rad_s)
    return np.vstack([np.zeros(steps.shape[1]), np.cumsum(steps, axis=0)])


def _strokes(candidate: FloatArray) -> list[tuple[int, float, float]]:
    return [
        (joint, sign * displacement, start)
        for joint, (displacement, out, back) in enumerate(candidate.T.tolist())
        for sign, start in ((1.0, out), (-1.0, back))
    ]
