"""Strokes of different joints that overlap as they like: the search for the loop that turns the robot farthest.

Each joint moves out and back once, which makes three numbers a joint: its displacement, the start of its way out, the
start of its way back. A seeded differential evolution finds basins, sequential quadratic programming climbs to their
summits, and a compass search carries the best of them to the sequencer's grid of times and hundredths of a degree.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.history import ServoMotion, history_of
from tfsat_host.dynamics.propagate import Propagation
from tfsat_host.maneuver.maneuver import DEFAULT_PAUSE_S
from tfsat_host.plan.parameters import PlannedStroke
from tfsat_host.plan.problem import GRID_S, Problem
from tfsat_host.plan.tower_room import TowerRoom
from tfsat_host.units import CDEG_PER_DEG
from tfsat_host.worker_processes import SerialExecutor

Worth = Callable[[FloatArray], FloatArray]
"""(b,) what candidates (3, d, b) are worth, rad; in place of their reorientation."""

# Four independent searches: one of them ended at a lower summit in a third of all seeds.
ISLANDS = 4
# Generations of an island, and how many members it has for each number of a candidate.
_GENERATIONS, _MEMBERS_A_NUMBER = 70, 10
# Beyond the tower's limits a mm costs more than it gains anywhere.
_PENALTY_RAD_MM = math.radians(2.0)
# Instants of a flight at which the tower's limits are looked at, beside those at which a servo's acceleration changes.
INSTANTS = 60
_DIFFERENCE = 1e-6
# One hundredth of a degree, and the step of the sequencer's grid.
_GRID = np.array([math.radians(1.0 / CDEG_PER_DEG), GRID_S, GRID_S])[:, None, None]
_NOTHING_RAD = 1e-9
_COMPASS_DEG = (2.0, 0.5, 0.1, 0.02)


@dataclass(frozen=True, eq=False)
class OverlappingStrokes:
    """The search space: d joints that each move out and back once.

    A candidate is an array (3, d, ...): displacements in rad, negative where a joint moves out that way; starts of the
    ways out, and of the ways back, in s after the first possible start.

    Attributes:
        problem: Joints, ranges, servos, time limit.
        room: What the drop tower leaves; None: nothing but time limits the robot.
    """

    problem: Problem
    room: TowerRoom | None = None

    def candidates(self, unit: FloatArray) -> FloatArray:
        """Return the candidates (3, d, b) of points (3 d, b) of the unit box: each keeps ranges and time."""
        problem = self.problem
        size, early, late = unit.reshape(3, len(problem.joints), -1)
        most = np.minimum(problem.sides_rad, problem.farthest_rad(0.5 * problem.time_limit_s)[:, None])
        displacement = size * most.sum(axis=1, keepdims=True) - most[:, :1]
        # Shares of the time that the strokes leave: before the way out, then before the way back.
        stroke = problem.stroke_s(np.abs(displacement))
        remaining = problem.time_limit_s - 2.0 * stroke
        out = early * remaining
        back = out + stroke + late * (remaining - out)
        return np.stack([displacement, out, back])

    def strokes(self, candidate: FloatArray) -> list[PlannedStroke]:
        """Return the strokes of a candidate (3, d) in the order of their starts; a joint that stands has none."""
        strokes = [
            PlannedStroke(joint, sign * displacement, DEFAULT_PAUSE_S + start)
            for joint, (displacement, *starts) in zip(self.problem.joints, candidate.T.tolist(), strict=True)
            for sign, start in zip((1.0, -1.0), starts, strict=True)
            if abs(displacement) >= 0.5 * _GRID[0, 0, 0]
        ]
        return sorted(strokes, key=lambda stroke: (round(stroke.start_s, 9), stroke.joint))

    def keep_limits(self, candidates: FloatArray) -> BoolArray:
        """Return for candidates (3, d, b) whether they keep ranges, the order of each joint's strokes and the time."""
        displacement, out, back = candidates
        stroke = self.problem.stroke_s(np.abs(displacement)) - 1e-9
        below, above = self.problem.sides_rad.T[..., None] + 1e-9
        kept = (displacement >= -below) & (displacement <= above) & (out >= 0.0)
        kept &= (back >= out + stroke) & (back + stroke <= self.problem.time_limit_s)
        return np.asarray(kept.all(axis=0))

    def fly(self, candidates: FloatArray, instants: int = INSTANTS) -> tuple[FloatArray, FloatArray]:
        """Return rotation vectors (3, b) of the base by candidates (3, d, b), and the room (m, b) in the tower, mm.

        The room is that of `instants`, and of those at which a servo's acceleration changes.
        """
        problem, count = self.problem, candidates.shape[2]
        displacement, out, back = candidates
        delta = np.concatenate([displacement, -displacement])
        motion = ServoMotion.of(
            problem.joints * 2,
            delta,
            DEFAULT_PAUSE_S + np.concatenate([out, back]),
            np.abs(delta) / problem.speed_rad_s,
            np.tile(problem.max_rate_rad_s, 2)[:, None],
            np.tile(problem.acceleration_rad_s2, 2)[:, None],
        )
        # The first and the last instant stand for the release and the landing: nothing moves before and after.
        even = DEFAULT_PAUSE_S + np.linspace(0.0, self.problem.time_limit_s, instants + 2)
        breaks = np.sort(np.concatenate([np.tile(even, (count, 1)).T, motion.changes_s]), axis=0)
        history = history_of(motion, breaks, problem.start_rad)
        course = Propagation(problem.body, history, None, None, step_s=math.inf, order=6)
        attitude = course.attitudes().swapaxes(0, 1)
        turned = quaternion.logarithm(attitude[:, -1])
        if self.room is None:
            return turned, np.ones((1, count))
        # A loop ends in the pose in which it began.
        angles = history.coefficients[-1][[*range(len(breaks) - 1), 0]]
        return turned, self.room.remaining_mm(problem.body, breaks, np.moveaxis(angles, 1, 0), attitude)

    def summits(
        self,
        seed: int,
        starts: Iterable[FloatArray] = (),
        progress: Callable[[float], None] = lambda _done: None,
        pool: Executor | None = None,
    ) -> list[FloatArray]:
        """Find points (3 d,) of the unit box where the reorientation is at a maximum, best first.

        Args:
            seed: Of the evolution's random numbers, from 0: the same summits to the last bit.
            starts: Points of the unit box to climb from as well.
            progress: Called with the share of the work that was done.
            pool: Searches the islands; None: this process does.
        """
        # The pool is at work on the islands while this process climbs from the given points.
        islands = (pool or SerialExecutor()).map(
            self._search_island, np.random.SeedSequence(seed).spawn(ISLANDS)
        )
        climbed = [self.climb(start) for start in starts]
        for summit in islands:
            climbed.append(summit)
            progress(1.0 / ISLANDS)
        losses = self._loss(self.candidates(np.column_stack(climbed)), instants=INSTANTS)
        return [climbed[number] for number in np.argsort(losses, kind="stable")]

    def _loss(self, candidates: FloatArray, worth: Worth | None = None, instants: int = 0) -> FloatArray:
        """Compute what is minimized, (b,) rad: a penalty beyond the tower's limits, less the worth."""
        turned, room_mm = self.fly(candidates, instants)
        value = np.linalg.norm(turned, axis=0) if worth is None else worth(candidates)
        return np.asarray(_PENALTY_RAD_MM * np.maximum(0.0, -room_mm.min(axis=0)) - value)

    def _search_island(self, seed: np.random.SeedSequence) -> FloatArray:
        """Return the summit (3 d,) that a differential evolution leads to (R. Storn, K. Price, 1997)."""
        numbers = 3 * len(self.problem.joints)
        evolved = optimize.differential_evolution(
            lambda unit: self._loss(self.candidates(unit)),  # type: ignore[arg-type,misc]  # stubs: one point
            optimize.Bounds(np.zeros(numbers), np.ones(numbers)),
            maxiter=_GENERATIONS,
            popsize=_MEMBERS_A_NUMBER,
            tol=0.0,
            polish=False,
            vectorized=True,
            updating="deferred",
            rng=np.random.default_rng(seed),
        )
        return self.climb(evolved.x)

    def climb(self, start: FloatArray, worth: Worth | None = None) -> FloatArray:
        """Climb from a point (3 d,) of the unit box to the summit above it, or of what is worth most."""
        latest: dict[bytes, tuple[float, FloatArray, FloatArray, FloatArray]] = {}

        def evaluate(unit: FloatArray) -> tuple[float, FloatArray, FloatArray, FloatArray]:
            """Loss, its gradient, the room and its gradient, all from one batch."""
            if unit.tobytes() not in latest:
                latest.clear()
                # Differences lead into the box.
                step = np.where(unit > 0.5, -_DIFFERENCE, _DIFFERENCE)
                candidates = self.candidates(np.column_stack([unit, unit[:, None] + np.diag(step)]))
                turned, room_mm = self.fly(candidates)
                value = np.linalg.norm(turned, axis=0) if worth is None else worth(candidates)
                slopes = [(values[..., 1:] - values[..., :1]) / step for values in (-value, room_mm)]
                latest[unit.tobytes()] = float(-value[0]), slopes[0], room_mm[:, 0], slopes[1]
            return latest[unit.tobytes()]

        def loss(unit: FloatArray) -> tuple[float, FloatArray]:
            return evaluate(unit)[:2]

        summit = optimize.minimize(
            loss,
            start,
            jac=True,
            method="SLSQP",
            bounds=optimize.Bounds(np.zeros_like(start), np.ones_like(start)),
            constraints=optimize.NonlinearConstraint(
                lambda unit: evaluate(unit)[2], 0.0, np.inf, jac=lambda unit: evaluate(unit)[3]
            ),
            options={"ftol": 1e-7, "maxiter": 60},
        )
        return np.asarray(np.clip(summit.x, 0.0, 1.0))

    def carry_to_grid(self, point: FloatArray, worth: Worth | None = None) -> FloatArray:
        """Return the best candidate (3, d) near a point (3 d,), on the grids of times and hundredths of a degree."""
        joints = len(self.problem.joints)
        place = self._nearest_on_grid(self.candidates(point[:, None]))
        best = self._loss(place * _GRID, worth, INSTANTS)[0]
        # Go to the best neighbour while it is better, then look closer.
        for size_deg in _COMPASS_DEG:
            steps = _compass(joints, round(CDEG_PER_DEG * size_deg), pairs=worth is None)
            while True:
                near = place + steps
                near = near[..., self.keep_limits(near * _GRID)]
                losses = self._loss(near * _GRID, worth, INSTANTS)
                if not losses.min() < best - _NOTHING_RAD:
                    break
                best, place = losses.min(), near[..., [int(losses.argmin())]]
        return np.asarray((place * _GRID)[..., 0])

    def _nearest_on_grid(self, candidate: FloatArray) -> FloatArray:
        """Return whole numbers of `_GRID` near a candidate (3, d, 1) that keep its limits."""
        size, out, back = np.rint(candidate / _GRID)
        while True:
            stroke = self.problem.stroke_s(np.abs(size * _GRID[0])) - 1e-9
            steps, last = np.ceil(stroke / GRID_S), np.floor((self.problem.time_limit_s - stroke) / GRID_S)
            first = np.clip(out, 0.0, np.maximum(last - steps, 0.0))
            place = np.stack([size, first, np.clip(back, first + steps, np.maximum(last, first + steps))])
            if self.keep_limits(place * _GRID)[0]:
                return place
            # Two strokes that need every step of the grid shrink until they fit.
            size = np.trunc(0.998 * size)


def _compass(joints: int, size: int, *, pairs: bool) -> FloatArray:
    """Return steps (3, d, b): none, of one number, and of two at once."""
    numbers = 3 * joints
    steps = [np.zeros(numbers), *np.eye(numbers), *-np.eye(numbers)]
    if pairs:
        steps = [one + other for one, other in itertools.combinations(steps, 2)]
    return np.asarray((np.array(steps) * np.repeat([size, 1, 1], joints)).T.reshape(3, joints, -1))
