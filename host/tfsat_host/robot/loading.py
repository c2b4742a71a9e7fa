"""From a robot file to a `RobotModel`: units converted, every entry checked.

The file's format is explained by the comments of `robots/drop_tower.toml`.
"""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import numpy as np

from tfsat_host.robot.checks import check_inertia, check_tree, index_of, unique_names
from tfsat_host.robot.entries import Entry, unit_vector
from tfsat_host.robot.errors import RobotFileError
from tfsat_host.robot.model import AngleSensor, FloatArray, Imu, IntArray, RobotModel, Servo
from tfsat_host.robot.path import default_robot_path

_AXES = ("x", "y", "z")


def load_robot(path: Path | str | None = None) -> RobotModel:
    """Read and check a robot file; without a path the drop tower robot.

    Raises:
        RobotFileError: the file cannot be read, is not TOML or does not describe a robot. The message
            names file, line and entry, and how to correct it.
    """
    file = default_robot_path() if path is None else Path(path)
    text = _read_text(file)
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise RobotFileError(
            what=f"{file}: is not valid TOML: {error}.",
            meaning="The robot's masses and joints are unknown.",
            next_step="Correct that line; robots/drop_tower.toml shows the format.",
        ) from error
    return _robot(file, Entry(file, text, "", 0, values))


def _read_text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise RobotFileError(
            what=f"The robot file {file} cannot be read: {reason}.",
            meaning="The robot's masses and joints are unknown.",
            next_step="Name a robot file that exists, or name none to use the drop tower robot.",
        ) from error


def _robot(file: Path, top: Entry) -> RobotModel:
    top.integer("format", (1,))
    off_diagonals = top.text("inertia_off_diagonals")
    if off_diagonals not in ("products", "tensor"):
        top.fail("inertia_off_diagonals", f"{off_diagonals!r} is neither", 'Write "products" or "tensor".')
    bodies, joints = top.tables("body"), top.tables("joint")
    if not bodies:
        top.fail("body", "there is no body", "Describe each body below its own line `[[body]]`.")
    body_names = unique_names(bodies)
    joint_names = unique_names(joints)
    inner = np.array([index_of(j, "inner", body_names, "body") for j in joints], dtype=np.int64)
    outer = np.array([index_of(j, "outer", body_names, "body") for j in joints], dtype=np.int64)
    limits = [_limits_rad(j) for j in joints]
    robot = RobotModel(
        path=file,
        name=top.text("name"),
        base=index_of(top, "base", body_names, "body"),
        body_names=body_names,
        mass_kg=_frozen([b.positive("mass_kg") for b in bodies], (-1,)),
        origin_m=_frozen([b.vector("origin_mm") * 1e-3 for b in bodies], (-1, 3)),
        com_m=_frozen([b.vector("com_mm") * 1e-3 for b in bodies], (-1, 3)),
        inertia_kg_m2=_frozen([_inertia(b, off_diagonals == "products") for b in bodies], (-1, 3, 3)),
        joint_names=joint_names,
        joint_inner=_frozen_indices(inner),
        joint_outer=_frozen_indices(outer),
        joint_axis=_frozen([_axis(j) for j in joints], (-1, 3)),
        joint_point_m=_frozen([j.vector("point_mm") * 1e-3 for j in joints], (-1, 3)),
        joint_limits_rad=_frozen(limits, (-1, 2)),
        servos=tuple(_servo(j.table("servo"), pair) for j, pair in zip(joints, limits, strict=True)),
        imus=_imus(top.tables("imu"), body_names),
        angle_sensors=tuple(_angle_sensor(s, joint_names) for s in top.tables("angle_sensor")),
    )
    check_tree(top, joints, inner, outer, body_names)
    for entry in (top, *bodies, *joints):
        entry.done()
    return robot


def _frozen(values: object, shape: tuple[int, ...]) -> FloatArray:
    array = np.array(values, dtype=np.float64).reshape(shape)
    array.flags.writeable = False
    return array


def _frozen_indices(values: IntArray) -> IntArray:
    values.flags.writeable = False
    return values


def _inertia(body: Entry, negated: bool) -> FloatArray:
    entries = body.table("inertia_g_m2")
    tensor = np.zeros((3, 3))
    for i in range(3):
        for k in range(i, 3):
            value = entries.number(_AXES[i] + _AXES[k]) * 1e-3
            tensor[i, k] = tensor[k, i] = -value if negated and i != k else value
    entries.done()
    check_inertia(body, tensor)
    return tensor


def _axis(joint: Entry) -> FloatArray:
    axis = joint.vector("axis")
    if not np.linalg.norm(axis) > 0.0:
        joint.fail("axis", "has no direction", "Give the axis a direction, e.g. [1, 0, 0].")
    return unit_vector(axis)


def _limits_rad(joint: Entry) -> tuple[float, float]:
    low, high = joint.vector("limits_deg", 2)
    if not low < high:
        joint.fail("limits_deg", f"{low:g} is not below {high:g}", "Write the smaller angle first.")
    return math.radians(low), math.radians(high)


def _servo(entry: Entry, limits_rad: tuple[float, float]) -> Servo:
    low_us, high_us = entry.vector("pulse_range_us", 2)
    if not 0.0 < low_us < high_us:
        entry.fail("pulse_range_us", "is not a range above zero", "Write the shorter pulse first, in us.")
    slope = entry.number("pulse_us_per_deg")
    if slope == 0.0:
        entry.fail(
            "pulse_us_per_deg", "is zero", "Give the change of pulse width per degree; the sign is free."
        )
    reference = entry.table("reference")
    servo = Servo(
        average_rate_rad_s=math.radians(entry.positive("average_rate_deg_s")),
        max_rate_rad_s=math.radians(entry.positive("max_rate_deg_s")),
        acceleration_rad_s2=math.radians(entry.positive("acceleration_deg_s2")),
        start_rad=math.radians(entry.number("start_deg")),
        pulse_range_us=(float(low_us), float(high_us)),
        reference_pulse_us=reference.positive("pulse_us"),
        reference_angle_rad=math.radians(reference.number("angle_deg")),
        pulse_us_per_rad=math.degrees(slope),
    )
    reference.done()
    entry.done()
    _check_servo(entry, servo, limits_rad)
    return servo


def _check_servo(entry: Entry, servo: Servo, limits_rad: tuple[float, float]) -> None:
    low, high = limits_rad
    if servo.average_rate_rad_s > servo.max_rate_rad_s:
        entry.fail("average_rate_deg_s", "is above max_rate_deg_s", "Give an average of at most the maximum.")
    if not low <= servo.start_rad <= high:
        entry.fail("start_deg", "is outside the joint's limits", "Choose a start pose inside limits_deg.")
    for angle in limits_rad:
        pulse = servo.pulse_us(angle)
        if not servo.pulse_range_us[0] - 1e-6 <= pulse <= servo.pulse_range_us[1] + 1e-6:
            entry.fail(
                "pulse_range_us",
                f"the joint's limit {math.degrees(angle):g} deg would take a pulse of {pulse:.1f} us",
                "Correct reference, pulse_us_per_deg or the joint's limits_deg.",
            )


def _imus(entries: list[Entry], body_names: tuple[str, ...]) -> tuple[Imu, ...]:
    imus: list[Imu] = []
    for entry in entries:
        imu = _imu(entry, body_names)
        if any((other.bus, other.address) == (imu.bus, imu.address) for other in imus):
            entry.fail(
                "address", "two sensors would answer on this bus", "Give each its own bus and address."
            )
        imus.append(imu)
    return tuple(imus)


def _imu(entry: Entry, body_names: tuple[str, ...]) -> Imu:
    rotation = entry.matrix("sensor_to_body")
    if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6) or not np.linalg.det(rotation) > 0.0:
        entry.fail("sensor_to_body", "is not a rotation", "Give a right-handed orthonormal matrix.")
    imu = Imu(
        body=index_of(entry, "body", body_names, "body"),
        bus=entry.integer("bus", (0, 1)),
        address=entry.integer("address", (0x68, 0x69)),
        position_m=_frozen(entry.vector("position_mm") * 1e-3, (3,)),
        sensor_to_body=_frozen(rotation, (3, 3)),
        gyro_range_rad_s=math.radians(entry.positive("gyro_range_deg_s")),
        low_pass_hz=entry.positive("low_pass_hz"),
    )
    entry.done()
    return imu


def _angle_sensor(entry: Entry, joint_names: tuple[str, ...]) -> AngleSensor:
    sensor = AngleSensor(
        joint=index_of(entry, "joint", joint_names, "joint"),
        direction=entry.integer("direction", (-1, 1)),
        zero_offset_rad=math.radians(entry.number("zero_offset_deg")),
    )
    entry.done()
    return sensor
