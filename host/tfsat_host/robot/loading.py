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

from tfsat_host.arrays import FloatArray, IntArray
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

_BODY = "name mass_kg origin_mm com_mm inertia_g_m2 boxes_mm"
# The radius of gyration of a body over its reach, from its center of mass to its joints and corners, and over the size
# of the robot. One that is off by a factor of 1000 in its inertia or mass is off by 32 in that radius.
_MIN_GYRATION, _MAX_GYRATION = 0.03, 3.0
# Shapes are drawn roughly and inertias rounded: a mass that is spread by more than twice what its boxes can hold, by
# more than this share of its greatest moment, is another one's.
_WIDER, _ROUNDED = 2.0, 0.05
# Centers of mass in m instead of mm, next to the greatest length of the robot.
_IN_METERS = (1e-5, 1e-3)
_MAX_IMU_DISTANCE = 2.0  # sizes of the robot
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


def _check_sizes(bodies: Sequence[Table], robot: RobotModel) -> None:
    """Inertia, mass and lengths are of one robot, in the units that the file's keys name.

    Raises:
        RobotFileError: a body's mass is spread by far less or more than its joints and boxes lie apart, or by more than
            its boxes allow about its center of mass, or all centers of mass look like meters.
    """
    com_m = robot.origin_m + robot.com_m
    marks = np.concatenate([com_m, robot.joint_point_m, robot.origin_m])
    if not robot.n_joints:
        return  # nothing to compare with
    # The diagonal around all joints and centers of mass is the scale to judge units by.
    size_m = float(np.linalg.norm(marks.max(axis=0) - marks.min(axis=0)))
    offsets_m = float(np.abs(robot.com_m).max())
    if _IN_METERS[0] * size_m < offsets_m < _IN_METERS[1] * size_m:
        bodies[0].fail(
            "com_mm",
            f"no center of mass is farther than {1e3 * offsets_m:.2g} mm from the origin of its frame, in a robot of "
            f"{1e3 * size_m:.3g} mm",
            "Give com_mm in mm, not m; write 0 where an origin is the center of mass.",
        )
    for b, (entry, corners) in enumerate(zip(bodies, robot.shape_m, strict=True)):
        at_joints = robot.joint_point_m[(robot.joint_inner == b) | (robot.joint_outer == b)]
        # A body reaches from its center of mass to its joints and corners.
        ends = np.concatenate([at_joints - com_m[b], corners - robot.com_m[b]])
        reach_m = float(np.linalg.norm(ends, axis=1).max(initial=0.0))
        inertia = robot.inertia_kg_m2[b]
        # The radius of gyration is a length made of inertia and mass: a wrong unit of either shows.
        gyration_m = math.sqrt(np.linalg.eigvalsh(inertia)[-1] / robot.mass_kg[b])
        if gyration_m < _MIN_GYRATION * reach_m or 0.0 < _MAX_GYRATION * max(size_m, reach_m) < gyration_m:
            entry.fail(
                "inertia_g_m2",
                f"with its mass the radius of gyration is {1e3 * gyration_m:.3g} mm, and its joints and corners reach "
                f"{1e3 * reach_m:.3g} mm from the center of mass",
                "Check the units: mass in kg, inertia in g m^2 (1 kg m^2 is 1000 g m^2), lengths in mm.",
            )
        if len(corners):
            _check_spread(entry, robot.com_m[b], corners, np.diag(inertia), float(robot.mass_kg[b]))


def _check_imu_places(entries: Sequence[Table], robot: RobotModel) -> None:
    """Check that each IMU is on its robot.

    Raises:
        RobotFileError: one lies farther from its body's center of mass than twice the robot's length.
    """
    corners_m = [shape + origin for shape, origin in zip(robot.shape_m, robot.origin_m, strict=True)]
    marks = np.concatenate([robot.origin_m + robot.com_m, robot.joint_point_m, *corners_m])
    size_m = float(np.linalg.norm(marks.max(axis=0) - marks.min(axis=0)))
    for entry, imu in zip(entries, robot.imus, strict=True):
        away_m = float(np.linalg.norm(imu.position_m - robot.com_m[imu.body]))
        if away_m > _MAX_IMU_DISTANCE * size_m > 0.0:
            entry.fail(
                "position_mm",
                f"is {1e3 * away_m:.3g} mm from the center of mass of its body, of a robot of {1e3 * size_m:.3g} mm",
                "Give it in mm, in the body's frame.",
            )


def _check_spread(
    entry: Table, com_m: FloatArray, corners: FloatArray, moments: FloatArray, mass_kg: float
) -> None:
    """Refuse an inertia that spreads the mass wider than the body's boxes allow.

    A mass between two walls with its mean at a < x < b has a variance of at most (x - a)(b - x).
    R. Bhatia, C. Davis, A Better Bound on the Variance, American Mathematical Monthly 107, 2000.
    """
    # Along each axis the second moment is half the trace less the moment about it.
    variance = (moments.sum() / 2.0 - moments) / mass_kg
    room = (com_m - corners.min(axis=0)) * (corners.max(axis=0) - com_m)
    wide = np.flatnonzero(mass_kg * (variance - _WIDER**2 * room) > _ROUNDED * moments.max())
    if len(wide):
        k = int(wide[0])
        entry.fail(
            "com_mm",
            f"the inertia spreads the mass by {1e3 * math.sqrt(variance[k]):.3g} mm along {'xyz'[k]}, and about this "
            f"center of mass the boxes have room for {1e3 * math.sqrt(max(room[k], 0.0)):.3g} mm",
            "Check units and frame of com_mm, boxes_mm and inertia_g_m2: lengths in mm in the body's frame, inertia in "
            "g m^2 about the center of mass.",
        )


_JOINT = "name inner outer axis point_mm limits_deg servo"
_SERVO = "average_rate_deg_s max_rate_deg_s acceleration_deg_s2 start_deg"
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


def _check_tree(
    bodies: Sequence[Table],
    joints: Sequence[Table],
    inner: IntArray,
    outer: IntArray,
    body_names: tuple[str, ...],
) -> None:
    """Joints from `inner` to `outer` (n - 1,) connect all bodies without a loop.

    Raises:
        RobotFileError: a joint closes a loop or joins a body to itself, or a body is not connected.
    """
    # Merge groups joint by joint: a joint within a group closes a loop, two groups left are apart.
    group = list(range(len(body_names)))
    for joint, a, b in zip(joints, inner, outer, strict=True):
        if a == b:
            joint.fail("outer", "the joint joins a body to itself", "Name two different bodies.")
        if group[a] == group[b]:
            joint.fail(
                "outer",
                f"the joint closes a loop: {body_names[a]!r} and {body_names[b]!r} are already connected",
                "Remove one joint of the loop; only open chains and trees can be computed.",
            )
        group = [group[a] if g == group[b] else g for g in group]
    for body, g in enumerate(group):
        if g != group[0]:
            bodies[body].fail(
                "name",
                f"no joint connects {body_names[body]!r} with {body_names[0]!r}",
                "Add the missing `[[joint]]`, or remove the body.",
            )


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
    _check_tree(body, joint, inner, outer, body_names)
    _check_sizes(body, robot)
    _check_imu_places(top.tables("imu", _IMU), robot)
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
