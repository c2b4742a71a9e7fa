"""Free joint rates instead of strokes: the best path by direct collocation, with CasADi and IPOPT.

A second opinion on `design --together` that shares nothing with it but the robot's numbers: dynamics, transcription and
optimizer are others. Joint rates are constant in each interval and free between their limits; the base's attitude, a
quaternion, is a polynomial there that fulfills the differential equation at Gauss points (J. T. Betts, "Practical
Methods for Optimal Control Using Nonlinear Programming", 2020, chapter 4).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import casadi as ca
import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.robot import RobotModel

DEGREE: Final = 3
"""Of the attitude's polynomials: an interval's end is right to the sixth power of its length."""
MAX_ITERATIONS: Final = 400


@dataclass(frozen=True)
class RateLimits:
    """What the joints may do: greatest rate, rad/s, greatest acceleration, rad/s^2 (inf: none), range, rad, time, s."""

    rate_rad_s: float
    acceleration_rad_s2: float
    range_rad: tuple[float, float]
    duration_s: float


@dataclass(frozen=True, eq=False)
class FreePath:
    """The end of a search: reorientation in rad, joint rates (n, 3) in rad/s, and whether the optimizer converged."""

    reorientation_rad: float
    rates_rad_s: FloatArray
    converged: bool


def base_rate(robot: RobotModel) -> ca.Function:
    """Return the base's rate (3,), base axes, by joint angles and rates (n,): that of zero angular momentum."""
    joints, bodies = len(robot.joint_axis), len(robot.mass_kg)
    angle, rate = ca.SX.sym("angle", joints), ca.SX.sym("rate", joints)
    turn: dict[int, Any] = {robot.base: ca.SX.eye(3)}
    shift: dict[int, Any] = {robot.base: ca.SX.zeros(3)}
    spin: dict[int, Any] = {robot.base: ca.SX.zeros(3)}
    ends = [
        (j, int(i), int(o)) for j, (i, o) in enumerate(zip(robot.joint_inner, robot.joint_outer, strict=True))
    ]
    # Walk from the base outwards; a joint that is crossed from outside in turns the other way.
    while len(turn) < bodies:
        for joint, inner, outer in ends:
            for near, far, sign in ((inner, outer, 1.0), (outer, inner, -1.0)):
                if near in turn and far not in turn:
                    axis, point = ca.DM(robot.joint_axis[joint]), ca.DM(robot.joint_point_m[joint])
                    turn[far] = turn[near] @ _rotation(axis, sign * angle[joint])
                    shift[far] = shift[near] + turn[near] @ point - turn[far] @ point
                    spin[far] = spin[near] + turn[near] @ (sign * rate[joint] * axis)
    mass = robot.mass_kg
    com = [shift[i] + turn[i] @ ca.DM(robot.origin_m[i] + robot.com_m[i]) for i in range(bodies)]
    center = sum(mass[i] * com[i] for i in range(bodies)) / mass.sum()
    inertia, momentum = ca.SX.zeros(3, 3), ca.SX.zeros(3)
    for i in range(bodies):
        arm, own = com[i] - center, turn[i] @ ca.DM(robot.inertia_kg_m2[i]) @ turn[i].T
        inertia += own + mass[i] * (ca.dot(arm, arm) * ca.SX.eye(3) - arm @ arm.T)
        momentum += own @ spin[i] + mass[i] * ca.cross(arm, ca.jtimes(arm, angle, rate))
    return ca.Function("base_rate", [angle, rate], [-ca.solve(inertia, momentum)])


class FreeRates:
    """The paths of joints whose rates are free, as a nonlinear program over `intervals` equal intervals."""

    def __init__(self, robot: RobotModel, limits: RateLimits, intervals: int) -> None:
        self._joints, self._intervals, self._limits = len(robot.joint_axis), intervals, limits
        self._step_s = limits.duration_s / intervals
        attitude, angle = ca.SX.sym("attitude", 4), ca.SX.sym("angle", self._joints)
        rate = ca.SX.sym("rate", self._joints)
        omega, scalar, vector = base_rate(robot)(angle, rate), attitude[0], attitude[1:]
        change = 0.5 * ca.vertcat(-ca.dot(vector, omega), scalar * omega + ca.cross(vector, omega))
        self._attitude_rate = ca.Function("attitude_rate", [attitude, angle, rate], [change])
        self._solver, self._sides = self._transcribe()

    def find_best(self, rates_rad_s: FloatArray) -> FreePath:
        """Climb from joint rates (intervals, n) to the nearest path that turns the base farthest."""
        solution = self._solver(x0=self._guess(rates_rad_s), **self._sides)
        rates = np.array(solution["x"])[: rates_rad_s.size].reshape(rates_rad_s.shape)
        # The scalar part of the last attitude is the cosine of half the angle.
        angle = 2.0 * math.acos(min(1.0, float(solution["f"])))
        return FreePath(angle, rates, bool(self._solver.stats()["success"]))

    def stroke_rates(self, strokes: Sequence[tuple[int, float, float]]) -> FloatArray:
        """Return joint rates (intervals, n) of strokes (joint, displacement in rad, start in s) at full speed."""
        edges, limit = np.arange(self._intervals + 1) * self._step_s, self._limits.rate_rad_s
        rates = np.zeros((self._intervals, self._joints))
        for joint, delta_rad, start_s in strokes:
            moving_s = np.clip(edges, start_s, start_s + abs(delta_rad) / limit)
            rates[:, joint] += math.copysign(limit, delta_rad) * np.diff(moving_s) / self._step_s
        return rates

    def _transcribe(self) -> tuple[ca.Function, dict[str, FloatArray]]:
        n, joints, step = self._intervals, self._joints, self._step_s
        points = np.append(0.0, ca.collocation_points(DEGREE, "legendre"))
        slopes, ends = _lagrange(points)
        rates, angles = ca.MX.sym("rates", joints, n), ca.MX.sym("angles", joints, n + 1)
        starts, inner = ca.MX.sym("starts", 4, n), ca.MX.sym("inner", 4, n * DEGREE)
        # Joint angles grow linearly within an interval.
        every = ca.sparsify(ca.DM(np.kron(np.eye(n), np.ones((1, DEGREE)))))
        along = ca.sparsify(ca.DM(step * np.kron(np.eye(n), points[None, 1:])))
        change = self._attitude_rate.map(n * DEGREE)(
            inner, angles[:, :n] @ every + rates @ along, rates @ every
        )
        equal, attitude = [ca.vec(angles[:, 1:] - angles[:, :n] - step * rates)], ca.DM([1.0, 0.0, 0.0, 0.0])
        for k in range(n):
            within = slice(k * DEGREE, (k + 1) * DEGREE)
            polynomial = ca.horzcat(starts[:, k], inner[:, within])
            # The polynomial begins where the one before ended, and has the equation's slope at the Gauss points.
            equal += [starts[:, k] - attitude, ca.vec(polynomial @ slopes - step * change[:, within])]
            attitude = polynomial @ ends
        # A servo speeds up from rest, and is at rest at the end.
        still = ca.MX.zeros(joints, 1)
        faster = ca.vec(ca.horzcat(rates, still) - ca.horzcat(still, rates))
        equalities, unknowns = ca.vertcat(*equal), (ca.vec(part) for part in (rates, angles, starts, inner))
        program = {"x": ca.vertcat(*unknowns), "f": attitude[0], "g": ca.vertcat(equalities, faster)}
        options = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "max_iter": MAX_ITERATIONS}}
        return ca.nlpsol("paths", "ipopt", program, options), self._bounds(equalities.numel())

    def _bounds(self, equalities: int) -> dict[str, FloatArray]:
        """Return the bounds of the unknowns and of the constraints, of which the first so many are equalities."""
        n, joints, limits = self._intervals, self._joints, self._limits
        low, high = (np.full((n + 1, joints), side) for side in limits.range_rad)
        # A closed loop from the start pose.
        low[[0, n]] = high[[0, n]] = 0.0
        free, fixed = np.full(4 * n * (1 + DEGREE), 1.5), np.zeros(equalities)
        fastest = np.full(joints * n, limits.rate_rad_s)
        # Without a limit a rate may turn to its opposite at once.
        most = min(limits.acceleration_rad_s2 * self._step_s, 3.0 * limits.rate_rad_s)
        quickest = np.full(joints * (n + 1), most)
        return {
            "lbx": np.concatenate([-fastest, low.ravel(), -free]),
            "ubx": np.concatenate([fastest, high.ravel(), free]),
            "lbg": np.concatenate([fixed, -quickest]),
            "ubg": np.concatenate([fixed, quickest]),
        }

    def _guess(self, rates: FloatArray) -> FloatArray:
        """Return the unknowns of a path with these joint rates (intervals, n)."""
        angles = np.vstack([np.zeros(self._joints), np.cumsum(rates * self._step_s, axis=0)])
        attitude, starts = np.array([1.0, 0.0, 0.0, 0.0]), []
        for angle, rate in zip(angles, rates, strict=False):
            starts.append(attitude)
            attitude = attitude + self._step_s * np.array(self._attitude_rate(attitude, angle, rate)).ravel()
            attitude /= np.linalg.norm(attitude)
        inner = np.repeat(starts, DEGREE, axis=0)
        return np.concatenate([rates.ravel(), angles.ravel(), np.ravel(starts), inner.ravel()])


def _rotation(axis: ca.DM, angle: Any) -> Any:
    # Rodrigues' formula.
    across = ca.skew(axis)
    return ca.DM.eye(3) + ca.sin(angle) * across + (1.0 - ca.cos(angle)) * (across @ across)


def _lagrange(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return slopes (m + 1, m) at all points but the first, and values (m + 1, 1) at 1, of Lagrange's polynomials."""
    slopes, ends = [], []
    for j, point in enumerate(points):
        others = np.delete(points, j)
        polynomial = np.poly1d(others, r=True) / np.prod(point - others)
        slopes.append(np.polyder(polynomial)(points[1:]))
        ends.append([polynomial(1.0)])
    return np.array(slopes), np.array(ends)
