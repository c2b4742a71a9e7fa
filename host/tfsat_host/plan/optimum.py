"""The true optimum: deterministic, and without the swarm's scatter.

For one sequence the reorientation is a smooth function of the displacements, and what the time limit and the
joints' ranges leave is a convex body. So every local maximum of a grid over it is climbed by sequential quadratic
programming with gradients that are right to ten digits, and the highest summit is the answer.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from collections.abc import Sequence as SequenceOf
from typing import NamedTuple

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, minimize

from tfsat_host.plan.loops import Loops, Sequence, classes
from tfsat_host.plan.problem import Problem
from tfsat_host.robot.model import FloatArray, IntArray

GRID_POINTS = 2500
"""About how many displacements are looked at before the climb: 7 deg apart for three joints of 90 deg."""
# A summit stands at most this factor above the best grid point near it; what is lower cannot win.
_WORTH_CLIMBING = 0.85
_DIFFERENCE_RAD = 2e-3


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


class Start(NamedTuple):
    """Where a climb may start: displacements (d,) of a sequence."""

    sequence: Sequence
    displacements_rad: FloatArray


def find_optimum(
    problem: Problem,
    *,
    starts: SequenceOf[Start] = (),
    grid_points: int = GRID_POINTS,
    progress: Callable[[float], None] = lambda _done: None,
) -> tuple[Summit, tuple[Summit, ...]]:
    """The best summit, and all summits that were climbed, best first.

    Args:
        problem: The design problem.
        starts: Where to start as well, whatever the grid finds.
        grid_points: About how many points the grid has.
        progress: Told the share of the work that was done.
    """
    sequences = classes(len(problem.joints))
    candidates = _grid_maxima(problem, problem.loops(sequences), grid_points)
    progress(0.3)
    summits = [climb(problem, start.sequence, start.displacements_rad) for start in starts]
    best = max([candidates[0][0], *(summit.reorientation_rad for summit in summits)])
    for value, sequence, displacements in candidates:
        if value >= _WORTH_CLIMBING * best:
            summits.append(climb(problem, sequences[sequence], displacements))
            best = max(best, summits[-1].reorientation_rad)
        progress(0.7 / len(candidates))
    ranked = tuple(sorted(summits, key=lambda summit: -summit.reorientation_rad))
    return ranked[0], ranked


def climb(problem: Problem, sequence: Sequence, start_rad: FloatArray) -> Summit:
    """The summit of `sequence` that is reached from displacements `start_rad` (d,)."""
    loops = problem.loops((sequence,))
    d, travel = len(start_rad), problem.travel_limit_rad

    def falling(x: FloatArray) -> tuple[float, FloatArray]:
        value, gradient = value_and_gradient(loops, x)
        return -value, -gradient

    result = minimize(
        falling,
        start_rad,
        jac=True,
        method="SLSQP",
        bounds=Bounds(np.zeros(d), problem.limit_rad),
        constraints=LinearConstraint(np.ones((1, d)), -np.inf, travel),
        options={"ftol": 1e-15, "maxiter": 200},
    )
    top = np.clip(result.x, 0.0, problem.limit_rad)
    top = np.where(top < 1e-7, 0.0, top)
    top *= min(1.0, travel / top.sum()) if top.sum() > 0.0 else 1.0
    value, gradient = value_and_gradient(loops, top)
    multiplier, residual = _held_back(problem, top, gradient)
    return Summit(top, sequence, value, 0.5 * multiplier * problem.speed_rad_s, residual)


def value_and_gradient(loops: Loops, displacements_rad: FloatArray) -> tuple[float, FloatArray]:
    """Rotation angle of the only sequence of `loops` and its derivatives (d,), by differences of order 4."""
    d, h = len(displacements_rad), _DIFFERENCE_RAD
    shifts = np.concatenate([np.zeros((d, 1)), *(k * h * np.eye(d) for k in (-2, -1, 1, 2))], axis=1)
    angles = loops.angles_rad(displacements_rad[:, None] + shifts)[0]
    far_below, below, above, far_above = angles[1:].reshape(4, d)
    return float(angles[0]), np.asarray((far_below - far_above + 8.0 * (above - below)) / (12.0 * h))


def _held_back(problem: Problem, top: FloatArray, gradient: FloatArray) -> tuple[float, float]:
    """Multiplier of the time limit, and what of the gradient neither it nor a wall takes up."""
    free = (top > 0.0) & (top < problem.limit_rad - 1e-9)
    timed = top.sum() > problem.travel_limit_rad - 1e-6
    multiplier = float(gradient[free].mean()) if timed and free.any() else 0.0
    rest = gradient - multiplier
    rest = np.where(free, rest, np.where(top > 0.0, np.minimum(rest, 0.0), np.maximum(rest, 0.0)))
    return max(multiplier, 0.0), float(np.linalg.norm(rest))


def _grid_maxima(problem: Problem, loops: Loops, grid_points: int) -> list[tuple[float, int, FloatArray]]:
    """Value, sequence and displacements of the grid's local maxima, best first."""
    d = len(problem.joints)
    per_joint = max(d + 2, math.floor(grid_points ** (1.0 / d)))
    # No farther than the time allows, or a short time would leave nothing but points where one joint moves alone.
    reach = np.minimum(problem.limit_rad, problem.travel_limit_rad)
    axes = [np.linspace(0.0, most, per_joint) for most in reach]
    nodes = np.array(list(itertools.product(range(per_joint), repeat=d)))
    points = np.stack([axis[nodes[:, j]] for j, axis in enumerate(axes)])
    inside = points.sum(axis=0) <= problem.travel_limit_rad * (1.0 + 1e-12)
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
