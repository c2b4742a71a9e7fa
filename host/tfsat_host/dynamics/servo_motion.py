"""How a servo carries out a move: it speeds up, goes on and slows down, within its greatest rate and acceleration.

A move says when the schedule has the joint arrive. A servo that needs longer arrives later, as fast as it can; the
next move of its joint then waits until the joint is at rest. Other joints do not wait: the sequencer runs open loop.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tfsat_host.robot import RobotModel
from tfsat_host.robot.model import FloatArray

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


class ServoMove(NamedTuple):
    """What the servo makes of a move.

    Attributes:
        joint: Index of the joint.
        delta_rad: Change of its angle.
        start_s, end_s: When it starts and has arrived.
        ramp_s: Time to speed up, and to slow down.
        push_rad_s2: Acceleration while it speeds up, with its sign.
    """

    joint: int
    delta_rad: float
    start_s: float
    end_s: float
    ramp_s: float
    push_rad_s2: float


class ServoMotion(NamedTuple):
    """What servos make of k moves; trailing axes are a batch of robots.

    Attributes:
        joints: k indices of joints.
        delta_rad, start_s, end_s, ramp_s, push_rad_s2: (k, ...) as in `ServoMove`.
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
        size, rate, acceleration = np.abs(delta_rad), max_rate_rad_s, acceleration_rad_s2
        cruising = size * acceleration > rate * rate
        shortest = np.where(cruising, size / rate + rate / acceleration, 2.0 * np.sqrt(size / acceleration))
        duration = np.maximum(np.maximum(duration_s, shortest), SAME_INSTANT_S)
        fullness = np.minimum(1.0, 4.0 * size / (acceleration * duration * duration))
        start, end = np.broadcast_to(start_s, duration.shape).copy(), np.empty_like(duration)
        at_rest: dict[int, FloatArray] = {}
        for k, joint in enumerate(joints):
            start[k] = np.maximum(start[k], at_rest.get(joint, start[k]))
            at_rest[joint] = end[k] = start[k] + duration[k]
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
        since, left = edges_s[:-1] - start, end - edges_s[:-1]
        middle = 0.5 * (edges_s[1:] + edges_s[:-1])
        phase = [middle < start, middle < start + ramp, middle <= end - ramp, middle < end]
        rate = 2.0 * half * ramp
        return np.stack(
            [
                np.select(phase, [0.0, half, 0.0, -half], 0.0),
                np.select(phase, [0.0, 2.0 * half * since, rate, 2.0 * half * left], 0.0),
                np.select(
                    phase,
                    [0.0, half * since * since, rate * (since - 0.5 * ramp), delta - half * left * left],
                    delta,
                ),
            ]
        )


def servo_motion(robot: RobotModel, moves: Sequence[TimedMove]) -> ServoMotion:
    """What the robot's servos make of `moves`, in the order of their starts.

    Raises:
        ValueError: a joint is not the robot's, a number is not finite, a move is to take no time, or the
            scheduled times of two moves of a joint overlap.
    """
    ordered = sorted(moves, key=lambda move: move.start_s)
    latest: dict[int, TimedMove] = {}
    for move in ordered:
        _check(move, robot.n_joints)
        if move.joint in latest and move.start_s < latest[move.joint].end_s - SAME_INSTANT_S:
            raise ValueError(f"two moves of joint {move.joint + 1} overlap")
        latest[move.joint] = move
    servos = [robot.servos[move.joint] for move in ordered]
    return ServoMotion.of(
        [move.joint for move in ordered],
        np.array([move.delta_rad for move in ordered]),
        np.array([move.start_s for move in ordered]),
        np.array([move.end_s - move.start_s for move in ordered]),
        np.array([servo.max_rate_rad_s for servo in servos]),
        np.array([servo.acceleration_rad_s2 for servo in servos]),
    )


def servo_moves(robot: RobotModel, moves: Sequence[TimedMove]) -> list[ServoMove]:
    """What the robot's servos make of `moves`, in the order of `moves`.

    A move that starts while its own joint is still on the way starts when the joint has arrived.

    Raises:
        ValueError: a joint is not the robot's, a number is not finite, a move is to take no time, or the
            scheduled times of two moves of a joint overlap.
    """
    motion = servo_motion(robot, moves)
    columns = zip(*(values.tolist() for values in motion[1:]), strict=True)
    in_order = [ServoMove(joint, *row) for joint, row in zip(motion.joints, columns, strict=True)]
    numbers = sorted(range(len(moves)), key=lambda number: moves[number].start_s)
    return [one for _, one in sorted(zip(numbers, in_order, strict=True))]


def overlap(moves: Sequence[ServoMove]) -> bool:
    """Whether one of the moves starts while another is under way: then the path cuts its corner."""
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
