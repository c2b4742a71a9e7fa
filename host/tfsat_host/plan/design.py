"""The maneuver design of the paper, and the true optimum: deterministic, and without the swarm's scatter.

For one sequence the reorientation is a smooth function of the displacements, and what the time limit and the
joints' ranges leave is a convex body, but for corners where a joint hardly moves and its servo only speeds up and slows
down. So every local maximum of a grid over it is climbed by sequential quadratic
programming with gradients that are right to ten digits, and the highest summit is the answer. A joint that may turn to
both sides of its start pose moves out to one of them: every pattern of signs is such a body of its own.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from collections.abc import Sequence as SequenceOf
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy import optimize

from tfsat_host.arrays import FloatArray, IntArray
from tfsat_host.dynamics import path_rotation, rotation_vector_rad
from tfsat_host.maneuver import Maneuver, Stroke
from tfsat_host.maneuver.maneuver import DEFAULT_PAUSE_S
from tfsat_host.plan.loops import Loops, Sequence, backwards, best_sequence, classes
from tfsat_host.plan.problem import DesignError, DesignSettings, Problem
from tfsat_host.plan.robust import MOST_K, Spread, Uncertain, most_robust
from tfsat_host.plan.swarm import Found, minimize
from tfsat_host.protocol.limits import SCHEDULE_GRID_US
from tfsat_host.robot import RobotModel
from tfsat_host.units import US_PER_S, round_up, s_from_us

GRID_POINTS = 2500
"""About how many displacements are looked at before the climb: 7 deg apart for three joints of 90 deg."""
# A summit stands at most this factor above the best grid point near it; what is lower cannot win.
_WORTH_CLIMBING = 0.85
_DIFFERENCE_RAD = 2e-3
_FLAT = 1e-6
"""A residual below it is of a summit."""


class Summit(NamedTuple):
    """A local maximum of one sequence.

    Attributes:
        displacements_rad: (d,).
        sequence: The sequence that it belongs to.
        reorientation_rad: The rotation angle.
        gain_rad_s: How much more every further second of time would give; 0 where time does not limit.
        residual: Length of what of the gradient no active limit holds back, rad/rad: 0 at a true maximum.
    """

    displacements_rad: FloatArray
    sequence: Sequence
    reorientation_rad: float
    gain_rad_s: float
    residual: float


def find_optimum(
    problem: Problem,
    *,
    starts: SequenceOf[tuple[Sequence, FloatArray]] = (),
    grid_points: int = GRID_POINTS,
    least_rad: float = 0.0,
    progress: Callable[[float], None] = lambda _done: None,
) -> tuple[Summit, tuple[Summit, ...]]:
    """The best summit, and all summits that were climbed, best first.

    Args:
        problem: The design problem.
        starts: Sequences and displacements (d,) to climb from as well, whatever the grid finds.
        grid_points: About how many points the grid has.
        least_rad: What was reached elsewhere: a grid point well below it is not climbed from, but for the best.
        progress: Called with the share of the work that was done.
    """
    sequences = classes(len(problem.joints))
    candidates = _grid_maxima(problem, problem.loops(sequences), grid_points)
    progress(0.3)
    summits = [climb(problem, *start) for start in starts]
    best = max([least_rad, candidates[0][0], *(summit.reorientation_rad for summit in summits)])
    for value, sequence, displacements in candidates:
        if value >= _WORTH_CLIMBING * best or not summits:
            summits.append(climb(problem, sequences[sequence], displacements))
            best = max(best, summits[-1].reorientation_rad)
        progress(0.7 / len(candidates))
    ranked = tuple(sorted(summits, key=lambda summit: -summit.reorientation_rad))
    return ranked[0], ranked


def climb(problem: Problem, sequence: Sequence, start_rad: FloatArray) -> Summit:
    """Climb to the summit of `sequence` that is reached from displacements `start_rad` (d,)."""
    summit = _climb_once(problem, sequence, start_rad)
    # Along a flat ridge SLSQP may stop below the summit; a new start forgets the curvature that misled it.
    while summit.residual > _FLAT:
        further = _climb_once(problem, sequence, summit.displacements_rad)
        if further.residual > 0.9 * summit.residual:
            break
        summit = further
    return summit


def _climb_once(problem: Problem, sequence: Sequence, start_rad: FloatArray) -> Summit:
    loops = problem.loops((sequence,))
    d = len(start_rad)

    def falling(x: FloatArray) -> tuple[float, FloatArray]:
        value, gradient = value_and_gradient(loops, x)
        return -value, -gradient

    result = optimize.minimize(
        falling,
        start_rad,
        jac=True,
        method="SLSQP",
        bounds=optimize.Bounds(np.zeros(d), problem.limit_rad),
        constraints=optimize.NonlinearConstraint(
            lambda x: problem.duration_s(np.maximum(x, 0.0)),
            -np.inf,
            problem.time_limit_s,
            jac=lambda x: 2.0 * problem.stroke_s_per_rad(x)[None],
        ),
        options={"ftol": 1e-13, "maxiter": 200},
    )
    top = np.clip(result.x, 0.0, problem.limit_rad)
    top = np.where(top < 1e-7, 0.0, top)
    top = problem.within_time(top)
    value, gradient = value_and_gradient(loops, top)
    return Summit(top, sequence, value, *_held_back(problem, top, gradient))


def value_and_gradient(loops: Loops, displacements_rad: FloatArray) -> tuple[float, FloatArray]:
    """Rotation angle of the only sequence of `loops` and its derivatives (d,), by differences of order 4."""
    d, h = len(displacements_rad), _DIFFERENCE_RAD
    shifts = np.concatenate([np.zeros((d, 1)), *(k * h * np.eye(d) for k in (-2, -1, 1, 2))], axis=1)
    angles = loops.angles_rad(displacements_rad[:, None] + shifts)[0]
    far_below, below, above, far_above = angles[1:].reshape(4, d)
    return float(angles[0]), np.asarray((far_below - far_above + 8.0 * (above - below)) / (12.0 * h))


def _held_back(problem: Problem, top: FloatArray, gradient: FloatArray) -> tuple[float, float]:
    """Gain by more time (rad/s), and what of the gradient neither the time limit nor a wall takes up."""
    free = (top > 0.0) & (top < problem.limit_rad - 1e-9)
    timed = float(problem.duration_s(top)) > problem.time_limit_s - 1e-6
    slower = 2.0 * problem.stroke_s_per_rad(top)
    multiplier = (
        float(gradient[free] @ slower[free] / (slower[free] @ slower[free])) if timed and free.any() else 0.0
    )
    rest = gradient - multiplier * slower
    rest = np.where(free, rest, np.where(top > 0.0, np.minimum(rest, 0.0), np.maximum(rest, 0.0)))
    return max(multiplier, 0.0), float(np.linalg.norm(rest))


def _grid_maxima(problem: Problem, loops: Loops, grid_points: int) -> list[tuple[float, int, FloatArray]]:
    """Value, sequence and displacements of the grid's local maxima, best first."""
    d = len(problem.joints)
    per_joint = max(d + 2, math.floor(grid_points ** (1.0 / d)))
    # No farther than the time allows, or a short time would leave nothing but points where one joint moves alone.
    reach = np.minimum(problem.limit_rad, problem.farthest_rad(0.5 * problem.time_limit_s))
    axes = [np.linspace(0.0, most, per_joint) for most in reach]
    nodes = np.array(list(itertools.product(range(per_joint), repeat=d)))
    points = np.stack([axis[nodes[:, j]] for j, axis in enumerate(axes)])
    inside = problem.keeps_time(points)
    nodes, points = nodes[inside], points[:, inside]
    angles = loops.angles_rad(points)
    maxima: list[tuple[float, int, FloatArray]] = []
    for sequence, values in enumerate(angles):
        maxima += [
            (float(values[i]), sequence, points[:, i]) for i in _local_maxima(nodes, values, per_joint)
        ]
    return sorted(maxima, key=lambda maximum: -maximum[0])


def _local_maxima(nodes: IntArray, values: FloatArray, per_joint: int) -> list[int]:
    """Which nodes (m, d) no neighbour along an axis exceeds."""
    d = nodes.shape[1]
    field = np.full((per_joint + 2,) * d, -np.inf)
    field[tuple((nodes + 1).T)] = values
    top = np.ones(len(nodes), dtype=bool)
    for axis in range(d):
        for shift in (-1, 1):
            neighbour = nodes + 1
            neighbour[:, axis] += shift
            top &= values >= field[tuple(neighbour.T)]
    return [int(i) for i in np.nonzero(top)[0]]


# Alternating stops when the sequence stays; it always did within three rounds.
_ROUNDS = 10
# The swarm may overrun the time by what its penalty does not yet feel.
_ON_TIME_S = 1e-4
# One result can afford what a search cannot.
_FINE_STEPS = 16


@dataclass(frozen=True, eq=False)
class Candidate:
    """A maneuver that was found.

    Attributes:
        alpha_deg: (d,) displacements of the joints that may move; negative where a joint moves out that way.
        sequence: Numbers (from 1) of the robot's joints in flight order, positive where a joint moves out, negative
            where it moves back; joints that do not move are left out.
        rotation_vector_deg: (3,) of the loop, base axes.
        reorientation_deg: Its length.
        duration_s: All strokes, one after another.
        efficiency: Reorientation for each degree that joints travel.
    """

    alpha_deg: FloatArray
    sequence: Sequence
    rotation_vector_deg: FloatArray
    reorientation_deg: float
    duration_s: float
    efficiency: float


@dataclass(frozen=True, eq=False)
class Robust:
    """The maneuver with the greatest mean less K standard deviations, over what the robot file calls uncertain.

    Attributes:
        k: K.
        maneuver: What was found.
        spread: Its reorientation.
        of_optimum: The same of the true optimum, which takes the file for exact.
    """

    k: float
    maneuver: Candidate
    spread: Spread
    of_optimum: Spread


@dataclass(frozen=True, eq=False)
class Design:
    """A designed maneuver.

    Attributes:
        problem: What was asked for.
        swarm: What the paper's particle swarm found.
        search: How the swarm went.
        optimum: The true optimum.
        summit: How it was found to be one.
        summits: How many local maxima were climbed.
        robust: What was found for a robot that is not as filed; None: not asked for.
    """

    problem: Problem
    swarm: Candidate
    search: Found
    optimum: Candidate
    summit: Summit
    summits: int
    robust: Robust | None = None

    @property
    def gap_deg(self) -> float | None:
        """How far the swarm's reorientation stays behind the optimum; None if the swarm did not keep the time."""
        if self.swarm.duration_s > self.problem.time_limit_s + _ON_TIME_S:
            return None
        return self.optimum.reorientation_deg - self.swarm.reorientation_deg

    def flown(self, candidate: Candidate) -> Candidate:
        """The candidate as `maneuver` has it: displacements in whole hundredths of a degree."""
        problem = self._facing(candidate)
        rounded = np.radians(problem.commanded_deg(np.abs(candidate.alpha_deg)))
        signs = {joint + 1: number for number, joint in enumerate(self.problem.joints, start=1)}
        sequence = tuple(int(math.copysign(signs[abs(stroke)], stroke)) for stroke in candidate.sequence)
        return _candidate(problem, rounded, sequence)

    def _facing(self, candidate: Candidate) -> Problem:
        return self.problem.facing(np.where(candidate.alpha_deg < 0.0, -1.0, 1.0))

    def maneuver(self, candidate: Candidate, name: str = "") -> Maneuver:
        """The strokes to be flown: displacements rounded to 0.01 deg so that they still fit into the time.

        Where a servo needs longer than at the average speed every stroke has its time, after the one before has ended.

        Raises:
            DesignError: there is none.
        """
        if not candidate.sequence:
            raise DesignError("particles", "Nothing that was found turns a joint by 0.01 deg.")
        facing = self._facing(candidate)
        commanded = facing.commanded_deg(np.abs(candidate.alpha_deg))
        return maneuver_of(facing, candidate.sequence, commanded, name)


def maneuver_of(problem: Problem, sequence: Sequence, alpha_deg: FloatArray, name: str) -> Maneuver:
    """The strokes of a sequence of the robot's joints (from 1), by displacements (d,) of the problem's joints."""
    numbers = [joint + 1 for joint in problem.joints]
    out_deg = dict(zip(numbers, (alpha_deg * problem.directions).tolist(), strict=True))
    strokes = tuple(Stroke(abs(one), math.copysign(1.0, one) * out_deg[abs(one)]) for one in sequence)
    speed_deg_s = round(math.degrees(problem.speed_rad_s), 9)
    duration_s = dict(zip(numbers, problem.stroke_s(np.radians(alpha_deg)).tolist(), strict=True))
    if all(duration_s[one.joint] <= abs(one.angle_deg) / speed_deg_s + 1e-9 for one in strokes):
        return Maneuver(strokes, speed_deg_s=speed_deg_s, name=name)
    return Maneuver(_one_after_another(strokes, duration_s), speed_deg_s=speed_deg_s, name=name)


def _one_after_another(strokes: SequenceOf[Stroke], duration_s: Mapping[int, float]) -> tuple[Stroke, ...]:
    """With times on the sequencer's grid, each after the one before has ended; durations by joint."""
    start_us, timed = round(US_PER_S * DEFAULT_PAUSE_S), list[Stroke]()
    for one in strokes:
        timed.append(replace(one, t_s=s_from_us(start_us)))
        start_us = round_up(start_us + math.ceil(US_PER_S * duration_s[one.joint] - 1e-3), SCHEDULE_GRID_US)
    return tuple(timed)


def design(
    robot: RobotModel,
    settings: DesignSettings | None = None,
    progress: Callable[[float], None] = lambda _done: None,
) -> Design:
    """Designs the maneuver that turns `robot` as far as the time allows.

    Args:
        robot: The robot.
        settings: What is asked for; the paper's figures if None.
        progress: Called with the share of the work that was done.

    Raises:
        DesignError: the settings do not fit the robot.
    """
    chosen = settings or DesignSettings()
    problem = Problem.of(robot, chosen)
    found, sequence = search(problem, chosen, lambda done: progress(0.4 * done))
    patterns = list(problem.sign_patterns())
    share, climbed = 0.6 / len(patterns), list[tuple[Summit, Problem]]()
    for pattern in patterns:
        _, ranked = find_optimum(
            pattern,
            starts=[] if climbed else [(sequence, problem.within_time(found.position))],
            least_rad=max((summit.reorientation_rad for summit, _ in climbed), default=0.0),
            progress=lambda done: progress(share * done),
        )
        climbed += [(summit, pattern) for summit in ranked]
    summit, best = max(climbed, key=lambda one: one[0].reorientation_rad)
    robust = _robust(robot, chosen.robust, climbed) if chosen.robust else None
    return Design(
        problem,
        candidate(problem, found.position, sequence),
        found,
        candidate(best, summit.displacements_rad, summit.sequence),
        summit,
        len(climbed),
        robust,
    )


def _robust(robot: RobotModel, k: float, climbed: SequenceOf[tuple[Summit, Problem]]) -> Robust:
    """Climbs on from the nominal summits, the highest of each sequence and pattern of signs.

    Raises:
        DesignError: K is no number from 0 to 10, or the file states no uncertainty.
    """
    if not 0.0 < k <= MOST_K:
        raise DesignError("--robust", f"K = {k:g} is not above 0 and up to {MOST_K:g}.")
    if robot.uncertainty is None:
        raise DesignError(
            "--robust", f"{robot.path} has no table [uncertainty], so nothing of it may be wrong."
        )
    uncertain = Uncertain(robot, robot.uncertainty)
    ranked = sorted(climbed, key=lambda one: -one[0].reorientation_rad)
    starts: dict[tuple[Sequence, tuple[float, ...]], tuple[Problem, Sequence, FloatArray]] = {}
    for summit, problem in ranked:
        place = summit.sequence, tuple(np.round(problem.directions * (summit.displacements_rad > 0.0)))
        starts.setdefault(place, (problem, summit.sequence, summit.displacements_rad))
    found = most_robust(uncertain, k, starts.values())
    best, problem = ranked[0]
    return Robust(
        k,
        candidate(found.problem, found.displacements_rad, found.sequence),
        found.spread,
        uncertain.spread(problem, best.sequence, best.displacements_rad),
    )


def search(
    problem: Problem, settings: DesignSettings, progress: Callable[[float], None] = lambda _done: None
) -> tuple[Found, Sequence]:
    """The paper's search: the displacements by a particle swarm, the sequence by looking at all of them."""
    rng = np.random.default_rng(settings.seed)
    low = np.zeros_like(problem.limit_rad)
    every = problem.loops()
    if not settings.alternating:
        found = minimize(
            lambda x: problem.objective(every, x), low, problem.limit_rad, settings.swarm, rng, progress
        )
        return found, _best(every.sequences, every.angles_rad(found.position[:, None]))
    return _in_turns(problem, settings, rng, progress)


def _in_turns(
    problem: Problem, settings: DesignSettings, rng: np.random.Generator, progress: Callable[[float], None]
) -> tuple[Found, Sequence]:
    """Displacements for a sequence, then the best sequence for those, until the sequence stays."""
    every, low = problem.loops(), np.zeros_like(problem.limit_rad)
    # The first sequence: the best one where all joints share the time evenly.
    even = np.minimum(problem.limit_rad, problem.farthest_rad(0.5 * problem.time_limit_s / len(low)))
    sequence = _best(every.sequences, every.angles_rad(even[:, None]))
    tried: dict[Sequence, Found] = {}
    while sequence not in tried and len(tried) < _ROUNDS:
        objective = partial(problem.objective, problem.loops((sequence,)))
        tried[sequence] = minimize(objective, low, problem.limit_rad, settings.swarm, rng, progress)
        sequence = _best(every.sequences, every.angles_rad(tried[sequence].position[:, None]))
    best = min(tried, key=lambda one: tried[one].value)
    return tried[best], best


def candidate(problem: Problem, displacements_rad: FloatArray, sequence: Sequence) -> Candidate:
    """What displacements (d,) in a sequence of the problem's joints do; of two ways round, the first in order."""
    commanded = problem.commanded_deg(np.degrees(displacements_rad))
    moving = tuple(stroke for stroke in sequence if commanded[abs(stroke) - 1] > 0.0)
    return _candidate(problem, displacements_rad, min(moving, backwards(moving)))


def _candidate(problem: Problem, displacements_rad: FloatArray, moving: Sequence) -> Candidate:
    alpha = np.degrees(problem.directions * displacements_rad) + 0.0  # no minus zeros
    joints = [problem.joints[abs(stroke) - 1] for stroke in moving]
    deltas = np.array([math.copysign(1.0, stroke) * np.radians(alpha[abs(stroke) - 1]) for stroke in moving])
    rotation = path_rotation(problem.body, joints, deltas, start_rad=problem.start_rad, steps=_FINE_STEPS)
    vector = np.degrees(rotation_vector_rad(rotation))
    angle = float(np.linalg.norm(vector))
    travel = float(np.degrees(np.abs(deltas).sum()))
    return Candidate(
        alpha,
        tuple(int(math.copysign(joint + 1, stroke)) for joint, stroke in zip(joints, moving, strict=True)),
        vector,
        angle,
        float(problem.duration_s(displacements_rad[:, None])[0]),
        angle / travel if travel > 0.0 else 0.0,
    )


def _best(sequences: tuple[Sequence, ...], angles_rad: FloatArray) -> Sequence:
    _, best = best_sequence(angles_rad)
    return sequences[int(best[0])]
