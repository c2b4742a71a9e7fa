"""The maneuver design: the paper's search by a particle swarm, the true optimum beside it, and what is flown of both.

A joint that may turn to both sides of its start pose moves out to one of them: every pattern of signs is a problem of
its own for `optimum`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from collections.abc import Sequence as SequenceOf
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import path_rotation, rotation_vector_rad
from tfsat_host.maneuver import Maneuver, Stroke
from tfsat_host.maneuver.maneuver import DEFAULT_PAUSE_S
from tfsat_host.plan.loops import Sequence, backwards, best_sequence
from tfsat_host.plan.optimum import Summit, find_optimum
from tfsat_host.plan.problem import DesignError, DesignSettings, Problem
from tfsat_host.plan.robust import MAX_ROBUST_K, Spread, Uncertain, most_robust
from tfsat_host.plan.swarm import SwarmOptimum, minimize
from tfsat_host.protocol.limits import SCHEDULE_GRID_US
from tfsat_host.robot import RobotModel
from tfsat_host.units import US_PER_S, round_up, s_from_us

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
    search: SwarmOptimum
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

    def round_candidate(self, candidate: Candidate) -> Candidate:
        """Return the candidate as `maneuver` commands it, of displacements in whole hundredths of a degree.

        They keep the time limit with each start on the sequencer's grid, and turn the robot farthest of those near.
        """
        problem = self._problem_facing(candidate)
        # From the robot's joint numbers back to those of the problem.
        signs = {joint + 1: number for number, joint in enumerate(self.problem.joints, start=1)}
        sequence = tuple(int(math.copysign(signs[abs(stroke)], stroke)) for stroke in candidate.sequence)
        near = problem.schedulable_deg(np.abs(candidate.alpha_deg), sequence)
        on_grid = [
            scheduled_candidate(problem, np.radians(displacements), sequence) for displacements in near
        ]
        return max(on_grid, key=lambda scheduled: scheduled.reorientation_deg)

    def _problem_facing(self, candidate: Candidate) -> Problem:
        return self.problem.with_directions(np.where(candidate.alpha_deg < 0.0, -1.0, 1.0))

    def maneuver(self, candidate: Candidate, name: str = "") -> Maneuver:
        """Build the maneuver to be flown, of the displacements of `round_candidate`.

        If a servo needs longer than the average speed
        implies, each stroke gets an explicit start time, after the end of the previous one.

        Raises:
            DesignError: the candidate moves no joint by 0.01 deg.
        """
        commanded = self.round_candidate(candidate)
        if not commanded.sequence:
            raise DesignError("particles", "Nothing that was found turns a joint by 0.01 deg.")
        facing = self._problem_facing(candidate)
        return maneuver_of(facing, commanded.sequence, np.abs(commanded.alpha_deg), name)


def maneuver_of(problem: Problem, sequence: Sequence, alpha_deg: FloatArray, name: str) -> Maneuver:
    """Build a maneuver from a stroke sequence and displacements (d,) of the problem's joints.

    The strokes are numbered by the robot's joints, from 1.
    """
    numbers = [joint + 1 for joint in problem.joints]
    out_deg = dict(zip(numbers, (alpha_deg * problem.directions).tolist(), strict=True))
    strokes = tuple(
        Stroke(abs(signed_joint), math.copysign(1.0, signed_joint) * out_deg[abs(signed_joint)])
        for signed_joint in sequence
    )
    speed_deg_s = round(math.degrees(problem.speed_rad_s), 9)
    duration_s = dict(zip(numbers, problem.stroke_s(np.radians(alpha_deg)).tolist(), strict=True))
    # Where no servo needs longer than the average speed says, the schedule rule sets the times.
    if all(duration_s[stroke.joint] <= abs(stroke.angle_deg) / speed_deg_s + 1e-9 for stroke in strokes):
        return Maneuver(strokes, speed_deg_s=speed_deg_s, name=name)
    # Ramps take longer: fix each start after the arrival of the stroke before.
    return Maneuver(_one_after_another(strokes, duration_s), speed_deg_s=speed_deg_s, name=name)


def _one_after_another(strokes: SequenceOf[Stroke], duration_s: Mapping[int, float]) -> tuple[Stroke, ...]:
    """Set the start times of strokes on the sequencer's grid, each after the previous one has ended.

    `duration_s` gives the duration of a stroke by its joint.
    """
    start_us, timed = round(US_PER_S * DEFAULT_PAUSE_S), list[Stroke]()
    for stroke in strokes:
        timed.append(replace(stroke, t_s=s_from_us(start_us)))
        # A nanosecond off, so that rounding does not cost a whole step of the grid.
        start_us = round_up(
            start_us + math.ceil(US_PER_S * duration_s[stroke.joint] - 1e-3), SCHEDULE_GRID_US
        )
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
    # The paper's search comes first: where it ends, a climb begins, too.
    swarm_optimum, sequence = search(problem, chosen, lambda fraction: progress(0.4 * fraction))
    patterns = list(problem.sign_patterns())
    share, climbed = 0.6 / len(patterns), list[tuple[Summit, Problem]]()
    for pattern in patterns:
        _, ranked = find_optimum(
            pattern,
            # The swarm searched the first pattern alone: its point, cut to the time, starts a climb there.
            starts=[] if climbed else [(sequence, problem.within_time(swarm_optimum.position))],
            # What earlier patterns reached is the bar for the next.
            least_rad=max((summit.reorientation_rad for summit, _ in climbed), default=0.0),
            progress=lambda fraction: progress(share * fraction),
        )
        climbed += [(summit, pattern) for summit in ranked]
    summit, best = max(climbed, key=lambda climb: climb[0].reorientation_rad)
    robust = _robust(robot, chosen.robust, climbed) if chosen.robust else None
    return Design(
        problem,
        candidate(problem, swarm_optimum.position, sequence),
        swarm_optimum,
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
    if not 0.0 < k <= MAX_ROBUST_K:
        raise DesignError("--robust", f"K = {k:g} is not above 0 and up to {MAX_ROBUST_K:g}.")
    if robot.uncertainty is None:
        raise DesignError(
            "--robust", f"{robot.path} has no table [uncertainty], so nothing of it may be wrong."
        )
    uncertain = Uncertain(robot, robot.uncertainty)
    ranked = sorted(climbed, key=lambda climb: -climb[0].reorientation_rad)
    starts: dict[tuple[Sequence, tuple[float, ...]], tuple[Problem, Sequence, FloatArray]] = {}
    for summit, problem in ranked:
        # One start for each sequence and face of the box, from the highest summit there.
        place = summit.sequence, tuple(np.round(problem.directions * (summit.displacements_rad > 0.0)))
        starts.setdefault(place, (problem, summit.sequence, summit.displacements_rad))
    robust_summit = most_robust(uncertain, k, starts.values())
    best, problem = ranked[0]
    return Robust(
        k,
        candidate(robust_summit.problem, robust_summit.displacements_rad, robust_summit.sequence),
        robust_summit.spread,
        uncertain.spread(problem, best.sequence, best.displacements_rad),
    )


def search(
    problem: Problem, settings: DesignSettings, progress: Callable[[float], None] = lambda _done: None
) -> tuple[SwarmOptimum, Sequence]:
    """Run the paper's search: particle swarm for the displacements, exhaustive search for the sequence."""
    rng = np.random.default_rng(settings.seed)
    low = np.zeros_like(problem.limit_rad)
    every = problem.loops()
    # As the paper writes its objective: every particle is worth its best sequence.
    if not settings.alternating:
        swarm_optimum = minimize(
            lambda x: problem.objective(every, x), low, problem.limit_rad, settings.swarm, rng, progress
        )
        return swarm_optimum, _best(every.sequences, every.angles_rad(swarm_optimum.position[:, None]))
    return _in_turns(problem, settings, rng, progress)


def _in_turns(
    problem: Problem, settings: DesignSettings, rng: np.random.Generator, progress: Callable[[float], None]
) -> tuple[SwarmOptimum, Sequence]:
    """Displacements for a sequence, then the best sequence for those, until the sequence stays."""
    every, low = problem.loops(), np.zeros_like(problem.limit_rad)
    # The first sequence: the best one where all joints share the time evenly.
    even = np.minimum(problem.limit_rad, problem.farthest_rad(0.5 * problem.time_limit_s / len(low)))
    sequence = _best(every.sequences, every.angles_rad(even[:, None]))
    tried: dict[Sequence, SwarmOptimum] = {}
    # Descend in displacements and sequence by turns; a sequence that comes again ends it.
    while sequence not in tried and len(tried) < _ROUNDS:
        objective = partial(problem.objective, problem.loops((sequence,)))
        tried[sequence] = minimize(objective, low, problem.limit_rad, settings.swarm, rng, progress)
        sequence = _best(every.sequences, every.angles_rad(tried[sequence].position[:, None]))
    best = min(tried, key=lambda tried_sequence: tried[tried_sequence].value)
    return tried[best], best


def candidate(problem: Problem, displacements_rad: FloatArray, sequence: Sequence) -> Candidate:
    """Compute the candidate for displacements (d,) in a sequence of the problem's joints.

    Of the sequence and its inverse, the first in lexical order is taken.
    """
    commanded = problem.commanded_deg(np.degrees(displacements_rad))
    # A stroke that rounds to nothing is not flown.
    moving = tuple(stroke for stroke in sequence if commanded[abs(stroke) - 1] > 0.0)
    return _candidate(problem, displacements_rad, min(moving, backwards(moving)))


def scheduled_candidate(problem: Problem, displacements_rad: FloatArray, sequence: Sequence) -> Candidate:
    """Compute the candidate of a stroke sequence, its time that of a schedule with starts on the sequencer's grid."""
    moving = tuple(stroke for stroke in sequence if displacements_rad[abs(stroke) - 1] > 0.0)
    exact = _candidate(problem, displacements_rad, moving)
    # Hundredths of a degree, as they are commanded, without what binary digits add.
    alpha_deg = np.round(exact.alpha_deg, 2) + 0.0
    return replace(exact, alpha_deg=alpha_deg, duration_s=problem.scheduled_s(displacements_rad, moving))


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
