"""A maneuver for a robot that may not be as filed: the mean reorientation less K standard deviations, maximized.

The errors are the independent sources of the file's `[uncertainty]` (`plan/parameters.py`); servo speeds have no part
in it, for strokes that do not overlap turn the robot by their path alone. Along each source, of standard deviation 1,
the reorientation r is taken to second order,

    mean = r0 + sum over sources of (r+ + r- - 2 r0) / 2
    variance = sum over sources of ((r+ - r-) / 2)^2 + ((r+ + r- - 2 r0)^2) / 2

with r+ and r- at one deviation to either side: no random number, and the same to the last bit each time.

Strokes that overlap turn the robot by each servo's speed as well, and a servo that is slow delays its own way back: the
rotation bends sharply, and speeds and gains act on one another. There the three nodes of Gauss and Hermite's quadrature
(0 and sqrt(3) deviations to either side) take the place of the second order, with all nodes of each pair of speeds and
gains: mean and deviation are those of drawn robots to some hundredths.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from collections.abc import Sequence as SequenceOf
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy import optimize

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import Multibody, path_rotation, quaternion, rotation_angle_rad
from tfsat_host.dynamics.propagate import Propagation
from tfsat_host.plan.error_sources import error_sources
from tfsat_host.plan.loops import Sequence
from tfsat_host.plan.parameters import Parameters, Plan, PlannedStroke
from tfsat_host.plan.problem import Problem
from tfsat_host.robot import RobotModel, Uncertainty

MAX_ROBUST_K = 10.0
# The sequencer's resolution: a smaller stroke is not flown.
_MOVES_RAD = math.radians(0.01)
_DIFFERENCE_RAD = 1e-3
_STEPS = 3
# Gauss-Hermite quadrature of three nodes: standard deviations to either side, and weights.
_NODE, _WEIGHTS = math.sqrt(3.0), np.array([1.0, 4.0, 1.0]) / 6.0
_ACT_ON_ONE_ANOTHER = ("servo_scale", "servo_speed")


class Spread(NamedTuple):
    """Of the reorientation over what the robot may be, rad."""

    mean_rad: float
    std_rad: float

    def less(self, k: float) -> float:
        """Return the mean minus k standard deviations, rad."""
        return self.mean_rad - k * self.std_rad


@dataclass(frozen=True, eq=False)
class Uncertain:
    """A robot and what its file may be wrong by.

    Attributes:
        robot: As filed.
        stated: Its `[uncertainty]`.
    """

    robot: RobotModel
    stated: Uncertainty

    def spread(self, problem: Problem, sequence: Sequence, displacements_rad: FloatArray) -> Spread:
        """Compute the spread of a loop's reorientation angle.

        The loop has displacements (d,) of the problem's joints in a sequence; one below 0.01 deg is not flown.
        """
        signed = displacements_rad * problem.directions
        # Start times only give the order: without momentum the path alone turns the robot.
        strokes = [
            PlannedStroke(
                problem.joints[abs(signed_joint) - 1],
                math.copysign(1.0, signed_joint) * signed[abs(signed_joint) - 1],
                float(k),
            )
            for k, signed_joint in enumerate(sequence)
            if displacements_rad[abs(signed_joint) - 1] >= _MOVES_RAD
        ]
        if not strokes:
            return Spread(0.0, 0.0)
        parameters = Parameters.of(self.robot, Plan.of(self.robot, strokes, problem.speed_rad_s))
        sources = error_sources(parameters, replace(self.stated, servo_speed_relative=0.0, servo_delay_s=0.0))
        # The nominal robot, and one deviation to either side along every source that has an effect.
        shifts = sources.matrix[:, sources.matrix.any(axis=0)].T
        vectors = parameters.nominal + np.concatenate(
            [np.zeros((1, len(parameters.nominal))), shifts, -shifts]
        )
        turned = self._reorientations(parameters, vectors)
        above, below = turned[1:].reshape(2, -1)
        # Second differences: curvature moves the mean, and adds to the variance.
        bend = above + below - 2.0 * turned[0]
        variance = 0.25 * ((above - below) ** 2).sum() + 0.5 * (bend**2).sum()
        return Spread(float(turned[0] + 0.5 * bend.sum()), math.sqrt(variance))

    def spread_in_time(self, strokes: SequenceOf[PlannedStroke], speed_rad_s: float) -> Spread:
        """Compute the spread of the reorientation by strokes that may overlap: each servo has a speed of its own."""
        parameters = Parameters.of(self.robot, Plan.of(self.robot, strokes, speed_rad_s))
        sources = error_sources(parameters, self.stated)
        effective = np.flatnonzero(sources.matrix.any(axis=0))
        shifts = _NODE * sources.matrix[:, effective].T
        servos = [n for n, source in enumerate(effective) if sources.kinds[source] in _ACT_ON_ONE_ANOTHER]
        first, second = np.array(list(itertools.combinations(servos, 2)), dtype=int).reshape(-1, 2).T
        corners = [a * shifts[first] + b * shifts[second] for a in (-1.0, 1.0) for b in (-1.0, 1.0)]
        vectors = np.concatenate([np.zeros_like(shifts[:1]), -shifts, 0.0 * shifts, shifts, *corners])
        turned = self._turn_in_time(parameters, parameters.nominal + vectors)
        # What each source does alone at its three nodes, and each pair beyond that at its nine.
        alone, corner = np.split(turned[1:] - turned[0], [3 * len(shifts)])
        alone = alone.reshape(3, -1)
        both = np.zeros((3, 3, len(first)))
        both[::2, ::2] = corner.reshape(2, 2, -1) - alone[::2, None, first] - alone[None, ::2, second]
        mean = turned[0] + (_WEIGHTS @ alone).sum() + np.einsum("i,k,ikp->", _WEIGHTS, _WEIGHTS, both)
        # Analysis of variance: a pair's means over one of the two belong to the other.
        of_first, of_second = np.tensordot(_WEIGHTS, both, (0, 1)), np.tensordot(_WEIGHTS, both, (0, 0))
        rest = both - of_first[:, None] - of_second[None] + _WEIGHTS @ of_first
        np.add.at(alone.T, first, of_first.T)
        np.add.at(alone.T, second, of_second.T)
        variance = (_WEIGHTS @ (alone - _WEIGHTS @ alone) ** 2).sum()
        variance += np.einsum("i,k,ikp->", _WEIGHTS, _WEIGHTS, rest**2)
        return Spread(float(mean), math.sqrt(variance))

    @staticmethod
    def _turn_in_time(parameters: Parameters, vectors: FloatArray) -> FloatArray:
        """(s,) reorientation of robots with parameters (s, p), each stroke at its time."""
        history = parameters.history(vectors)
        # One step of order 6 for each piece of constant accelerations leaves less than the quadrature does.
        course = Propagation(parameters.robots(vectors), history, None, None, step_s=math.inf, order=6)
        return np.asarray(quaternion.angle(course.attitudes()[-1]))

    @staticmethod
    def _reorientations(parameters: Parameters, vectors: FloatArray) -> FloatArray:
        """(s,) reorientation of robots with parameters (s, p)."""
        robots: Multibody = parameters.robots(vectors)
        deltas = parameters.motion(vectors).delta_rad.T
        plan = parameters.plan
        return np.asarray(
            rotation_angle_rad(
                path_rotation(robots, plan.joints, deltas, start_rad=plan.start_rad, steps=_STEPS)
            )
        )


class RobustSummit(NamedTuple):
    """Displacements (d,) of a sequence of a problem that are best for what the robot may be."""

    displacements_rad: FloatArray
    sequence: Sequence
    problem: Problem
    spread: Spread


def most_robust(
    uncertain: Uncertain, k: float, starts: Iterable[tuple[Problem, Sequence, FloatArray]]
) -> RobustSummit:
    """Find the most robust maneuver by climbing from every start.

    A start is a problem, a sequence and displacements (d,) within the problem's time limit.
    """
    summits = [_climb(uncertain, k, *start) for start in starts]
    return max(summits, key=lambda summit: summit.spread.less(k))


def _climb(
    uncertain: Uncertain, k: float, problem: Problem, sequence: Sequence, start_rad: FloatArray
) -> RobustSummit:
    """Joints that stand still at the start do so throughout: each face of the box is a start of its own."""
    free = np.flatnonzero(start_rad >= _MOVES_RAD)

    def whole(x: FloatArray) -> FloatArray:
        every = np.zeros(len(start_rad))
        every[free] = x
        return every

    def falling(x: FloatArray) -> float:
        return -uncertain.spread(problem, sequence, whole(x)).less(k)

    def slope(x: FloatArray) -> FloatArray:
        steps = _DIFFERENCE_RAD * np.eye(len(free))
        return np.array([falling(x + step) - falling(x - step) for step in steps]) / (2.0 * _DIFFERENCE_RAD)

    optimum = optimize.minimize(
        falling,
        start_rad[free],
        jac=slope,
        method="SLSQP",
        # Two difference steps off zero, so that no stroke of the stencil is too small to be flown.
        bounds=optimize.Bounds(np.full(len(free), 2.0 * _DIFFERENCE_RAD), problem.limit_rad[free]),
        constraints=optimize.NonlinearConstraint(
            lambda x: problem.duration_s(whole(x)),
            -np.inf,
            problem.time_limit_s,
            jac=lambda x: 2.0 * problem.stroke_s_per_rad(whole(x))[free][None],
        ),
        options={"ftol": 1e-10, "maxiter": 100},
    )
    # SLSQP keeps constraints to its tolerance only: cut to the limits and to the time.
    top = problem.within_time(np.minimum(whole(optimum.x), problem.limit_rad))
    return RobustSummit(top, sequence, problem, uncertain.spread(problem, sequence, top))
