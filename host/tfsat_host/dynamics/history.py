"""What the joints do over time: a piecewise polynomial for each, from strokes or from samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.interpolate import CubicSpline

from tfsat_host.dynamics.components import FloatArray
from tfsat_host.robot import RobotModel
from tfsat_host.robot.model import IntArray


@dataclass(frozen=True, slots=True)
class TimedMove:
    """One joint moves once, from rest to rest.

    Attributes:
        joint: Index of the joint.
        delta_rad: Change of its angle.
        start_s, end_s: When it starts and when it has arrived.
    """

    joint: int
    delta_rad: float
    start_s: float
    end_s: float


@dataclass(frozen=True, eq=False)
class JointHistory:
    """Joint angles over time; the rates may jump where two pieces meet.

    Attributes:
        breaks_s: (k + 1,) increasing.
        coefficients: (d, k, n - 1): the angle of a joint in piece i is the polynomial with
            `coefficients[:, i]`, highest power first, of the time since `breaks_s[i]`.
    """

    breaks_s: FloatArray
    coefficients: FloatArray

    def angles_rad(self, t_s: FloatArray) -> FloatArray:
        """Angles (..., n - 1) at times (...); before the first break and after the last the joints are held."""
        return self._evaluated(t_s, self.coefficients)

    def rates_rad_s(self, t_s: FloatArray) -> FloatArray:
        """Rates (..., n - 1) at times (...), at a break those of the piece that begins; zero outside."""
        t = np.asarray(t_s, dtype=np.float64)
        inside = (t >= self.breaks_s[0]) & (t <= self.breaks_s[-1])
        return np.where(inside[..., None], self._evaluated(t, derivative(self.coefficients)), 0.0)

    def in_piece(self, piece: IntArray, since_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angles and rates (..., n - 1), `since_s` (...) after the start of pieces (...)."""
        chosen = self.coefficients[:, piece]
        return _horner(chosen, since_s), _horner(derivative(chosen), since_s)

    def _evaluated(self, t_s: FloatArray, coefficients: FloatArray) -> FloatArray:
        t = np.clip(np.asarray(t_s, dtype=np.float64), self.breaks_s[0], self.breaks_s[-1])
        piece = np.clip(np.searchsorted(self.breaks_s, t, side="right") - 1, 0, len(self.breaks_s) - 2)
        return _horner(coefficients[:, piece], t - self.breaks_s[piece])


def derivative(coefficients: FloatArray) -> FloatArray:
    """Coefficients (d - 1, ...) of the derivative; a constant has (1, ...) zeros."""
    degree = len(coefficients) - 1
    if degree == 0:
        return np.zeros_like(coefficients)
    powers = np.arange(degree, 0, -1).reshape(-1, *(1,) * (coefficients.ndim - 1))
    return np.asarray(coefficients[:-1] * powers)


def sampled(
    t_s: FloatArray, angles_rad: FloatArray, *, between: Literal["cubic", "linear"] = "cubic"
) -> JointHistory:
    """The history through samples.

    Args:
        t_s: (m,) increasing sample times, m >= 2.
        angles_rad: (m, n - 1).
        between: A cubic spline (not-a-knot), or straight lines.

    Raises:
        ValueError: shapes do not fit, times do not increase, or a number is not finite.
    """
    t, angles = np.asarray(t_s, dtype=np.float64), np.asarray(angles_rad, dtype=np.float64)
    if t.ndim != 1 or angles.ndim != 2 or len(t) != len(angles) or len(t) < 2:
        raise ValueError(f"samples of shape {t.shape} and {angles.shape} are no history")
    if not (np.isfinite(t).all() and np.isfinite(angles).all() and (np.diff(t) > 0.0).all()):
        raise ValueError("sample times must increase, and all numbers must be finite")
    if between == "cubic":
        spline = CubicSpline(t, angles)
        return JointHistory(t, np.asarray(spline.c))
    slope = np.diff(angles, axis=0) / np.diff(t)[:, None]
    return JointHistory(t, np.stack([slope, angles[:-1]]))


def moved(
    robot: RobotModel,
    moves: Sequence[TimedMove],
    *,
    start_rad: FloatArray | None = None,
    end_s: float | None = None,
) -> JointHistory:
    """The history of moves: each speeds up, goes on and slows down, with the servo's acceleration.

    A move whose servo could not arrive in time at that acceleration takes the least that does arrive.

    Args:
        robot: Its servos' accelerations are used.
        moves: In any order; those of one joint must not overlap.
        start_rad: (n - 1,) angles at t = 0; zero if None.
        end_s: How long to hold the joints after the last move.

    Raises:
        ValueError: two moves of a joint overlap, or a move takes no time.
    """
    angles = np.zeros(robot.n_joints) if start_rad is None else np.array(start_rad, dtype=np.float64)
    ramps = [_ramps(robot, move) for move in sorted(moves, key=lambda m: m.start_s)]
    breaks = sorted({0.0, end_s or 0.0, *(t for times, _ in ramps for t in times)})
    if len(breaks) == 1:
        breaks.append(breaks[0] + 1.0)
    edges = np.array(breaks)
    pieces = np.zeros((3, len(edges) - 1, robot.n_joints))
    rates = np.zeros(robot.n_joints)
    acceleration = _accelerations(robot, moves, ramps, edges)
    for i, (length, push) in enumerate(zip(np.diff(edges), acceleration, strict=True)):
        pieces[:, i] = 0.5 * push, rates, angles
        angles = angles + length * (rates + 0.5 * length * push)
        rates = np.where(np.abs(rates + length * push) < 1e-9, 0.0, rates + length * push)
    return JointHistory(edges, pieces)


def _ramps(robot: RobotModel, move: TimedMove) -> tuple[tuple[float, float, float, float], float]:
    """Times at which the acceleration changes, and its size: speed up, go on, slow down."""
    duration, size = move.end_s - move.start_s, abs(move.delta_rad)
    if not duration > 0.0:
        raise ValueError(f"a move of joint {move.joint + 1} takes {duration} s")
    least = 4.0 * size / duration**2
    acceleration = max(robot.servos[move.joint].acceleration_rad_s2, least)
    ramp = 0.5 * duration * (1.0 - np.sqrt(max(0.0, 1.0 - least / acceleration)))
    times = (move.start_s, move.start_s + ramp, move.end_s - ramp, move.end_s)
    return times, float(np.sign(move.delta_rad)) * acceleration


def _accelerations(
    robot: RobotModel,
    moves: Sequence[TimedMove],
    ramps: Sequence[tuple[tuple[float, float, float, float], float]],
    edges: FloatArray,
) -> FloatArray:
    """(k, n - 1) accelerations between the edges."""
    middle = 0.5 * (edges[1:] + edges[:-1])
    acceleration = np.zeros((len(middle), robot.n_joints))
    busy = np.zeros((len(middle), robot.n_joints), dtype=bool)
    for move, (times, size) in zip(sorted(moves, key=lambda m: m.start_s), ramps, strict=True):
        during = (middle > times[0]) & (middle < times[3])
        if (busy[:, move.joint] & during).any():
            raise ValueError(f"two moves of joint {move.joint + 1} overlap")
        busy[during, move.joint] = True
        acceleration[during & (middle < times[1]), move.joint] = size
        acceleration[during & (middle > times[2]), move.joint] = -size
    return acceleration


def _horner(coefficients: FloatArray, since: FloatArray) -> FloatArray:
    value = coefficients[0]
    for coefficient in coefficients[1:]:
        value = value * np.asarray(since)[..., None] + coefficient
    return np.asarray(np.broadcast_to(value, np.shape(since) + np.shape(value)[-1:]))
