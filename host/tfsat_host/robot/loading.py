"""From a robot file to a `RobotModel`: units converted, every entry checked.

The file's format is explained in `docs/robot-files.md`.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.config import Table, parse_config, read_config
from tfsat_host.robot.model import (
    MAX_RELATIVE,
    UNCERTAIN,
    AngleSensor,
    Imu,
    PulseMap,
    RobotModel,
    Servo,
    Uncertainty,
    frozen,
    frozen_indices,
)
from tfsat_host.robot.path import ROBOT_FILE, find_robot
from tfsat_host.robot.plausibility import check_imu_places, check_sizes, check_tree

_BODY = "name mass_kg origin_mm com_mm inertia_g_m2 boxes_mm"
_ENTRIES = ("xx", "xy", "xz", "yy", "yz", "zz")
# Printed inertias are rounded; a rod's or a plate's sits on the limit of the triangle inequality.
_TRIANGLE_TOLERANCE = 1e-6


def _inertia_kg_m2(body: Table, *, negated: bool) -> FloatArray:
    """Read the body's inertia tensor (3, 3) about its center of mass.

    `negated`: the file gives products of inertia.

    Raises:
        RobotFileError: it is incomplete, or impossible for a rigid body: not positive definite, or against the
            triangle inequality.
    """
    entries = body.table("inertia_g_m2", " ".join(_ENTRIES))
    upper = np.zeros((3, 3))
    # The keys are in row order of the upper triangle.
    upper[np.triu_indices(3)] = [entries.number(key) * 1e-3 for key in _ENTRIES]
    # A product of inertia is the tensor's entry with the opposite sign.
    diagonal, products = np.diag(np.diag(upper)), np.triu(upper, 1) * (-1.0 if negated else 1.0)
    tensor = diagonal + products + products.T
    # Ascending principal moments; conditions on them hold in any axes.
    principal = np.linalg.eigvalsh(tensor)
    moments_text = ", ".join(f"{1e3 * p:.4g}" for p in principal)
    if not principal[0] > 0.0:
        body.fail(
            "inertia_g_m2",
            f"is not positive definite (principal moments {moments_text} g m^2)",
            "Check the diagonal, and the sign and size of the off-diagonal entries.",
        )
    if principal[0] + principal[1] < principal[2] * (1.0 - _TRIANGLE_TOLERANCE):
        body.fail(
            "inertia_g_m2",
            f"no mass distribution has the principal moments {moments_text} g m^2: the largest exceeds the sum of "
            "the others",
            "Check the units and the columns; the moments must be about the center of mass.",
        )
    return tensor


def _shape_m(body: Table) -> FloatArray:
    """Read all corners of the body's boxes, (k, 3) in the body frame; (0, 3) if the file states no box.

    Raises:
        RobotFileError: a box has no volume, or the center of mass lies outside of the boxes' common extent.
    """
    if not body.has("boxes_mm"):
        return frozen([], 0, 3)
    expected_format = (
        "boxes, each as its lowest and highest corner: [[[xmin, ymin, zmin], [xmax, ymax, zmax]]]"
    )
    boxes = body.array("boxes_mm", -1, 2, 3, requirement=expected_format)
    if not (boxes[:, 0] < boxes[:, 1]).all():
        body.fail("boxes_mm", "a box has no volume", "Write each box's lowest corner first.")
    # A center of mass lies inside of what holds the mass: otherwise two frames were mixed up.
    com_mm = body.array("com_mm", 3)
    if (com_mm < boxes.min(axis=(0, 1))).any() or (com_mm > boxes.max(axis=(0, 1))).any():
        body.fail(
            "boxes_mm",
            "the center of mass lies outside of the boxes",
            "Give boxes_mm and com_mm in the same frame, the body's, and boxes that hold the whole body.",
        )
    corners = [corner for low, high in boxes for corner in product(*zip(low, high, strict=True))]
    return frozen(np.array(corners) * 1e-3, -1, 3)


_JOINT = "name inner outer axis point_mm limits_deg servo"
_SERVO = "average_rate_deg_s max_rate_deg_s acceleration_deg_s2 start_deg delay_ms"
_PULSE_KEYS = ("pulse_range_us", "reference", "pulse_us_per_deg")
# Below it, components that matter would be subnormal: too few of their digits remain.
_MIN_AXIS_NORM = sys.float_info.min / sys.float_info.epsilon


def _axis(joint: Table) -> FloatArray:
    """Read the joint's axis (3,) as a unit vector. Raises RobotFileError if it has no direction."""
    direction = joint.array("axis", 3)
    largest = np.abs(direction).max()
    cure = "Give the axis a direction, e.g. [1, 0, 0]."
    if largest == 0.0:
        joint.fail("axis", "has no direction", cure)
    if largest < _MIN_AXIS_NORM:
        joint.fail("axis", f"{largest:g} is so small that the direction is lost in rounding", cure)
    # By a power of two, which rounds nothing; squares of the numbers as given could leave the range of floats.
    scaled = np.ldexp(direction, -np.frexp(largest)[1])
    return np.asarray(scaled / np.linalg.norm(scaled), dtype=np.float64)


def _limits_rad(joint: Table) -> tuple[float, float]:
    """Read the least and greatest joint angle, rad. Raises RobotFileError if they are not a range."""
    low, high = joint.numbers("limits_deg", 2)
    if not low < high:
        joint.fail("limits_deg", f"{low:g} is not below {high:g}", "Write the smaller angle first.")
    return math.radians(low), math.radians(high)


def _servo(joint: Table, limits: tuple[float, float]) -> Servo:
    """Read the servo of a joint with these limits (rad).

    Raises:
        RobotFileError: it contradicts itself or the limits.
    """
    entry = joint.table("servo", " ".join((_SERVO, *_PULSE_KEYS)))
    servo = Servo(
        average_rate_rad_s=math.radians(entry.number("average_rate_deg_s", above=0)),
        max_rate_rad_s=math.radians(entry.number("max_rate_deg_s", above=0)),
        acceleration_rad_s2=math.radians(entry.number("acceleration_deg_s2", above=0)),
        start_rad=math.radians(entry.number("start_deg")),
        pulses=_pulses(entry),
        delay_s=1e-3 * entry.number("delay_ms", 0.0, least=0.0),
    )
    low, high = limits
    if servo.average_rate_rad_s > servo.max_rate_rad_s:
        entry.fail("average_rate_deg_s", "is above max_rate_deg_s", "Give an average of at most the maximum.")
    if not low <= servo.start_rad <= high:
        entry.fail("start_deg", "is outside the joint's limits", "Choose a start pose inside limits_deg.")
    if servo.pulses is not None:
        _check_reach(entry, servo.pulses, limits)
    return servo


def _pulses(entry: Table) -> PulseMap | None:
    missing = [key for key in _PULSE_KEYS if not entry.has(key)]
    # No pulses at all is a study without boards; some of them are a mistake.
    if len(missing) == len(_PULSE_KEYS):
        return None
    if missing:
        cure = f"Add {' and '.join(missing)}, or leave out all three: {', '.join(_PULSE_KEYS)}."
        entry.fail(missing[0], "is missing, though other keys of the pulses are there", cure)
    low_us, high_us = entry.numbers("pulse_range_us", 2)
    if not 0.0 < low_us < high_us:
        entry.fail("pulse_range_us", "is not a range above zero", "Write the shorter pulse first, in us.")
    slope = entry.number("pulse_us_per_deg")
    if slope == 0.0:
        entry.fail(
            "pulse_us_per_deg", "is zero", "Give the change of pulse width per degree; the sign is free."
        )
    reference = entry.table("reference", "pulse_us angle_deg")
    return PulseMap(
        range_us=(low_us, high_us),
        reference_pulse_us=reference.number("pulse_us", above=0),
        reference_angle_rad=math.radians(reference.number("angle_deg")),
        pulse_us_per_rad=math.degrees(slope),
    )


def _check_reach(entry: Table, pulses: PulseMap, limits: tuple[float, float]) -> None:
    # Pulses are linear in the angle: the ends of the range bound them all.
    for angle in limits:
        pulse = pulses.pulse_us(angle)
        if not pulses.range_us[0] - 1e-6 <= pulse <= pulses.range_us[1] + 1e-6:
            entry.fail(
                "pulse_range_us",
                f"the joint's limit {math.degrees(angle):g} deg would take a pulse of {pulse:.1f} us",
                "Correct reference, pulse_us_per_deg or the joint's limits_deg.",
            )


_IMU = "body bus address position_mm sensor_to_body gyro_range_deg_s low_pass_hz"
_ANGLE_SENSOR = "joint direction zero_offset_deg nonlinearity_deg"
_ROUNDING = 1e-6


def _imus(top: Table, body_names: tuple[str, ...]) -> tuple[Imu, ...]:
    """Read all `[[imu]]`. Raises RobotFileError if an entry is wrong or two have the same address."""
    imus: list[Imu] = []
    for entry in top.tables("imu", _IMU):
        imu = _imu(entry, body_names)
        if any((other.bus, other.address) == (imu.bus, imu.address) for other in imus):
            entry.fail(
                "address", "two sensors would answer on this bus", "Give each its own bus and address."
            )
        imus.append(imu)
    return tuple(imus)


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
    # Orthonormal with a positive determinant; a mirrored frame has a negative one.
    orthonormal = np.allclose(matrix @ matrix.T, np.eye(3), atol=_ROUNDING)
    return orthonormal and bool(np.linalg.det(matrix) > 0.0)


def _angle_sensors(top: Table, joint_names: tuple[str, ...]) -> tuple[AngleSensor, ...]:
    """Read all `[[angle_sensor]]`. Raises RobotFileError if an entry is wrong."""
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


def _unique_names(entries: Sequence[Table]) -> tuple[str, ...]:
    """Read the `name` of every entry.

    Raises:
        RobotFileError: two have the same.
    """
    names: list[str] = []
    for entry in entries:
        name = entry.text("name")
        if name in names:
            entry.fail("name", f"{name!r} is used twice", "Give each its own name.")
        names.append(name)
    return tuple(names)


_ROBOT = "format name source base inertia_off_diagonals uncertainty body joint imu angle_sensor"


def load_robot(name_or_path: Path | str | None = None) -> RobotModel:
    """Read and check a robot file, named as `find_robot` takes it; None is the drop tower robot.

    Raises:
        RobotFileError: the file cannot be read, is not TOML or does not describe a robot. The message
            names file, line and entry, and how to correct it.
    """
    file = find_robot(name_or_path)
    return _robot(file, read_config(file, ROBOT_FILE))


def parse_robot(text: str, path: Path) -> RobotModel:
    """Parse a robot from the text of a robot file at `path`, which need not exist.

    Raises:
        RobotFileError: the text is not a valid robot file.
    """
    return _robot(path, parse_config(text, str(path), ROBOT_FILE))


def _robot(file: Path, top: Table) -> RobotModel:
    top.only(_ROBOT)
    body, joint = top.tables("body", _BODY), top.tables("joint", _JOINT)
    if not body:
        top.fail("body", "there is no body", "Describe each body below its own line `[[body]]`.")
    negated = top.choice("inertia_off_diagonals", ("products", "tensor")) == "products"
    body_names = _unique_names(body)
    joint_names = _unique_names(joint)
    inner = frozen_indices([body_names.index(j.choice("inner", body_names)) for j in joint])
    outer = frozen_indices([body_names.index(j.choice("outer", body_names)) for j in joint])
    limits = [_limits_rad(j) for j in joint]
    robot = RobotModel(
        path=file,
        name=top.text("name"),
        source=top.text("source", ""),
        base=body_names.index(top.choice("base", body_names)),
        body_names=body_names,
        mass_kg=frozen([b.number("mass_kg", above=0) for b in body], -1),
        origin_m=frozen([b.array("origin_mm", 3) * 1e-3 for b in body], -1, 3),
        com_m=frozen([b.array("com_mm", 3) * 1e-3 for b in body], -1, 3),
        inertia_kg_m2=frozen([_inertia_kg_m2(b, negated=negated) for b in body], -1, 3, 3),
        shape_m=tuple(_shape_m(b) for b in body),
        joint_names=joint_names,
        joint_inner=inner,
        joint_outer=outer,
        joint_axis=frozen([_axis(j) for j in joint], -1, 3),
        joint_point_m=frozen([j.array("point_mm", 3) * 1e-3 for j in joint], -1, 3),
        joint_limits_rad=frozen(limits, -1, 2),
        servos=tuple(_servo(j, pair) for j, pair in zip(joint, limits, strict=True)),
        imus=_imus(top, body_names),
        angle_sensors=_angle_sensors(top, joint_names),
        uncertainty=_uncertainty(top),
    )
    # Every entry is sound by now; these checks look at all of them together.
    check_tree(body, joint, inner, outer, body_names)
    check_sizes(body, robot)
    check_imu_places(top.tables("imu", _IMU), robot)
    return robot


def _uncertainty(top: Table) -> Uncertainty | None:
    """Read the values of `[uncertainty]`, 0 for one left out; None without the table."""
    if not top.has("uncertainty"):
        return None
    table = top.table("uncertainty", " ".join(UNCERTAIN))
    most = {key: MAX_RELATIVE for key in UNCERTAIN if key.endswith("_relative")}
    return Uncertainty.of(
        {key: table.number(key, 0.0, least=0, most=most.get(key, math.inf)) for key in UNCERTAIN}
    )
