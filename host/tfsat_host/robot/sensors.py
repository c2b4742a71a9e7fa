"""The sensors' entries: where they sit and which way they look."""

from __future__ import annotations

import math

import numpy as np

from tfsat_host.config import Table
from tfsat_host.robot.model import AngleSensor, FloatArray, Imu, frozen

_IMU = "body bus address position_mm sensor_to_body gyro_range_deg_s low_pass_hz"
_ANGLE_SENSOR = "joint direction zero_offset_deg nonlinearity_deg"
_ROUNDING = 1e-6


def imus(top: Table, body_names: tuple[str, ...]) -> tuple[Imu, ...]:
    """All `[[imu]]`. Raises RobotFileError where an entry is wrong or two have the same address."""
    found: list[Imu] = []
    for entry in top.tables("imu", _IMU):
        imu = _imu(entry, body_names)
        if any((other.bus, other.address) == (imu.bus, imu.address) for other in found):
            entry.fail(
                "address", "two sensors would answer on this bus", "Give each its own bus and address."
            )
        found.append(imu)
    return tuple(found)


def _imu(entry: Table, body_names: tuple[str, ...]) -> Imu:
    rotation = entry.array("sensor_to_body", 3, 3)
    if not _is_rotation(rotation):
        entry.fail("sensor_to_body", "is not a rotation", "Give a right-handed orthonormal matrix.")
    return Imu(
        body=body_names.index(entry.choice("body", body_names)),
        bus=entry.integer("bus", 0, 1),
        address=entry.integer("address", 0x68, 0x69),
        position_m=frozen(entry.array("position_mm", 3) * 1e-3, 3),
        sensor_to_body=frozen(rotation, 3, 3),
        gyro_range_rad_s=math.radians(entry.number("gyro_range_deg_s", above=0)),
        low_pass_hz=entry.number("low_pass_hz", above=0),
    )


def _is_rotation(matrix: FloatArray) -> bool:
    if np.abs(matrix).max() > 1.0 + _ROUNDING:  # first: products of huge numbers leave the range of floats
        return False
    orthonormal = np.allclose(matrix @ matrix.T, np.eye(3), atol=_ROUNDING)
    return orthonormal and bool(np.linalg.det(matrix) > 0.0)


def angle_sensors(top: Table, joint_names: tuple[str, ...]) -> tuple[AngleSensor, ...]:
    """All `[[angle_sensor]]`. Raises RobotFileError where an entry is wrong."""
    return tuple(
        AngleSensor(
            joint=joint_names.index(entry.choice("joint", joint_names)),
            direction=entry.choice("direction", (-1, 1)),
            zero_offset_rad=math.radians(entry.number("zero_offset_deg")),
            nonlinearity_rad=math.radians(entry.number("nonlinearity_deg", above=0))
            if entry.has("nonlinearity_deg")
            else AngleSensor.nonlinearity_rad,
        )
        for entry in top.tables("angle_sensor", _ANGLE_SENSOR)
    )
