"""A robot in numbers that people read: what `tfsat-host robot` prints as JSON, and as tables.

Millimetres, degrees and g m^2, unlike the model itself; units are in the keys.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tfsat_host.arrays import FloatArray
from tfsat_host.quantity import Column, Columns, Table, vector
from tfsat_host.robot.model import PulseMap, RobotModel

Json = dict[str, Any]

# Decimal figures of a file come back as they were typed after the way to SI units and back.
_DECIMALS = 9
_INERTIA_CONVENTION = (
    "Inertias are tensors about the center of mass, in body axes, all parallel to the global ones at zero angles; "
    "off-diagonal entries are minus the products of inertia."
)
_BODIES: Columns = (
    Column("name", "body"),
    Column("mass_kg", "kg", form="g"),
    Column("origin_mm", "origin", form=".5g"),
    Column("com_mm", "CoM in body", form=".5g"),
    Column("corners_mm", "shape in body", words=lambda body: _extent(body["corners_mm"])),
)
_ENTRIES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
_INERTIAS: Columns = (
    Column("name", "g m^2"),
    *(Column(entry, entry, form=".5g") for entry in _ENTRIES),
    Column("principal_moments_g_m2", "principal moments", form=".5g"),
)
_JOINTS: Columns = (
    Column("name", "joint"),
    Column("outer", "its angle turns", words=lambda joint: f"{joint['outer']} relative to {joint['inner']}"),
    Column("axis", "about +", form=".5g"),
    Column("point_mm", "through", form=".5g"),
    Column("limits_deg", "limits", words=lambda joint: _range(joint["limits_deg"])),
)
_SERVOS: Columns = (
    Column("name", "joint"),
    Column("average_rate_deg_s", "average", form="g"),
    Column("max_rate_deg_s", "max", form="g"),
    Column("acceleration_deg_s2", "deg/s^2", form="g"),
    Column("start_deg", "start", form="g"),
    Column("pulses", "pulses", words=lambda servo: _pulses_words(servo["pulses"])),
)
_IMUS: Columns = (
    Column("body", "on"),
    Column("address", "bus, address", words=lambda imu: f"{imu['bus']}, 0x{imu['address']:02x}"),
    Column("position_mm", "at", form=".5g"),
    Column(
        "sensor_to_body",
        "rows of sensor to body",
        words=lambda imu: ", ".join(vector(row, form=".5g") for row in imu["sensor_to_body"]),
    ),
    Column("gyro_range_deg_s", "range", form="g"),
    Column("low_pass_hz", "low-pass", form="g"),
)
_ANGLE_SENSORS: Columns = (
    Column("joint", "joint"),
    Column("direction", "direction", words=lambda sensor: f"{sensor['direction']:+d}"),
    Column("zero_offset_deg", "shows at zero", form="g"),
)
_UNCERTAINTY: Columns = (Column("key", "one sigma of"), Column("value", "figure", form="g"))


def totals(robot: RobotModel) -> tuple[float, FloatArray, FloatArray]:
    """Compute the robot's total mass (kg), CoM (3,) (m) and inertia (3, 3) (kg m^2) at zero joint angles.

    The inertia is about the CoM, by the parallel axis theorem. Global axes.
    """
    com = robot.origin_m + robot.com_m
    mass = float(robot.mass_kg.sum())
    center = robot.mass_kg @ com / mass
    arm = com - center
    # Steiner's terms per mass, |r|^2 1 - r r^T: (n, 3, 3).
    squared = np.einsum("ni,ni->n", arm, arm)[:, None, None] * np.eye(3) - arm[:, :, None] * arm[:, None, :]
    return mass, center, (robot.inertia_kg_m2 + robot.mass_kg[:, None, None] * squared).sum(axis=0)


def summary(robot: RobotModel) -> Json:
    """Bodies, joints, sensors, uncertainty, and the whole robot at zero joint angles.

    Inertias are tensors about the center of mass: off-diagonal entries are minus the products of inertia.
    """
    mass, com, inertia = totals(robot)
    return {
        "name": robot.name,
        "file": str(robot.path),
        "source": robot.source,
        "base": robot.body_names[robot.base],
        "mass_kg": _round_values(mass),
        "com_mm": _thousandths(com),
        **_inertia(inertia),
        "bodies": [
            {
                "name": name,
                "mass_kg": _round_values(robot.mass_kg[i]),
                "origin_mm": _thousandths(robot.origin_m[i]),
                "com_mm": _thousandths(robot.com_m[i]),
                **_inertia(robot.inertia_kg_m2[i]),
                "corners_mm": _thousandths(robot.shape_m[i]),
            }
            for i, name in enumerate(robot.body_names)
        ],
        "joints": [_joint(robot, j) for j in range(robot.n_joints)],
        "imus": [
            {
                "body": robot.body_names[imu.body],
                "bus": imu.bus,
                "address": imu.address,
                "position_mm": _thousandths(imu.position_m),
                "sensor_to_body": _round_values(imu.sensor_to_body),
                "gyro_range_deg_s": _degrees(imu.gyro_range_rad_s),
                "low_pass_hz": imu.low_pass_hz,
            }
            for imu in robot.imus
        ],
        "angle_sensors": [
            {
                "joint": robot.joint_names[sensor.joint],
                "direction": sensor.direction,
                "zero_offset_deg": _degrees(sensor.zero_offset_rad),
            }
            for sensor in robot.angle_sensors
        ],
        "uncertainty": None if robot.uncertainty is None else robot.uncertainty.figures(),
    }


def _inertia(tensor: FloatArray) -> Json:
    return {
        "inertia_g_m2": _thousandths(tensor),
        "principal_moments_g_m2": _thousandths(np.linalg.eigvalsh(tensor)),
    }


def _joint(robot: RobotModel, j: int) -> Json:
    servo = robot.servos[j]
    return {
        "name": robot.joint_names[j],
        "inner": robot.body_names[robot.joint_inner[j]],
        "outer": robot.body_names[robot.joint_outer[j]],
        "axis": _round_values(robot.joint_axis[j]),
        "point_mm": _thousandths(robot.joint_point_m[j]),
        "limits_deg": _degrees(robot.joint_limits_rad[j]),
        "servo": {
            "average_rate_deg_s": _degrees(servo.average_rate_rad_s),
            "max_rate_deg_s": _degrees(servo.max_rate_rad_s),
            "acceleration_deg_s2": _degrees(servo.acceleration_rad_s2),
            "start_deg": _degrees(servo.start_rad),
            "pulses": None if servo.pulses is None else _pulses(servo.pulses),
        },
    }


def _pulses(pulses: PulseMap) -> Json:
    return {
        "range_us": list(pulses.range_us),
        "reference_pulse_us": pulses.reference_pulse_us,
        "reference_angle_deg": _degrees(pulses.reference_angle_rad),
        # Per radian to per degree is the factor of degrees to radians.
        "pulse_us_per_deg": _round_values(np.radians(pulses.pulse_us_per_rad)),
    }


def lines(facts: Json) -> Iterator[str | Table]:
    """Yield the report for people from a `summary`, without parts that the robot does not have."""
    yield f"Robot    {facts['name']}"
    yield f"File     {facts['file']}"
    yield f"Figures  {facts['source'] or 'the file does not say where they come from'}"
    yield f"Base     {facts['base']}: its attitude is the robot's attitude"
    yield f"Mass     {facts['mass_kg']:.6g} kg"
    yield f"CoM      {vector(facts['com_mm'], form='.5g')} mm, global, at zero joint angles"
    yield Table("Bodies", _BODIES, facts["bodies"])
    # The whole robot is one more row among the tensors.
    robot_facts = {**facts, "name": "all, joints at zero"}
    tensors = [
        {**body_facts, **{entry: body_facts["inertia_g_m2"][i][k] for entry, (i, k) in _ENTRIES.items()}}
        for body_facts in (*facts["bodies"], robot_facts)
    ]
    yield Table("Inertia tensors", _INERTIAS, tensors, _INERTIA_CONVENTION)
    yield Table("Joints", _JOINTS, facts["joints"])
    yield Table("Servos", _SERVOS, [{**joint, **joint["servo"]} for joint in facts["joints"]])
    yield Table("IMUs", _IMUS, facts["imus"])
    yield Table("Angle sensors", _ANGLE_SENSORS, facts["angle_sensors"])
    uncertain = (facts["uncertainty"] or {}).items()
    yield Table("Uncertainty", _UNCERTAINTY, [{"key": key, "value": value} for key, value in uncertain])


def _pulses_words(pulses: Json | None) -> str:
    if pulses is None:
        return "none"
    return (
        f"{pulses['reference_pulse_us']:g} us at {pulses['reference_angle_deg']:g} deg, "
        f"{pulses['pulse_us_per_deg']:.6g} us/deg, {_range(pulses['range_us'])} us"
    )


def _range(values: list[float]) -> str:
    return f"{values[0]:g} to {values[1]:g}"


def _extent(corners: list[list[float]]) -> str:
    if not corners:
        return "not stated"
    return f"{vector(np.min(corners, axis=0), form='.5g')} to {vector(np.max(corners, axis=0), form='.5g')}"


def _round_values(values: ArrayLike) -> Any:
    """Round a number, or nested lists of numbers, without negative zeros."""
    return (np.round(np.asarray(values), _DECIMALS) + 0.0).tolist()


def _thousandths(values: ArrayLike) -> Any:
    """Convert metres to millimetres, or kg m^2 to g m^2, rounded."""
    return _round_values(1e3 * np.asarray(values))


def _degrees(values: ArrayLike) -> Any:
    return _round_values(np.degrees(values))
