"""What the servos are told, and what a batch of imperfect robots makes of it.

The maneuver runs open loop: a stroke starts at its time, whatever the joints have done so far. A joint goes at its
servo's average rate, with the servo's acceleration at both ends, to the angle at which its servo believes that
the stroke is done. A slow servo may still move while the next joint starts: then the path through the
joint angles, and with it the rotation, is another one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tfsat_host.dynamics.components import FloatArray
from tfsat_host.robot import RobotModel

_INSTANT_S = 1e-9  # the shortest stroke; one of no angle takes no time


class PlannedStroke(NamedTuple):
    """One joint is told to move once.

    Attributes:
        joint: Index of the joint.
        delta_rad: Change of its angle.
        start_s: After release.
    """

    joint: int
    delta_rad: float
    start_s: float


@dataclass(frozen=True, eq=False)
class Plan:
    """A maneuver as the servos are told it.

    Attributes:
        start_rad: (n - 1,) joint angles at the release: the start pose of the robot's servos.
        joints: (k,) index of the joint of each stroke.
        target_rad: (k,) angle at which the joint of each stroke is told to end.
        start_s: (k,) start of each stroke after release, in order.
        rate_rad_s: Average joint rate of a stroke.
        max_rate_rad_s: (n - 1,) greatest rate of each joint's servo.
        acceleration_rad_s2: (n - 1,) of each joint's servo.
        until_s: When the attitude is looked at; later for a robot whose joints still move.
    """

    start_rad: FloatArray
    joints: tuple[int, ...]
    target_rad: FloatArray
    start_s: FloatArray
    rate_rad_s: float
    max_rate_rad_s: FloatArray
    acceleration_rad_s2: FloatArray
    until_s: float

    @classmethod
    def of(
        cls, robot: RobotModel, strokes: Sequence[PlannedStroke], rate_rad_s: float, *, until_s: float = 0.0
    ) -> Plan:
        """The plan of `strokes`, in order of their starts.

        Args:
            robot: Its servos' start pose, greatest rates and accelerations are used.
            strokes: At least one.
            rate_rad_s: Average joint rate of a stroke.
            until_s: When the attitude is looked at, if the joints have come to rest by then. It matters
                for a robot with angular momentum only.

        Raises:
            ValueError: there is no stroke, a joint is not the robot's, starts decrease, or the rate
                is not positive.
        """
        starts = np.array([stroke.start_s for stroke in strokes])
        if not len(strokes) or not rate_rad_s > 0.0:
            raise ValueError("a plan has strokes and a rate above zero")
        if any(not 0 <= stroke.joint < robot.n_joints for stroke in strokes):
            raise ValueError(f"the robot has joints 0 to {robot.n_joints - 1}")
        if starts[0] < 0.0 or (np.diff(starts) < 0.0).any():
            raise ValueError("strokes start after release and in order")
        start = np.array([servo.start_rad for servo in robot.servos])
        angles, targets = start.copy(), []
        for stroke in strokes:
            angles[stroke.joint] += stroke.delta_rad
            targets.append(angles[stroke.joint])
        return cls(
            start_rad=start,
            joints=tuple(stroke.joint for stroke in strokes),
            target_rad=np.array(targets),
            start_s=starts,
            rate_rad_s=rate_rad_s,
            max_rate_rad_s=np.array([servo.max_rate_rad_s for servo in robot.servos]),
            acceleration_rad_s2=np.array([servo.acceleration_rad_s2 for servo in robot.servos]),
            until_s=until_s,
        )

    @property
    def moved_joints(self) -> tuple[int, ...]:
        """The joints that the maneuver moves, in order of their index."""
        return tuple(sorted(set(self.joints)))


class Moves(NamedTuple):
    """What the joints of s robots do: each of k strokes speeds up, goes on and slows down.

    Attributes:
        start_rad: (n - 1,) joint angles at the release.
        joints: (k,) index of the joint of each stroke.
        start_s, end_s: (k, s).
        ramp_s: (k, s) time to speed up, and to slow down.
        push_rad_s2: (k, s) acceleration while speeding up, with its sign.
        until_s: When the attitude is looked at, or later, as in `Plan`.
    """

    start_rad: FloatArray
    joints: tuple[int, ...]
    start_s: FloatArray
    end_s: FloatArray
    ramp_s: FloatArray
    push_rad_s2: FloatArray
    until_s: float

    @classmethod
    def of(cls, plan: Plan, reached_rad: FloatArray, rates_rad_s: FloatArray) -> Moves:
        """The strokes of s robots.

        A stroke that starts while its own joint is not yet there begins when the joint has arrived. A rate that a
        servo cannot reach is left to its greatest, which errs with its average, as `tfsat_host.dynamics` has it.

        Args:
            plan: What their servos are told.
            reached_rad: (k, s) angle at which each stroke ends.
            rates_rad_s: (n - 1, s) average rate of each servo.
        """
        angle = np.repeat(plan.start_rad[:, None], reached_rad.shape[1], axis=1)
        free = np.zeros_like(angle)
        start, end, ramp, push = (np.empty_like(reached_rad) for _ in range(4))
        for k, joint in enumerate(plan.joints):
            delta = reached_rad[k] - angle[joint]
            size = np.abs(delta)
            slowness = plan.rate_rad_s / rates_rad_s[joint]
            shortest = _shortest_s(
                size, plan.max_rate_rad_s[joint] / slowness, plan.acceleration_rad_s2[joint]
            )
            duration = np.maximum(np.maximum(size / rates_rad_s[joint], shortest), _INSTANT_S)
            start[k] = np.maximum(plan.start_s[k], free[joint])
            end[k] = start[k] + duration
            least = 4.0 * size / duration**2
            acceleration = np.maximum(plan.acceleration_rad_s2[joint], least)
            ramp[k] = 0.5 * duration * (1.0 - np.sqrt(np.maximum(0.0, 1.0 - least / acceleration)))
            push[k] = np.sign(delta) * acceleration
            angle[joint], free[joint] = reached_rad[k], end[k]
        return cls(plan.start_rad, plan.joints, start, end, ramp, push, plan.until_s)

    @property
    def last_end_s(self) -> FloatArray:
        """(s,) when the last joint has arrived."""
        return np.asarray(self.end_s.max(axis=0))

    @property
    def moving_time_s(self) -> FloatArray:
        """(s,) what the strokes take together."""
        return np.asarray((self.end_s - self.start_s).sum(axis=0))

    def breaks_s(self) -> FloatArray:
        """(4 k + 2, s) increasing: release, the instants at which an acceleration changes, and the end."""
        release, end = np.zeros_like(self.start_s[:1]), np.maximum(self.last_end_s, self.until_s)[None]
        edges = [self.start_s, self.start_s + self.ramp_s, self.end_s - self.ramp_s, self.end_s]
        return np.sort(np.concatenate([release, *edges, end]), axis=0)

    def at(self, t_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Joint angles and rates (n - 1, ..., s) at times (..., s)."""
        rates = np.zeros((len(self.start_rad), *t_s.shape))
        angles = rates + self.start_rad.reshape(-1, *(1,) * t_s.ndim)
        for k, joint in enumerate(self.joints):
            duration, ramp, push = self.end_s[k] - self.start_s[k], self.ramp_s[k], self.push_rad_s2[k]
            since = np.clip(t_s - self.start_s[k], 0.0, duration)
            level, slowing = np.maximum(since - ramp, 0.0), np.maximum(since - (duration - ramp), 0.0)
            angles[joint] += 0.5 * push * (since**2 - level**2 - slowing**2)
            rates[joint] += push * (since - level - slowing)
        return angles, rates


def _shortest_s(size_rad: FloatArray, rate_rad_s: FloatArray, acceleration_rad_s2: float) -> FloatArray:
    """(s,) least times from rest to rest; without a cruise where the greatest rate is not reached."""
    ramps_s = 2.0 * np.sqrt(size_rad / acceleration_rad_s2)
    cruise_s = size_rad / rate_rad_s + rate_rad_s / acceleration_rad_s2
    return np.where(size_rad * acceleration_rad_s2 <= rate_rad_s**2, ramps_s, cruise_s)
