"""What the joints do over time: a piecewise polynomial for each, from strokes or from samples."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from tfsat_host.dynamics.servo_motion import SAME_INSTANT_S, ServoMotion, TimedMove, servo_motion
from tfsat_host.robot import RobotModel
from tfsat_host.robot.model import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class JointHistory:
    """Joint angles over time; the rates may jump where two pieces meet.

    Attributes:
        breaks_s: (k + 1,) increasing.
        coefficients: (d, k, n - 1): the angle of a joint in piece i is the polynomial with
            `coefficients[:, i]`, highest power first, of the time since `breaks_s[i]`.

    A batch of robots has one more axis at the end of both, and may have pieces of no length.
    """

    breaks_s: FloatArray
    coefficients: FloatArray

    def angles_rad(self, t_s: FloatArray) -> FloatArray:
        """Angles (..., n - 1) at times (...); before the first break and after the last the joints are held."""
        return np.asarray(self.polynomial()(np.clip(t_s, self.breaks_s[0], self.breaks_s[-1])))

    def rates_rad_s(self, t_s: FloatArray) -> FloatArray:
        """Rates (..., n - 1) at times (...), at a break those of the piece that begins; zero outside."""
        t = np.asarray(t_s, dtype=np.float64)
        inside = (t >= self.breaks_s[0]) & (t <= self.breaks_s[-1])
        return np.where(inside[..., None], self.polynomial().derivative()(t), 0.0)

    def polynomial(self) -> PPoly:
        """As scipy has it; not of a batch."""
        return PPoly(self.coefficients, self.breaks_s)

    def in_piece(self, piece: IntArray, since_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angles and rates (n - 1, m, q, ...), times (m, q, ...) after the start of pieces (m,)."""
        chosen = np.moveaxis(self.coefficients[:, piece], 2, 1)[:, :, :, None]
        angles, rates = chosen[0], np.zeros_like(chosen[0])
        for coefficient in chosen[1:]:
            rates = rates * since_s + angles
            angles = angles * since_s + coefficient
        shape = (chosen.shape[1], *np.shape(since_s))
        return np.broadcast_to(angles, shape), np.broadcast_to(rates, shape)


class Overshoot(NamedTuple):
    """How far a joint leaves the samples on both sides at most, and when.

    Attributes:
        joint: Index of the joint.
        excess_rad: Beyond the nearer of the two samples; 0 where it stays between them.
        t_s: When.
    """

    joint: int
    excess_rad: float
    t_s: float


def overshoots(history: JointHistory) -> list[Overshoot]:
    """The greatest excursion of each joint between two breaks: what lies between samples should not lie far beyond.

    Args:
        history: Through samples.
    """
    breaks, turning = history.breaks_s, history.polynomial().derivative().roots(extrapolate=False)
    found = []
    for joint, roots in enumerate(turning):
        # An interval without motion has no single root: scipy says NaN.
        t_s = np.append(breaks[0], roots[np.isfinite(roots)])
        piece = np.clip(np.searchsorted(breaks, t_s, side="right") - 1, 0, len(breaks) - 2)
        values, ends = history.angles_rad(t_s)[:, joint], history.angles_rad(breaks)[:, joint]
        low, high = np.sort([ends[piece], ends[piece + 1]], axis=0)
        excess = np.maximum(values - high, low - values)
        most = int(np.argmax(excess))
        found.append(Overshoot(joint, max(0.0, float(excess[most])), float(t_s[most])))
    return found


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
    motion = servo_motion(robot, moves)
    instants = np.sort(np.append(motion.changes_s, [0.0, end_s or 0.0]))
    if instants[0] == instants[-1]:
        instants[-1] += 1.0
    apart = np.append(np.diff(instants) > SAME_INSTANT_S, True)
    return history_of(motion, instants[apart], start)


def history_of(motion: ServoMotion, breaks_s: FloatArray, start_rad: FloatArray) -> JointHistory:
    """The history of moves from angles `start_rad` (n - 1,); no acceleration changes between breaks (m + 1, ...)."""
    pieces = np.zeros((3, len(breaks_s) - 1, len(start_rad), *breaks_s.shape[1:]))
    pieces[2] = start_rad.reshape(-1, *(1,) * (breaks_s.ndim - 1))
    for number, joint in enumerate(motion.joints):
        pieces[:, :, joint] += motion.polynomials(number, breaks_s)
    return JointHistory(breaks_s, pieces)
