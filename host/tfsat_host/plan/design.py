"""The maneuver design of the paper, and the true optimum beside it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from tfsat_host.dynamics import path_rotation, rotation_vector_rad
from tfsat_host.maneuver import Maneuver, Stroke
from tfsat_host.plan.loops import Sequence, backwards, best_sequence
from tfsat_host.plan.optimum import Start, Summit, find_optimum
from tfsat_host.plan.problem import DesignError, DesignSettings, Problem
from tfsat_host.plan.swarm import Found, minimize
from tfsat_host.robot import RobotModel
from tfsat_host.robot.model import FloatArray

# Alternating stops when the sequence stays; ever new ones were not seen beyond three rounds.
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
class Design:
    """A designed maneuver.

    Attributes:
        problem: What was asked for.
        swarm: What the paper's particle swarm found.
        search: How the swarm went.
        optimum: The true optimum.
        summit: How it was found to be one.
        summits: How many local maxima were climbed.
    """

    problem: Problem
    swarm: Candidate
    search: Found
    optimum: Candidate
    summit: Summit
    summits: int

    @property
    def gap_deg(self) -> float | None:
        """How far the swarm's reorientation stays behind the optimum; None if the swarm did not keep the time."""
        if self.swarm.duration_s > self.problem.time_limit_s + _ON_TIME_S:
            return None
        return self.optimum.reorientation_deg - self.swarm.reorientation_deg

    def flown(self, candidate: Candidate) -> Candidate:
        """The candidate as `maneuver` has it: displacements in whole hundredths of a degree."""
        rounded = np.radians(self.problem.commanded_deg(np.abs(candidate.alpha_deg)))
        signs = {joint + 1: number for number, joint in enumerate(self.problem.joints, start=1)}
        sequence = tuple(int(math.copysign(signs[abs(stroke)], stroke)) for stroke in candidate.sequence)
        return _candidate(self.problem, rounded, sequence)

    def maneuver(self, candidate: Candidate, name: str = "") -> Maneuver:
        """The strokes to be flown: displacements rounded to 0.01 deg so that they still fit into the time.

        Raises:
            DesignError: there is none.
        """
        if not candidate.sequence:
            raise DesignError("particles", "Nothing that was found turns a joint by 0.01 deg.")
        commanded = self.problem.commanded_deg(np.abs(candidate.alpha_deg)) * self.problem.directions
        out_deg = {joint + 1: float(deg) for joint, deg in zip(self.problem.joints, commanded, strict=True)}
        strokes = tuple(
            Stroke(abs(signed), math.copysign(1.0, signed) * out_deg[abs(signed)])
            for signed in candidate.sequence
        )
        return Maneuver(strokes, speed_deg_s=round(math.degrees(self.problem.speed_rad_s), 9), name=name)


def design(
    robot: RobotModel,
    settings: DesignSettings | None = None,
    progress: Callable[[float], None] = lambda _done: None,
) -> Design:
    """Designs the maneuver that turns `robot` as far as the time allows.

    Args:
        robot: The robot.
        settings: What is asked for; the paper's figures if None.
        progress: Told the share of the work that was done.

    Raises:
        DesignError: the settings do not fit the robot.
    """
    chosen = settings or DesignSettings()
    problem = Problem.of(robot, chosen)
    found, sequence = search(problem, chosen, lambda done: progress(0.4 * done))
    summit, summits = find_optimum(
        problem,
        starts=[Start(sequence, _within_time(problem, found.position))],
        progress=lambda done: progress(0.6 * done),
    )
    return Design(
        problem,
        candidate(problem, found.position, sequence),
        found,
        candidate(problem, summit.displacements_rad, summit.sequence),
        summit,
        len(summits),
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
    even = np.minimum(problem.limit_rad, problem.travel_limit_rad / len(low))
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


def _within_time(problem: Problem, displacements_rad: FloatArray) -> FloatArray:
    """Displacements shortened in proportion until they keep the time."""
    return np.asarray(
        displacements_rad * min(1.0, problem.travel_limit_rad / max(displacements_rad.sum(), 1e-12))
    )


def _best(sequences: tuple[Sequence, ...], angles_rad: FloatArray) -> Sequence:
    _, best = best_sequence(angles_rad)
    return sequences[int(best[0])]
