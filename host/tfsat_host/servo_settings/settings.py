"""Servo settings as the board holds them: whole microseconds, nanoseconds per degree, 0.01 deg."""

from __future__ import annotations

from dataclasses import dataclass

from tfsat_host.protocol.limits import (
    JOINT_ANGLE_MAX_CDEG,
    JOINT_ANGLE_MIN_CDEG,
    JOINT_COUNT,
    SERVO_FACTORY_NS_PER_DEG,
    SERVO_FACTORY_ZERO_US,
    SERVO_FRAME_US,
)
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.units import CDEG_PER_DEG

NS_PER_US = 1000


@dataclass(frozen=True, slots=True)
class ServoSettings:
    """The settings of all servos.

    Attributes:
        frame_us: From pulse to pulse.
        servos: Of joints 1 to 3, in order.
    """

    frame_us: int
    servos: tuple[ServoSetting, ...]

    def of(self, joint: int) -> ServoSetting:
        """The setting of a joint, 1 to 3."""
        return self.servos[joint - 1]


def pulse_ns(servo: ServoSetting, angle_cdeg: int) -> int:
    """Pulse width that holds an angle from 0 deg, as the board computes it: the fraction of a nanosecond is cut."""
    change_ns = angle_cdeg * servo.ns_per_deg // CDEG_PER_DEG
    return servo.zero_us * NS_PER_US + (-change_ns if servo.reversed else change_ns)


FACTORY = ServoSettings(
    SERVO_FRAME_US,
    (
        ServoSetting(
            SERVO_FACTORY_ZERO_US, SERVO_FACTORY_NS_PER_DEG, 0, JOINT_ANGLE_MIN_CDEG, JOINT_ANGLE_MAX_CDEG
        ),
    )
    * JOINT_COUNT,
)
"""What a board uses that never received settings."""
