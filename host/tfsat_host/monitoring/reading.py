"""One live sample in degrees and degrees per second."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT, IMU_COUNT
from tfsat_host.protocol.messages import LiveReply, LiveSampleStream
from tfsat_host.robot import AngleSensor

_ANGLE_BIT, _CLIPPED_BIT = IMU_COUNT, 12
"""First bits of the angle sensors and of the clipped IMUs in a sample's flags."""
_TURN_DEG = 360.0


@dataclass(frozen=True, slots=True)
class BodyRate:
    """What a body's gyro says.

    Attributes:
        rate_deg_s: About x, y, z of the sensor, as read: bias and mounting are not corrected.
        valid: The IMU answered.
        clipped: Its range was exceeded.
    """

    rate_deg_s: tuple[float, ...]
    valid: bool
    clipped: bool


@dataclass(frozen=True, slots=True)
class JointReading:
    """What an absolute angle sensor says.

    Attributes:
        joint: 1 to 3.
        sensor_deg: As read, 0 to 360.
        joint_deg: The joint's angle by the robot file's zero, -180 to 180.
        valid: The sensor answered.
    """

    joint: int
    sensor_deg: float
    joint_deg: float
    valid: bool


@dataclass(frozen=True, slots=True)
class Reading:
    """One sample: bodies 1 to 4, angle sensors in the order of the log."""

    bodies: tuple[BodyRate, ...]
    angles: tuple[JointReading, ...]


def convert(sample: LiveSampleStream, scales: LiveReply, sensors: Sequence[AngleSensor]) -> Reading:
    """In units for people.

    Args:
        sample: As it came.
        scales: As the logger named them when live sampling was switched on.
        sensors: Joint, direction and zero of the angle sensors, from the robot file.
    """
    flags = sample.sample.flags
    bodies = tuple(
        BodyRate(
            tuple(count / scales.gyro_lsb_per_deg_s for count in imu.gyro),
            valid=bool(flags >> body & 1),
            clipped=bool(flags >> (_CLIPPED_BIT + body) & 1),
        )
        for body, imu in enumerate(sample.sample.imu)
    )
    angles = tuple(
        _joint_reading(
            (sample.sample.angle[index] + 0.5) * _TURN_DEG / scales.angle_counts_per_turn,
            sensors[index],
            valid=bool(flags >> (_ANGLE_BIT + index) & 1),
        )
        for index in range(ANGLE_SENSOR_COUNT)
    )
    return Reading(bodies, angles)


def _joint_reading(sensor_deg: float, sensor: AngleSensor, *, valid: bool) -> JointReading:
    turned_deg = sensor.direction * (sensor_deg - math.degrees(sensor.zero_offset_rad))
    return JointReading(sensor.joint + 1, sensor_deg, math.remainder(turned_deg, _TURN_DEG), valid)
