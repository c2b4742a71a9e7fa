"""Whether a maneuver stays within the joints' limits of the settings; ARM refuses one that does not."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from tfsat_host.servo_settings.rules import limits_text
from tfsat_host.servo_settings.settings import ServoSettings
from tfsat_host.units import CDEG_PER_DEG


@dataclass(frozen=True, slots=True)
class Misfit:
    """The first stroke that leaves its joint's limits.

    Attributes:
        stroke: Its number, from 1.
        joint: 1 to 3.
        words: What it would do and what is allowed; no full stop.
    """

    stroke: int
    joint: int
    words: str


def find_misfit(moves: Iterable[tuple[int, int]], settings: ServoSettings) -> Misfit | None:
    """Follows each joint from the start pose, 0 deg; None if all stay within the limits.

    Args:
        moves: (joint, angle_cdeg) of each stroke, in order.
        settings: Whose limits.
    """
    pose_cdeg = dict.fromkeys(range(1, len(settings.servos) + 1), 0)
    for number, (joint, angle_cdeg) in enumerate(moves, 1):
        pose_cdeg[joint] += angle_cdeg
        servo = settings.of(joint)
        if not servo.min_cdeg <= pose_cdeg[joint] <= servo.max_cdeg:
            reached = f"stroke {number} takes joint {joint} to {pose_cdeg[joint] / CDEG_PER_DEG:g} deg"
            allowed = f"its servo settings allow {limits_text(servo)} deg"
            return Misfit(number, joint, f"{reached}, but {allowed}")
    return None
