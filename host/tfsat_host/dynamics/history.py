"""What the joints do over time: a piecewise polynomial for each, from strokes or from samples.

A servo speeds up, goes on and slows down, within its greatest rate and acceleration. A move says when the schedule
has the joint arrive. A servo that needs longer arrives later, as fast as it can; the next move of its joint then
waits until the joint is at rest. Other joints do not wait: the sequencer runs open loop.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from tfsat_host.arrays import FloatArray, IntArray
from tfsat_host.robot import RobotModel

# Instants closer together are one; no clock of the robot tells them apart.
SAME_INSTANT_S = 1e-9


@dataclass(frozen=True, slots=True)
class TimedMove:
    """One joint is to move once, from rest to rest.

    Attributes:
        joint: Index of the joint.
        delta_rad: Change of its angle.
        start_s, end_s: When it starts, and when it has arrived if its servo can.
    """

    joint: int
    delta_rad: float
    start_s: float
    end_s: float


def shortest_s(
    size_rad: FloatArray, max_rate_rad_s: FloatArray, acceleration_rad_s2: FloatArray
) -> FloatArray:
    """(...) time that servos need to turn joints from rest to rest."""
    rate, acceleration = max_rate_rad_s, acceleration_rad_s2
    # A stroke that reaches the greatest rate cruises between its ramps; a shorter one has ramps alone.
    cruising = size_rad * acceleration > rate * rate
    return np.where(cruising, size_rad / rate + rate / acceleration, 2.0 * np.sqrt(size_rad / acceleration))


class ServoMotion(NamedTuple):
    """What servos make of k moves; trailing axes are a batch of robots.

    Attributes:
        joints: k indices of joints.
        delta_rad: (k, ...) change of its angle.
        start_s, end_s: (k, ...) when it starts and has arrived.
        ramp_s: (k, ...) time to speed up, and to slow down.
        push_rad_s2: (k, ...) acceleration while it speeds up, with its sign.
    """

    joints: tuple[int, ...]
    delta_rad: FloatArray
    start_s: FloatArray
    end_s: FloatArray
    ramp_s: FloatArray
    push_rad_s2: FloatArray

    @classmethod
    def of(
        cls,
        joints: Sequence[int],
        delta_rad: FloatArray,
        start_s: FloatArray,
        duration_s: FloatArray,
        max_rate_rad_s: FloatArray,
        acceleration_rad_s2: FloatArray,
    ) -> ServoMotion:
        """Moves in the order of their starts, each (k, ...) by its own servo's greatest rate and acceleration.

        A move that starts while its own joint is still on the way starts when the joint has arrived, and none is
        shorter than its servo can.
        """
        size, acceleration = np.abs(delta_rad), acceleration_rad_s2
        shortest = shortest_s(size, max_rate_rad_s, acceleration)
        # No servo beats its own limits, and a move of no size takes an instant.
        duration = np.maximum(np.maximum(duration_s, shortest), SAME_INSTANT_S)
        # 1 where ramps fill the whole duration; the less, the shorter they are.
        fullness = np.minimum(1.0, 4.0 * size / (acceleration * duration * duration))
        start, end = np.broadcast_to(start_s, duration.shape).copy(), np.empty_like(duration)
        at_rest: dict[int, FloatArray] = {}
        # A joint still under way delays its own next move; the others run open loop.
        for k, joint in enumerate(joints):
            start[k] = np.maximum(start[k], at_rest.get(joint, start[k]))
            at_rest[joint] = end[k] = start[k] + duration[k]
        # The smaller root of a r (T - r) = size, without the cancellation of 1 - sqrt(1 - f).
        ramp = 0.5 * duration * fullness / (1.0 + np.sqrt(1.0 - fullness))
        return cls(tuple(joints), delta_rad, start, end, ramp, np.sign(delta_rad) * acceleration)

    @property
    def changes_s(self) -> FloatArray:
        """(4 k, ...) the instants at which an acceleration changes, move by move unordered."""
        edges = (self.start_s, self.start_s + self.ramp_s, self.end_s - self.ramp_s, self.end_s)
        return np.concatenate(edges)

    def polynomials(self, move: int, edges_s: FloatArray) -> FloatArray:
        """(3, m, ...) way of a move since its start in the pieces between edges (m + 1, ...).

        Polynomials of the time since a piece begins, highest power first. No acceleration changes within a piece.
        """
        start, end, ramp = self.start_s[move], self.end_s[move], self.ramp_s[move]
        delta, half = self.delta_rad[move], 0.5 * self.push_rad_s2[move]
        since, remaining_s = edges_s[:-1] - start, end - edges_s[:-1]
        # No piece straddles a change of acceleration: its middle tells the phase, without ties.
        middle = 0.5 * (edges_s[1:] + edges_s[:-1])
        # Before, speeding up, at constant rate, slowing down; whatever is later takes the default.
        phase = [middle < start, middle < start + ramp, middle <= end - ramp, middle < end]
        rate = 2.0 * half * ramp
        return np.stack(
            [
                np.select(phase, [0.0, half, 0.0, -half], 0.0),
                np.select(phase, [0.0, 2.0 * half * since, rate, 2.0 * half * remaining_s], 0.0),
                np.select(
                    phase,
                    [
                        0.0,
                        half * since * since,
                        rate * (since - 0.5 * ramp),
                        delta - half * remaining_s * remaining_s,
                    ],
                    delta,
                ),
            ]
        )


def servo_motion(robot: RobotModel, moves: Sequence[TimedMove]) -> ServoMotion:
    """Compute the motion of the robot's servos for `moves`, in the order of their starts.

    Raises:
        ValueError: a joint is not the robot's, a number is not finite, a move is to take no time, or the
            scheduled times of two moves of a joint overlap.
    """
    ordered = sorted(moves, key=lambda move: move.start_s)
    latest: dict[int, TimedMove] = {}
    for move in ordered:
        _check(move, robot.n_joints)
        # Only scheduled times must not overlap: a servo that arrives late delays what follows.
        if move.joint in latest and move.start_s < latest[move.joint].end_s - SAME_INSTANT_S:
            raise ValueError(f"two moves of joint {move.joint + 1} overlap")
        latest[move.joint] = move
    servos = [robot.servos[move.joint].dynamics(move.delta_rad) for move in ordered]
    # A measured servo goes as fast as it can; of another one the schedule's average rate is all that is known.
    durations = [
        move.end_s - move.start_s if servo.covariance is None else 0.0
        for move, servo in zip(ordered, servos, strict=True)
    ]
    return ServoMotion.of(
        [move.joint for move in ordered],
        np.array([move.delta_rad for move in ordered]),
        np.array([move.start_s + servo.delay_s for move, servo in zip(ordered, servos, strict=True)]),
        np.array(durations),
        np.array([servo.max_rate_rad_s for servo in servos]),
        np.array([servo.acceleration_rad_s2 for servo in servos]),
    )


def servo_moves(robot: RobotModel, moves: Sequence[TimedMove]) -> list[TimedMove]:
    """Compute the moves as the servos carry them out, with actual start and arrival times.

    The result is in the order of `moves`. A move that starts while its own joint is still moving starts
    when the joint has arrived.

    Raises:
        ValueError: as `servo_motion`.
    """
    motion = servo_motion(robot, moves)
    columns = (values.tolist() for values in (motion.delta_rad, motion.start_s, motion.end_s))
    carried = [TimedMove(*row) for row in zip(motion.joints, *columns, strict=True)]
    # Undo the sort by starts: results come in the caller's order.
    numbers = sorted(range(len(moves)), key=lambda number: moves[number].start_s)
    return [carried[numbers.index(number)] for number in range(len(moves))]


def overlap(moves: Sequence[TimedMove]) -> bool:
    """Return whether a move starts while another is under way.

    The path then cuts its corner.
    """
    ordered = sorted(moves, key=lambda move: move.start_s)
    ends = [move.end_s for move in ordered]
    return any(ordered[k].start_s < max(ends[:k]) - SAME_INSTANT_S for k in range(1, len(ordered)))


def _check(move: TimedMove, n_joints: int) -> None:
    if not 0 <= move.joint < n_joints:
        raise ValueError(f"there is no joint {move.joint}: the robot has {n_joints}, counted from 0")
    if not all(map(math.isfinite, (move.delta_rad, move.start_s, move.end_s))):
        raise ValueError(f"a move of joint {move.joint + 1} is not finite: {move}")
    if not move.end_s > move.start_s:
        raise ValueError(f"a move of joint {move.joint + 1} takes {move.end_s - move.start_s} s")


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
        """Return the history as a scipy piecewise polynomial; not for a batch."""
        return PPoly(self.coefficients, self.breaks_s)

    def in_piece(self, piece: IntArray, since_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angles and rates (n - 1, m, q, ...), times (m, q, ...) after the start of pieces (m,)."""
        # (d, n - 1, m, 1, ...): a joint's polynomial in each piece, to be broadcast over the times.
        chosen = np.moveaxis(self.coefficients[:, piece], 2, 1)[:, :, :, None]
        angles, rates = chosen[0], np.zeros_like(chosen[0])
        # Horner's scheme, for the derivative one line ahead.
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
    """Find each joint's greatest excursion beyond the values at the ends of an interval between breaks.

    Between two samples, a history through them should not lie far beyond them.
    """
    # A spline leaves its samples farthest where its rate is zero.
    breaks, turning = history.breaks_s, history.polynomial().derivative().roots(extrapolate=False)
    joint_overshoots = []
    for joint, roots in enumerate(turning):
        # An interval without motion has no single root: scipy says NaN.
        t_s = np.append(breaks[0], roots[np.isfinite(roots)])
        # Compare each turning point with the samples at both ends of its interval.
        piece = np.clip(np.searchsorted(breaks, t_s, side="right") - 1, 0, len(breaks) - 2)
        values, ends = history.angles_rad(t_s)[:, joint], history.angles_rad(breaks)[:, joint]
        low, high = np.sort([ends[piece], ends[piece + 1]], axis=0)
        excess = np.maximum(values - high, low - values)
        most = int(np.argmax(excess))
        joint_overshoots.append(Overshoot(joint, max(0.0, float(excess[most])), float(t_s[most])))
    return joint_overshoots


def history_from_samples(
    t_s: FloatArray, angles_rad: FloatArray, *, between: Literal["cubic", "linear"] = "cubic"
) -> JointHistory:
    """Interpolate samples to a joint history.

    Args:
        t_s: (m,) increasing sample times, m >= 2.
        angles_rad: (m, n - 1) joint angles.
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
    # Straight lines, and whatever a robot without joints needs: it has no spline.
    slope = np.diff(angles, axis=0) / np.diff(t)[:, None]
    return JointHistory(t, np.stack([slope, angles[:-1]]))


def history_from_moves(
    robot: RobotModel,
    moves: Sequence[TimedMove],
    *,
    start_rad: FloatArray | None = None,
    end_s: float | None = None,
) -> JointHistory:
    """Build the history of moves as the robot's servos carry them out (`servo_moves`).

    Moves may arrive later than scheduled.

    Args:
        robot: Its servos' greatest rates and accelerations are used.
        moves: Moves in any order; the scheduled times of those of one joint must not overlap.
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
    # A break wherever an acceleration changes: each piece is one polynomial.
    instants = np.sort(np.append(motion.changes_s, [0.0, end_s or 0.0]))
    # Nothing moves, and no end was given: one piece of a second at rest.
    if instants[0] == instants[-1]:
        instants[-1] += 1.0
    # Instants that no clock tells apart would make pieces without length.
    apart = np.append(np.diff(instants) > SAME_INSTANT_S, True)
    return history_of(motion, instants[apart], start)


def history_of(motion: ServoMotion, breaks_s: FloatArray, start_rad: FloatArray) -> JointHistory:
    """Build the history of moves from joint angles `start_rad`, (n - 1,) or (n - 1, ...).

    Accelerations must be constant between the breaks (m + 1, ...).
    """
    pieces = np.zeros((3, len(breaks_s) - 1, len(start_rad), *breaks_s.shape[1:]))
    pieces[2] = start_rad.reshape(*start_rad.shape, *(1,) * (breaks_s.ndim - start_rad.ndim))
    for number, joint in enumerate(motion.joints):
        pieces[:, :, joint] += motion.polynomials(number, breaks_s)
    return JointHistory(breaks_s, pieces)
