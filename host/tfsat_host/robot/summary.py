"""A robot in numbers that people read: what `tfsat-host robot` shows and prints as JSON.

Millimetres, degrees and g m^2, unlike the model itself; units stand in the keys.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tfsat_host.robot.model import AngleSensor, FloatArray, Imu, PulseMap, RobotModel, Servo, Uncertainty
from tfsat_host.robot.totals import totals

Json = dict[str, Any]

# Decimal figures of a file come back as they were typed after the way to SI units and back.
_DECIMALS = 9


def summary(robot: RobotModel) -> Json:
    """Bodies, joints, sensors, uncertainty, and the whole robot at zero joint angles.

    Inertias are tensors about the center of mass: off-diagonal entries are minus the products of inertia.
    """
    whole = totals(robot)
    return {
        "name": robot.name,
        "file": str(robot.path),
        "source": robot.source,
        "base": robot.body_names[robot.base],
        "mass_kg": _rounded(whole.mass_kg),
        "com_mm": _thousandths(whole.com_m),
        **_inertia(whole.inertia_kg_m2),
        "bodies": [_body(robot, i) for i in range(robot.n_bodies)],
        "joints": [_joint(robot, j) for j in range(robot.n_joints)],
        "imus": [_imu(robot, imu) for imu in robot.imus],
        "angle_sensors": [_angle_sensor(robot, sensor) for sensor in robot.angle_sensors],
        "uncertainty": None if robot.uncertainty is None else _uncertainty(robot.uncertainty),
    }


def _body(robot: RobotModel, i: int) -> Json:
    return {
        "name": robot.body_names[i],
        "mass_kg": _rounded(robot.mass_kg[i]),
        "origin_mm": _thousandths(robot.origin_m[i]),
        "com_mm": _thousandths(robot.com_m[i]),
        **_inertia(robot.inertia_kg_m2[i]),
        "corners_mm": _thousandths(robot.shape_m[i]),
    }


def _inertia(tensor: FloatArray) -> Json:
    return {
        "inertia_g_m2": _thousandths(tensor),
        "principal_moments_g_m2": _thousandths(np.linalg.eigvalsh(tensor)),
    }


def _joint(robot: RobotModel, j: int) -> Json:
    return {
        "name": robot.joint_names[j],
        "inner": robot.body_names[robot.joint_inner[j]],
        "outer": robot.body_names[robot.joint_outer[j]],
        "axis": _rounded(robot.joint_axis[j]),
        "point_mm": _thousandths(robot.joint_point_m[j]),
        "limits_deg": _degrees(robot.joint_limits_rad[j]),
        "servo": _servo(robot.servos[j]),
    }


def _servo(servo: Servo) -> Json:
    return {
        "average_rate_deg_s": _degrees(servo.average_rate_rad_s),
        "max_rate_deg_s": _degrees(servo.max_rate_rad_s),
        "acceleration_deg_s2": _degrees(servo.acceleration_rad_s2),
        "start_deg": _degrees(servo.start_rad),
        "pulses": None if servo.pulses is None else _pulses(servo.pulses),
    }


def _pulses(pulses: PulseMap) -> Json:
    return {
        "range_us": list(pulses.range_us),
        "reference_pulse_us": pulses.reference_pulse_us,
        "reference_angle_deg": _degrees(pulses.reference_angle_rad),
        "pulse_us_per_deg": _rounded(np.radians(pulses.pulse_us_per_rad)),
    }


def _imu(robot: RobotModel, imu: Imu) -> Json:
    return {
        "body": robot.body_names[imu.body],
        "bus": imu.bus,
        "address": imu.address,
        "position_mm": _thousandths(imu.position_m),
        "sensor_to_body": _rounded(imu.sensor_to_body),
        "gyro_range_deg_s": _degrees(imu.gyro_range_rad_s),
        "low_pass_hz": imu.low_pass_hz,
    }


def _angle_sensor(robot: RobotModel, sensor: AngleSensor) -> Json:
    return {
        "joint": robot.joint_names[sensor.joint],
        "direction": sensor.direction,
        "zero_offset_deg": _degrees(sensor.zero_offset_rad),
    }


def _uncertainty(wrong: Uncertainty) -> Json:
    """The table as the file writes it."""
    shown: Json = {}
    for name, value in asdict(wrong).items():
        if name.endswith("_rad"):
            shown[name.removesuffix("_rad") + "_deg"] = _degrees(value)
        elif name.endswith("_m"):
            shown[name.removesuffix("_m") + "_mm"] = _thousandths(value)
        else:
            shown[name] = value
    return shown


def _rounded(values: ArrayLike) -> Any:
    """A number, or nested lists of them; no minus before a zero."""
    return (np.round(np.asarray(values), _DECIMALS) + 0.0).tolist()


def _thousandths(values: ArrayLike) -> Any:
    """Of metres millimetres, of kg m^2 g m^2."""
    return _rounded(1e3 * np.asarray(values))


def _degrees(values: ArrayLike) -> Any:
    return _rounded(np.degrees(values))
