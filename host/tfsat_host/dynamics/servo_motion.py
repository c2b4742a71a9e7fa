"""How a servo carries out a move: it speeds up, goes on and slows down, within its greatest rate and acceleration.

A move says when the schedule has the joint arrive. A servo that needs longer arrives later, as fast as it can; the
next move of its joint then waits until the joint is at rest, as in `tfsat_host.sensitivity`. Other joints
do not wait: the sequencer runs open loop.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from tfsat_host.robot import RobotModel
from tfsat_host.robot.model import Servo

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

    def polynomial(self, from_s: float, middle_s: float) -> tuple[float, float, float]:
        """Way since the start around `middle_s`, as a polynomial of the time since `from_s`, highest power first."""
        half, since = 0.5 * self.push_rad_s2, from_s - self.start_s
        if middle_s < self.start_s + self.ramp_s:
            return half, self.push_rad_s2 * since, half * since * since
        if middle_s > self.end_s - self.ramp_s:
            left = self.end_s - from_s
            return -half, self.push_rad_s2 * left, self.delta_rad - half * left * left
        rate = self.push_rad_s2 * self.ramp_s
        return 0.0, rate, rate * (since - 0.5 * self.ramp_s)


def servo_moves(robot: RobotModel, moves: Sequence[TimedMove]) -> list[ServoMove]:
    """What the robot's servos make of `moves`, in the order of `moves`.

    A move that starts while its own joint is still on the way starts when the joint has arrived.

    Raises:
        ValueError: a joint is not the robot's, a number is not finite, a move is to take no time, or the
            scheduled times of two moves of a joint overlap.
    """
    done: list[ServoMove | None] = [None] * len(moves)
    latest: dict[int, tuple[TimedMove, ServoMove]] = {}
    for number in sorted(range(len(moves)), key=lambda k: moves[k].start_s):
        move = moves[number]
        _check(move, robot.n_joints)
        start_s = move.start_s
        if move.joint in latest:
            planned, made = latest[move.joint]
            if move.start_s < planned.end_s - SAME_INSTANT_S:
                raise ValueError(f"two moves of joint {move.joint + 1} overlap")
            start_s = max(start_s, made.end_s)
        one = _carried_out(robot.servos[move.joint], move, start_s)
        latest[move.joint], done[number] = (move, one), one
    return [one for one in done if one is not None]


def shortest_s(servo: Servo, delta_rad: float) -> float:
    """Least time in which the servo moves its joint by `delta_rad`, from rest to rest."""
    size, acceleration, rate = abs(delta_rad), servo.acceleration_rad_s2, servo.max_rate_rad_s
    if size * acceleration <= rate * rate:
        return 2.0 * math.sqrt(size / acceleration)
    return size / rate + rate / acceleration


def overlap(moves: Sequence[ServoMove]) -> bool:
    """Whether one of the moves starts while another is under way: then the path cuts its corner."""
    ordered = sorted(moves, key=lambda move: move.start_s)
    ends = [move.end_s for move in ordered]
    return any(ordered[k].start_s < max(ends[:k]) - SAME_INSTANT_S for k in range(1, len(ordered)))


def _carried_out(servo: Servo, move: TimedMove, start_s: float) -> ServoMove:
    duration = max(move.end_s - move.start_s, shortest_s(servo, move.delta_rad))
    acceleration = servo.acceleration_rad_s2
    fullness = min(1.0, 4.0 * abs(move.delta_rad) / (acceleration * duration * duration))
    ramp = 0.5 * duration * fullness / (1.0 + math.sqrt(1.0 - fullness))
    push = math.copysign(acceleration, move.delta_rad) if move.delta_rad else 0.0
    return ServoMove(move.joint, move.delta_rad, start_s, start_s + duration, ramp, push)


def _check(move: TimedMove, n_joints: int) -> None:
    if not 0 <= move.joint < n_joints:
        raise ValueError(f"there is no joint {move.joint}: the robot has {n_joints}, counted from 0")
    if not all(map(math.isfinite, (move.delta_rad, move.start_s, move.end_s))):
        raise ValueError(f"a move of joint {move.joint + 1} is not finite: {move}")
    if not move.end_s > move.start_s:
        raise ValueError(f"a move of joint {move.joint + 1} takes {move.end_s - move.start_s} s")
