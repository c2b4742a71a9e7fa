"""The sensors' entries: where they sit and which way they look."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tfsat_host.robot.arrays import frozen
from tfsat_host.robot.checks import index_of
from tfsat_host.robot.entries import Entry
from tfsat_host.robot.model import AngleSensor, FloatArray, Imu

_ROUNDING = 1e-6


def imus(entries: list[Entry], body_names: tuple[str, ...]) -> tuple[Imu, ...]:
    """All IMUs. Raises RobotFileError where an entry is wrong or two have the same address."""
    found: list[Imu] = []
    for entry in entries:
        imu = _imu(entry, body_names)
        if any((other.bus, other.address) == (imu.bus, imu.address) for other in found):
            entry.fail(
                "address", "two sensors would answer on this bus", "Give each its own bus and address."
            )
        found.append(imu)
    return tuple(found)


def _imu(entry: Entry, body_names: tuple[str, ...]) -> Imu:
    rotation = entry.matrix("sensor_to_body")
    if not _is_rotation(rotation):
        entry.fail("sensor_to_body", "is not a rotation", "Give a right-handed orthonormal matrix.")
    imu = Imu(
        body=index_of(entry, "body", body_names, "body"),
        bus=entry.integer("bus", (0, 1)),
        address=entry.integer("address", (0x68, 0x69)),
        position_m=frozen(entry.vector("position_mm") * 1e-3, (3,)),
        sensor_to_body=frozen(rotation, (3, 3)),
        gyro_range_rad_s=math.radians(entry.positive("gyro_range_deg_s")),
        low_pass_hz=entry.positive("low_pass_hz"),
    )
    entry.done()
    return imu


def _is_rotation(matrix: FloatArray) -> bool:
    if np.abs(matrix).max() > 1.0 + _ROUNDING:  # first: products of huge numbers leave the range of floats
        return False
    orthonormal = np.allclose(matrix @ matrix.T, np.eye(3), atol=_ROUNDING)
    return orthonormal and bool(np.linalg.det(matrix) > 0.0)


def angle_sensor(entry: Entry, joint_names: tuple[str, ...]) -> AngleSensor:
    """One angle sensor. Raises RobotFileError where an entry is wrong."""
    sensor = AngleSensor(
        joint=index_of(entry, "joint", joint_names, "joint"),
        direction=entry.integer("direction", (-1, 1)),
        zero_offset_rad=math.radians(entry.number("zero_offset_deg")),
    )
    if entry.has("nonlinearity_deg"):
        sensor = replace(sensor, nonlinearity_rad=math.radians(entry.positive("nonlinearity_deg")))
    entry.done()
    return sensor
