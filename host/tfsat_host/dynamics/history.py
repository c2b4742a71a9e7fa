"""What the joints do over time: a piecewise polynomial for each, from strokes or from samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.interpolate import CubicSpline

from tfsat_host.dynamics.components import FloatArray
from tfsat_host.dynamics.servo_motion import SAME_INSTANT_S, ServoMove, TimedMove, servo_moves
from tfsat_host.robot import RobotModel
from tfsat_host.robot.model import IntArray


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
    if between == "cubic" and angles.shape[1] > 0:
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
    """The history of moves as the robot's servos carry them out (`servo_moves`): some may arrive later.

    Args:
        robot: Its servos' greatest rates and accelerations are used.
        moves: In any order; the scheduled times of those of one joint must not overlap.
        start_rad: (n - 1,) angles before the first move; zero if None.
        end_s: How long to hold the joints after the last move.

    Returns:
        A history from the release, t = 0, or from the first move if that is earlier, until `end_s` or until the
        last joint has arrived if that is later.

    Raises:
        ValueError: as `servo_moves`, or `start_rad` does not fit.
    """
    start = np.zeros(robot.n_joints) if start_rad is None else np.asarray(start_rad, dtype=np.float64)
    if start.shape != (robot.n_joints,):
        raise ValueError(f"start angles of shape {start.shape} do not fit {robot.n_joints} joints")
    carried = servo_moves(robot, moves)
    edges = _edges(carried, end_s)
    pieces = np.zeros((3, len(edges) - 1, robot.n_joints))
    pieces[2] = start
    middle = 0.5 * (edges[1:] + edges[:-1])
    for move in carried:
        pieces[2, middle >= move.end_s, move.joint] += move.delta_rad
        for i in np.flatnonzero((middle > move.start_s) & (middle < move.end_s)):
            pieces[:, i, move.joint] += move.polynomial(edges[i], middle[i])
    return JointHistory(edges, pieces)


def _edges(moves: Sequence[ServoMove], end_s: float | None) -> FloatArray:
    """The instants at which an acceleration changes, and the ends of the history."""
    changes = [(m.start_s, m.start_s + m.ramp_s, m.end_s - m.ramp_s, m.end_s) for m in moves]
    instants = sorted({0.0, end_s or 0.0, *(t for times in changes for t in times)})
    if len(instants) == 1:
        instants.append(instants[0] + 1.0)
    apart = [t for t, later in pairwise(instants) if later - t > SAME_INSTANT_S]
    return np.array([*apart, instants[-1]])


def _horner(coefficients: FloatArray, since: FloatArray) -> FloatArray:
    value = coefficients[0]
    for coefficient in coefficients[1:]:
        value = value * np.asarray(since)[..., None] + coefficient
    return np.asarray(np.broadcast_to(value, np.shape(since) + np.shape(value)[-1:]))
