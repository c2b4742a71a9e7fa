"""The true optimum of a design: deterministic, and without a swarm's scatter.

For one sequence the reorientation is a smooth function of the displacements, and what the time limit and the
joints' ranges leave is a convex body, but for corners where a joint hardly moves and its servo only speeds up and slows
down. So every local maximum of a grid over it is climbed by sequential quadratic programming with gradients that are
right to ten digits, and the highest summit is the answer.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from collections.abc import Sequence as SequenceOf
from typing import NamedTuple

import numpy as np
from scipy import optimize

from tfsat_host.arrays import FloatArray, IntArray
from tfsat_host.plan.loops import Loops, Sequence, classes
from tfsat_host.plan.problem import Problem

GRID_POINTS = 2500
"""About how many displacements are looked at before the climb: 7 deg apart for three joints of 90 deg."""
# A summit stands at most this factor above the best grid point near it; what is lower cannot win.
_WORTH_CLIMBING = 0.85
# Order 4 leaves about the fourth power of this step, some 1e-11, of a derivative.
_DIFFERENCE_RAD = 2e-3
_MAX_RESIDUAL = 1e-6
"""Of a summit, rad/rad: less is rounding."""


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
    """Return the best summit, and all summits that were climbed, best first.

    Args:
        problem: The design problem.
        starts: Sequences and displacements (d,) to climb from as well, whatever the grid finds.
        grid_points: About how many points the grid has.
        least_rad: What was reached elsewhere: a grid point well below it is not climbed from, but for the best.
        progress: Called with the share of the work that was done.
    """
    sequences = classes(len(problem.joints))
    # Scan all sequences on one grid, then climb only from maxima that could still win.
    candidates = _grid_maxima(problem, problem.loops(sequences), grid_points)
    progress(0.3)
    summits = [climb(problem, *start) for start in starts]
    best = max([least_rad, candidates[0][0], *(summit.reorientation_rad for summit in summits)])
    # Best first: early summits raise the bar for the rest.
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
    while summit.residual > _MAX_RESIDUAL:
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

    # Box bounds and one inequality, the time of all strokes, each with its Jacobian.
    result = optimize.minimize(
        falling,
        start_rad,
        jac=True,
        method="SLSQP",
        bounds=optimize.Bounds(np.zeros(d), problem.limit_rad),
        constraints=optimize.NonlinearConstraint(
            # Below zero, where the solver may stray, a stroke has no time.
            lambda x: problem.duration_s(np.maximum(x, 0.0)),
            -np.inf,
            problem.time_limit_s,
            jac=lambda x: 2.0 * problem.stroke_s_per_rad(x)[None],
        ),
        options={"ftol": 1e-13, "maxiter": 200},
    )
    # Back into the feasible set: the box, joints that stand still, and the time limit.
    top = np.clip(result.x, 0.0, problem.limit_rad)
    top = np.where(top < 1e-7, 0.0, top)
    top = problem.within_time(top)
    value, gradient = value_and_gradient(loops, top)
    return Summit(top, sequence, value, *_held_back(problem, top, gradient))


def value_and_gradient(loops: Loops, displacements_rad: FloatArray) -> tuple[float, FloatArray]:
    """Return the rotation angle of the only sequence of `loops`, rad, and its derivatives (d,), by order 4."""
    d, h = len(displacements_rad), _DIFFERENCE_RAD
    # The stencil's 4 d + 1 points are one batch of the integrator.
    shifts = np.concatenate([np.zeros((d, 1)), *(k * h * np.eye(d) for k in (-2, -1, 1, 2))], axis=1)
    angles = loops.angles_rad(displacements_rad[:, None] + shifts)[0]
    far_below, below, above, far_above = angles[1:].reshape(4, d)
    return float(angles[0]), np.asarray((far_below - far_above + 8.0 * (above - below)) / (12.0 * h))


def _held_back(problem: Problem, top: FloatArray, gradient: FloatArray) -> tuple[float, float]:
    """Gain by more time (rad/s), and what of the gradient neither the time limit nor a wall takes up."""
    # Joints off their walls fix the multiplier; those at a wall are judged by sign.
    free = (top > 0.0) & (top < problem.limit_rad - 1e-9)
    timed = float(problem.duration_s(top)) > problem.time_limit_s - 1e-6
    slower = 2.0 * problem.stroke_s_per_rad(top)
    # Lagrange multiplier of the time limit, by least squares: what a further second would give.
    multiplier = (
        float(gradient[free] @ slower[free] / (slower[free] @ slower[free])) if timed and free.any() else 0.0
    )
    rest = gradient - multiplier * slower
    # Karush-Kuhn-Tucker residual: at a wall only a slope that leads back inside counts.
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
    # Only points within the time limit are feasible.
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
    """Return the indices of nodes (m, d) that no neighbour along an axis exceeds."""
    d = nodes.shape[1]
    # A border of -inf, and -inf where no point is, spares every test at the edges.
    field = np.full((per_joint + 2,) * d, -np.inf)
    field[tuple((nodes + 1).T)] = values
    top = np.ones(len(nodes), dtype=bool)
    for axis in range(d):
        for shift in (-1, 1):
            neighbour = nodes + 1
            neighbour[:, axis] += shift
            top &= values >= field[tuple(neighbour.T)]
    return [int(i) for i in np.nonzero(top)[0]]
