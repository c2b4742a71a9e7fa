"""One primitive of loops in which joints overlap: a cycle in which each joint goes out and back, flown several times.

At zero angular momentum the rotation depends on the path in the space of joint angles, not on speed: strokes that
overlap cut its corners, and a cycle may begin while the last joint still comes back from the one before. Random cycles
tell which joints turn the robot fastest about the axis needed, and by how much at a time; a differential evolution
(R. Storn, K. Price, 1997) then looks for the cycle that leads to the target soonest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.optimize import Bounds, differential_evolution

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.history import SAME_INSTANT_S
from tfsat_host.plan.collisions import CONTACT_MM, least_gap
from tfsat_host.plan.orbit.primitives import Primitive, PrimitiveTable, Shape
from tfsat_host.plan.orbit.stroke_history import fly_history, stroke_history, stroke_s

# Cycles drawn for each group of joints.
_DRAWN = 200
# The more cycles, the longer the attitude is not measured.
_MAX_CYCLES = 8
# A period is at most so much longer than the longest way out and back.
_MAX_PAUSE = 0.3
_SEED = 1
# Of the evolution: generations, and how many members it has for each number of a cycle.
_GENERATIONS, _MEMBERS_A_NUMBER = 200, 8
# More than what a loop takes to turn any further about a slow axis, for each degree.
_PENALTY_S_RAD = 60.0 / np.radians(1.0)
# The search aims at less than what is allowed: it comes close to its aim, not below it.
_AIM = 0.98
# A joint that moves less makes no stroke.
_MIN_DISPLACEMENT_RAD = np.radians(0.1)
# At which bodies are looked at for collisions.
_POSES = 400


def find_overlapping_primitive(
    table: PrimitiveTable, needed: FloatArray, allowed_rad: float, moving_at_once: int
) -> Primitive | None:
    """Find a primitive with overlapping strokes that leads to a rotation `needed` (4,).

    Args:
        table: The robot, its start pose, limits and servos.
        needed: The rotation, body axes.
        allowed_rad: Greatest permissible remaining angle.
        moving_at_once: Greatest number of joints that move at the same time; loops have as many joints at most.

    Returns:
        A primitive that leaves no more than allowed, and in which no body strikes another; None if none was found.
    """
    axis = quaternion.logarithm(needed)
    angle_rad = float(np.linalg.norm(axis))
    random = np.random.default_rng(_SEED)
    drawn = list[tuple[float, float, _Cycles]]()
    size = min(moving_at_once, table.body.n_joints)
    for joints in combinations(range(table.body.n_joints), size):
        cycle = _Cycles(table, joints, 1)
        x = cycle.of_unit(random.random((3 * size + 1, _DRAWN)))
        turns_rad = axis @ quaternion.logarithm(cycle.rotations(x)) / angle_rad
        # Rank by the rate of cycles that follow one another without end.
        best = int(np.argmax(turns_rad / x[-2]))
        drawn.append((float(turns_rad[best] / x[-2, best]), float(turns_rad[best]), cycle))
    _, turn_rad, cycle = max(drawn, key=lambda drawn_cycle: drawn_cycle[0])
    # A cycle that hardly turns about the axis would be flown for minutes.
    if turn_rad * _MAX_CYCLES < angle_rad:
        return None
    count = max(1, round(angle_rad / turn_rad))
    # One cycle more, each of a smaller angle, is sometimes faster, or all that is found.
    found = (replace(cycle, count=cycles).search(needed, allowed_rad) for cycles in (count, count + 1))
    free = [primitive for primitive in found if primitive is not None and not _strikes(table, primitive)]
    return min(free, key=lambda primitive: primitive.duration_s, default=None)


@dataclass(frozen=True, eq=False)
class _Cycles:
    """Cycles of d joints as vectors (3 d + 2, ...).

    They hold displacements in rad, starts of the ways out and of the ways back in s, the period of a cycle, and the
    duration of all cycles.

    Attributes:
        table: The robot.
        joints: (d,) their indices.
        count: How often the cycle is flown.
    """

    table: PrimitiveTable
    joints: tuple[int, ...]
    count: int

    def of_unit(self, unit: FloatArray) -> FloatArray:
        """Return the cycles (3 d + 2, b) of points (3 d + 1, b) of the unit box: each keeps ranges and order."""
        joints = list(self.joints)
        size, early, late = unit[:-1].reshape(3, len(joints), -1)
        low, high = (self.table.limits_rad - self.table.start_rad[:, None])[joints].T[..., None]
        displacement = low + size * (high - low)
        stroke = stroke_s(self.table.robot, joints, displacement)
        period = 2.0 * stroke.max(axis=0) * (1.0 + _MAX_PAUSE * unit[-1])
        # Every joint is back before its next way out, one period after the last.
        out = early * period
        out -= out.min(axis=0)
        back = out + stroke + late * (period - 2.0 * stroke)
        end = (self.count - 1) * period + (back + stroke).max(axis=0)
        return np.concatenate([displacement, out, back, period[None], end[None]])

    def strokes(self, x: FloatArray) -> tuple[list[int], FloatArray, FloatArray]:
        """Return joints (k,), angles (k, ...) and starts (k, ...) of all strokes, cycle by cycle."""
        displacement, out, back = x[:-2].reshape(3, len(self.joints), *x.shape[1:])
        starts = [start + number * x[-2] for number in range(self.count) for start in (out, back)]
        joints = list(self.joints) * (2 * self.count)
        return joints, np.concatenate([displacement, -displacement] * self.count), np.concatenate(starts)

    def rotations(self, x: FloatArray) -> FloatArray:
        """Quaternions (4, b) of cycles (3 d + 2, b)."""
        if self.count == 1:
            return np.asarray(
                fly_history(self.table.body, stroke_history(self.table.robot, *self.strokes(x)))[-1]
            )
        # All periods after the first are alike: two cycles have one of each, and what follows the last.
        strokes = replace(self, count=2).strokes(x)
        history = stroke_history(self.table.robot, *strokes, np.stack([x[-2], 2.0 * x[-2]]))
        attitudes = fly_history(self.table.body, history)
        columns = np.arange(x.shape[1])
        once, twice = (
            attitudes[(history.breaks_s < number * x[-2]).sum(axis=0), :, columns].T for number in (1, 2)
        )
        period = quaternion.product(quaternion.inverse(once), twice)
        periods = quaternion.exponential((self.count - 1) * quaternion.logarithm(period))
        last = quaternion.product(quaternion.inverse(twice), attitudes[-1])
        return np.asarray(quaternion.product(quaternion.product(once, periods), last))

    def search(self, needed: FloatArray, allowed_rad: float) -> Primitive | None:
        """Search for the fastest cycles that lead to a rotation (4,); None if they leave more than is allowed."""

        def penalized_s(unit: FloatArray) -> FloatArray:
            x = self.of_unit(unit)
            rest = quaternion.product(quaternion.inverse(self.rotations(x)), needed[:, None])
            missed_rad = np.maximum(quaternion.angle(rest) - _AIM * allowed_rad, 0.0)
            return np.asarray(x[-1] + _PENALTY_S_RAD * missed_rad)

        numbers = 3 * len(self.joints) + 1
        evolved = differential_evolution(
            penalized_s,  # type: ignore[arg-type]  # the stubs know no vectorized functions
            Bounds(np.zeros(numbers), np.ones(numbers)),
            maxiter=_GENERATIONS,
            popsize=_MEMBERS_A_NUMBER,
            tol=0.0,
            polish=False,
            vectorized=True,
            updating="deferred",
            rng=_SEED,
        )
        x = self.of_unit(evolved.x[:, None])[:, 0]
        if (np.abs(x[: len(self.joints)]) < _MIN_DISPLACEMENT_RAD).any():
            return None
        primitive = self._primitive(x)
        rest = quaternion.product(quaternion.inverse(primitive.quaternion_xyzw), needed)
        return primitive if float(quaternion.angle(rest)) <= allowed_rad else None

    def _primitive(self, x: FloatArray) -> Primitive:
        """Build the primitive of a cycle (3 d + 2,), with its strokes in the order of their starts."""
        joints, angles, starts = self.strokes(x)
        strokes_s, d = stroke_s(self.table.robot, joints, angles), len(self.joints)
        starts -= starts.min()
        # Rounding must not let a stroke begin before the same joint's last one has ended.
        for k in range(d, len(joints)):
            starts[k] = max(starts[k], starts[k - d] + strokes_s[k - d] + SAME_INSTANT_S)
        signed = np.tile(np.concatenate([np.arange(1, d + 1), -np.arange(1, d + 1)]), self.count)
        order = np.argsort(starts, kind="stable")
        history = stroke_history(self.table.robot, joints, angles[:, None], starts[:, None])
        return Primitive(
            Shape(self.joints, tuple(signed[order].tolist())),
            x[:d],
            fly_history(self.table.body, history, 1.0)[-1, :, 0],
            float((starts + strokes_s).max()),
            np.column_stack([starts, starts + strokes_s])[order],
        )


def _strikes(table: PrimitiveTable, primitive: Primitive) -> bool:
    """Return whether a body strikes another on the way, by the boxes of the robot file; without boxes none does."""
    if any(len(shape) == 0 for shape in table.robot.shape_m):
        return False
    assert primitive.spans_s is not None
    joints, angles = zip(*primitive.strokes, strict=True)
    history = stroke_history(table.robot, joints, np.array(angles), primitive.spans_s[:, 0])
    poses_rad = history.angles_rad(np.linspace(0.0, primitive.duration_s, _POSES))
    return least_gap(table.robot, poses_rad).gap_mm < -CONTACT_MM
