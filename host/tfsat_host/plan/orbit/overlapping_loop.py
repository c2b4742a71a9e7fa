"""One primitive of loops in which joints overlap: a cycle in which each joint goes out and back, flown several times.

At zero angular momentum the rotation depends on the path in the space of joint angles, not on speed: strokes that
overlap cut its corners, and a cycle may begin while the last joint still comes back from the one before. Random
cycles are ranked by their rate about the axis needed; the best is the starting point of sequential quadratic
programming (SLSQP) for the least time that leads to the target.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy import optimize

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.history import SAME_INSTANT_S
from tfsat_host.plan.collisions import CONTACT_MM, least_gap
from tfsat_host.plan.orbit.primitives import Primitive, PrimitiveTable, Shape
from tfsat_host.plan.orbit.stroke_history import fly_history, stroke_history, stroke_s

# Cycles drawn for each group of joints; the best of all is optimized.
_DRAWN = 200
_SEED = 1
# The more cycles, the longer the attitude is not measured.
_MAX_CYCLES = 6
# At which bodies are looked at for collisions.
_POSES = 400
_DIFFERENCE = 1e-6
_ITERATIONS = 80
_MAX_LONGER = 1.3
# A rotation that counts as much as a second.
_SCALE_RAD = np.radians(5.0)
# A joint that moves less than this makes no cycle.
_MIN_DISPLACEMENT_RAD = np.radians(5.0)
# Short of what is allowed by a little, or rounding would leave more.
_ALMOST = 0.999


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
    vector = quaternion.logarithm(needed)
    angle = float(np.linalg.norm(vector))
    random = np.random.default_rng(_SEED)
    drawn = list[tuple[float, float, _Cycles, FloatArray]]()
    size = min(moving_at_once, table.body.n_joints)
    for joints in combinations(range(table.body.n_joints), size):
        cycle = _Cycles(table, joints, 1)
        x = cycle.draw(random, _DRAWN)
        turns = vector @ quaternion.logarithm(cycle.rotations(x)) / angle
        # Rank by the rate of cycles that follow one another without end.
        best = int(np.argmax(turns / x[-2]))
        drawn.append((float(turns[best] / x[-2, best]), float(turns[best]), cycle, x[:, best]))
    _, turn, cycle, x = max(drawn, key=lambda drawn_cycle: drawn_cycle[0])
    # A cycle that hardly turns about the axis would be flown for minutes.
    if turn * _MAX_CYCLES < angle:
        return None
    primitive = _Cycles(table, cycle.joints, int(np.ceil(angle / turn))).optimize(x, needed, allowed_rad)
    return None if primitive is None or _strikes(table, primitive) else primitive


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

    def draw(self, random: np.random.Generator, number: int) -> FloatArray:
        """Draw cycles (3 d + 2, number) that keep all limits."""
        joints, shape = list(self.joints), (len(self.joints), number)
        room = (self.table.limits_rad - self.table.start_rad[:, None])[joints]
        side = np.where(
            random.random(shape) * np.ptp(room, axis=1)[:, None] < room[:, 1:], room[:, 1:], room[:, :1]
        )
        displacement = side * random.uniform(0.25, 1.0, shape)
        stroke = stroke_s(self.table.robot, joints, displacement)
        period = 2.0 * stroke.max(axis=0) * random.uniform(1.0, 1.2, number)
        out = random.random(shape) * period
        out -= out.min(axis=0)
        back = out + stroke + random.random(shape) * (period - 2.0 * stroke)
        return np.concatenate([displacement, out, back, period[None], (back + stroke).max(axis=0)[None]])

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

    def _margins_s(self, x: FloatArray) -> FloatArray:
        """(4 d, b) by how much each joint comes back once it is out, goes out again once it is back, is in time."""
        displacement, out, back = x[:-2].reshape(3, len(self.joints), -1)
        stroke = stroke_s(self.table.robot, self.joints, displacement)
        end = back + stroke
        early = np.stack([back - out - stroke, out + x[-2] - end, x[-1] - (self.count - 1) * x[-2] - end])
        return np.asarray(np.concatenate([*early, x[-2] - out]))

    def optimize(self, start: FloatArray, needed: FloatArray, allowed_rad: float) -> Primitive | None:
        """Minimize the duration from a cycle (3 d + 2,) on; None if the result leaves more than is allowed."""
        count, d = len(start), len(self.joints)
        first = start.copy()
        first[-1] += (self.count - 1) * first[-2]
        latest: dict[bytes, tuple[FloatArray, FloatArray]] = {}

        def residual(x: FloatArray) -> tuple[FloatArray, FloatArray]:
            """Remaining rotation in units of the scale, then margins, (3 + 4 d,), and their slopes."""
            if x.tobytes() not in latest:
                latest.clear()
                columns = np.column_stack([x, x[:, None] + _DIFFERENCE * np.eye(count)])
                rest = quaternion.product(quaternion.inverse(self.rotations(columns)), needed[:, None])
                values = np.concatenate([quaternion.logarithm(rest) / _SCALE_RAD, self._margins_s(columns)])
                latest[x.tobytes()] = values[:, 0], (values[:, 1:] - values[:, :1]) / _DIFFERENCE
            return latest[x.tobytes()]

        # Slacks x[-3:] hold the scaled miss: equality rows tie them to it, a ball bounds their length.
        tie = np.hstack([np.zeros((3, count)), np.eye(3)])
        room = (self.table.limits_rad - self.table.start_rad[:, None])[list(self.joints)]
        low, high = np.zeros(count + 3), np.full(count + 3, np.inf)
        low[:d] = np.where(first[:d] > 0.0, _MIN_DISPLACEMENT_RAD, room[:, 0])
        high[:d] = np.where(first[:d] > 0.0, room[:, 1], -_MIN_DISPLACEMENT_RAD)
        # Cycles that last much longer are no better, but the solver's first steps lead there.
        high[d:count] = _MAX_LONGER * first[-1]
        high[d : count - 1] = _MAX_LONGER * first[-2]
        low[-3:] = -np.inf
        seconds: FloatArray = np.eye(count + 3)[count - 1]

        def duration(x: FloatArray) -> tuple[float, FloatArray]:
            return float(seconds @ x), seconds

        solution = optimize.minimize(
            duration,
            np.append(first, residual(first)[0][:3]),
            jac=True,
            method="SLSQP",
            bounds=optimize.Bounds(low, high),
            constraints=[
                optimize.NonlinearConstraint(
                    lambda x: residual(x[:-3])[0][:3] - x[-3:],
                    0.0,
                    0.0,
                    jac=lambda x: np.hstack([residual(x[:-3])[1][:3], np.zeros((3, 3))]) - tie,
                ),
                optimize.NonlinearConstraint(
                    lambda x: residual(x[:-3])[0][3:],
                    0.0,
                    np.inf,
                    jac=lambda x: np.hstack([residual(x[:-3])[1][3:], np.zeros((4 * d, 3))]),
                ),
                optimize.NonlinearConstraint(
                    lambda x: x[-3:] @ x[-3:],
                    -np.inf,
                    (_ALMOST * allowed_rad / _SCALE_RAD) ** 2,
                    jac=lambda x: np.append(np.zeros(count), 2.0 * x[-3:])[None],
                ),
            ],
            options={"maxiter": _ITERATIONS, "ftol": 1e-3},
        )
        primitive = self._primitive(np.clip(solution.x, low, high)[:count])
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
