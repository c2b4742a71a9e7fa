"""What the servos are commanded to do.

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

from tfsat_host.robot import RobotModel
from tfsat_host.robot.model import FloatArray


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
