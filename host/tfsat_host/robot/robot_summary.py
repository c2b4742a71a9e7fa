"""A robot in numbers that people read: what `tfsat-host robot` prints as JSON, as one screen, and as tables.

Millimetres, degrees and g m^2, unlike the model itself; units are in the keys.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import degrees

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.quantity import Column, Columns, Table, columns_of, fields, vector
from tfsat_host.robot.model import AngleSensor, Imu, PulseMap, RobotModel, Servo

# Decimal figures of a file come back as they were typed after the way to SI units and back.
_DECIMALS = 9
_INERTIA_CONVENTION = (
    "Inertias are tensors about the center of mass, in body axes, all parallel to the global ones at zero angles; "
    "off-diagonal entries are minus the products of inertia."
)
_ENTRIES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


@dataclass(frozen=True, eq=False, slots=True)
class BodySummary:
    """One rigid body, or the whole robot at zero joint angles.

    Attributes:
        name: Of the body.
        mass_kg: Its mass.
        com_m: (3,) its center of mass, body axes.
        inertia_kg_m2: (3, 3) about the center of mass, body axes.
        origin_m: (3,) its origin at zero joint angles, global axes.
        corners_m: (k, 3) of its shape, body axes.
    """

    name: str
    mass_kg: float
    com_m: FloatArray
    inertia_kg_m2: FloatArray
    origin_m: FloatArray
    corners_m: FloatArray

    @property
    def principal_moments_kg_m2(self) -> FloatArray:
        """(3,) of the inertia, rising."""
        return np.asarray(np.linalg.eigvalsh(self.inertia_kg_m2))


@dataclass(frozen=True, eq=False, slots=True)
class JointSummary:
    """One joint and its servo; its axis and point are in global axes at zero joint angles."""

    name: str
    inner: str
    outer: str
    axis: FloatArray
    point_m: FloatArray
    limits_rad: FloatArray
    servo: Servo


@dataclass(frozen=True, eq=False, slots=True)
class ImuSummary:
    """One IMU and the name of its body."""

    body: str
    imu: Imu


@dataclass(frozen=True, slots=True)
class AngleSensorSummary:
    """One angle sensor and the name of its joint."""

    joint: str
    sensor: AngleSensor


@dataclass(frozen=True, eq=False, slots=True)
class RobotSummary:
    """A robot, its parts, and the whole of it at zero joint angles."""

    robot: RobotModel
    whole: BodySummary
    bodies: tuple[BodySummary, ...]
    joints: tuple[JointSummary, ...]

    @classmethod
    def of(cls, robot: RobotModel) -> RobotSummary:
        """Summarize a robot model."""
        whole = BodySummary("all, joints at zero", *totals(robot), np.zeros(3), np.empty((0, 3)))
        names = robot.body_names
        bodies = zip(
            names,
            robot.mass_kg,
            robot.com_m,
            robot.inertia_kg_m2,
            robot.origin_m,
            robot.shape_m,
            strict=True,
        )
        joints = zip(
            robot.joint_names,
            (names[body] for body in robot.joint_inner),
            (names[body] for body in robot.joint_outer),
            robot.joint_axis,
            robot.joint_point_m,
            robot.joint_limits_rad,
            robot.servos,
            strict=True,
        )
        return cls(
            robot,
            whole,
            tuple(BodySummary(*body) for body in bodies),
            tuple(JointSummary(*joint) for joint in joints),
        )

    @property
    def imus(self) -> list[ImuSummary]:
        """Each IMU with the name of its body."""
        return [ImuSummary(self.robot.body_names[imu.body], imu) for imu in self.robot.imus]

    @property
    def angle_sensors(self) -> list[AngleSensorSummary]:
        """Each angle sensor with the name of its joint."""
        sensors = self.robot.angle_sensors
        return [AngleSensorSummary(self.robot.joint_names[sensor.joint], sensor) for sensor in sensors]

    @property
    def uncertainty(self) -> dict[str, float] | None:
        """The robot file's standard deviations by their keys; None if it states none."""
        return None if self.robot.uncertainty is None else self.robot.uncertainty.figures()


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


def _tensor_entry(place: tuple[int, int], body: BodySummary) -> float:
    """Return an entry of a body's inertia tensor, g m^2."""
    return 1e3 * float(body.inertia_kg_m2[place])


def _as_typed(*columns: Column) -> Columns:
    """Columns of numbers, or arrays of them, rounded to what a file may say, without negative zeros."""

    def rounded(column: Column) -> Column:
        return replace(
            column, of=lambda row: (np.round(np.asarray(column.value(row)), _DECIMALS) + 0.0).tolist()
        )

    return tuple(rounded(column) for column in columns)


_MASS = _as_typed(Column("mass_kg", "mass", form="g"))
_COM = _as_typed(Column("com_mm", "CoM in body", form=".5g"))
_INERTIA = _as_typed(Column("inertia_g_m2"), Column("principal_moments_g_m2", form=".5g"))
_WHOLE_LABELS = {
    "mass_kg": "Mass",
    "com_mm": "CoM, joints at 0 deg",
    "principal_moments_g_m2": "Principal moments",
}
_BODY: Columns = (
    Column("name", "body"),
    *_MASS,
    *_as_typed(Column("origin_mm", "origin", form=".5g")),
    *_COM,
    *_INERTIA,
    *_as_typed(
        Column("corners_mm", "shape in body", words=lambda body: _format_extent(1e3 * body.corners_m))
    ),
)
_TENSOR: Columns = (
    Column("name", "g m^2"),
    *(Column("", entry, of=partial(_tensor_entry, place), form=".5g") for entry, place in _ENTRIES.items()),
    replace(_INERTIA[1], label="principal moments"),
)
_PULSES: Columns = (
    *fields("range_us reference_pulse_us"),
    *_as_typed(
        Column("reference_angle_deg"),
        # Per radian to per degree is the factor of degrees to radians.
        Column("pulse_us_per_deg", of=lambda pulses: np.radians(pulses.pulse_us_per_rad)),
    ),
)
_SERVO: Columns = (
    *_as_typed(
        Column("average_rate_deg_s", "average", form="g"),
        Column("max_rate_deg_s", "max.", form="g"),
        Column("acceleration_deg_s2", "acceleration", form="g"),
        Column("start_deg", "start", form="g"),
    ),
    Column("pulses", "pulses", words=lambda servo: _format_pulses(servo.pulses), columns=_PULSES),
)
_SERVO_ROW: Columns = (Column("name", "joint"), *columns_of("servo", _SERVO))
_JOINT: Columns = (
    Column("name", "joint"),
    *fields("inner outer"),
    *_as_typed(
        Column("axis", "about +", form=".5g"),
        Column("point_mm", "through", form=".5g"),
        Column("limits_deg", "limits", words=lambda joint: _format_range(np.degrees(joint.limits_rad))),
    ),
    Column("servo", columns=_SERVO),
)
_TURNS = Column("", "its angle turns", words=lambda joint: f"{joint.outer} relative to {joint.inner}")
_IMU: Columns = (
    Column("body", "on"),
    *columns_of(
        "imu",
        (
            *fields("bus"),
            Column("address", "bus, address", words=lambda imu: f"{imu.bus}, 0x{imu.address:02x}"),
            *_as_typed(
                Column("position_mm", "at", form=".5g"),
                Column(
                    "sensor_to_body",
                    "rows of sensor to body",
                    words=lambda imu: ", ".join(vector(axis, form=".5g") for axis in imu.sensor_to_body),
                ),
                Column("gyro_range_deg_s", "range", form="g"),
            ),
            Column("low_pass_hz", "low-pass", form="g"),
        ),
    ),
)
_ANGLE_SENSOR: Columns = (
    Column("joint", "joint"),
    *columns_of(
        "sensor",
        (
            Column("direction", "direction", words=lambda sensor: f"{sensor.direction:+d}"),
            *_as_typed(Column("zero_offset_deg", "shows at zero", of="zero_offset_rad", form="g")),
        ),
    ),
)
_WHOLE = columns_of("whole", (*_MASS, *_COM, *_INERTIA))
SUMMARY: Columns = (
    Column("name", "Robot", of="robot.name"),
    Column("file", "File", of=lambda summary: str(summary.robot.path)),
    Column(
        "source",
        "Figures",
        of="robot.source",
        words=lambda summary: summary.robot.source or "source not stated in the file",
    ),
    Column(
        "base",
        "Base",
        of=lambda summary: summary.robot.body_names[summary.robot.base],
        words=lambda summary: (
            f"{summary.robot.body_names[summary.robot.base]} (the robot's attitude is that of this body)"
        ),
    ),
    *(replace(column, label=_WHOLE_LABELS.get(column.key, "")) for column in _WHOLE),
    Column("bodies", columns=_BODY),
    Column("joints", "Servos", words=lambda summary: _format_servos(summary.joints), columns=_JOINT),
    Column("imus", "IMUs", words=lambda summary: _format_imus(summary.robot.imus), columns=_IMU),
    Column(
        "angle_sensors",
        "Angle sensors",
        words=lambda summary: str(len(summary.angle_sensors) or ""),
        columns=_ANGLE_SENSOR,
    ),
    Column(
        "uncertainty", "Uncertainty (1 σ)", words=lambda summary: _format_uncertainty(summary.uncertainty)
    ),
)
"""A robot as `tfsat-host robot` shows it: all of it in `--json`, what has a label as facts for people."""


def overview_tables(summary: RobotSummary) -> list[Table]:
    """Return bodies and joints."""
    return [
        Table("Bodies", _BODY, summary.bodies),
        Table("Joints", (*_JOINT, _TURNS), summary.joints),
    ]


def detail_tables(summary: RobotSummary) -> list[Table]:
    """Return tensors, servos and sensors, without parts that the robot does not have."""
    return [
        Table("Inertia tensors", _TENSOR, (*summary.bodies, summary.whole), _INERTIA_CONVENTION),
        Table("Servos", _SERVO_ROW, summary.joints),
        Table("IMUs", _IMU, summary.imus),
        Table("Angle sensors", _ANGLE_SENSOR, summary.angle_sensors),
    ]


def _format_servos(joints: Sequence[JointSummary]) -> str:
    """Format what the servos can do, once if all can do the same."""
    servos = dict.fromkeys(
        f"{degrees(joint.servo.average_rate_rad_s):g} deg/s average, {degrees(joint.servo.max_rate_rad_s):g} deg/s "
        f"max., {degrees(joint.servo.acceleration_rad_s2):g} deg/s^2, start at {degrees(joint.servo.start_rad):g} deg"
        for joint in joints
    )
    return "; ".join(servos)


def _format_imus(imus: Sequence[Imu]) -> str:
    """Format how many IMUs there are, and their settings in the file; the logger has its own."""
    if not imus:
        return ""
    ranges = sorted({f"{degrees(imu.gyro_range_rad_s):g}" for imu in imus})
    low_passes = sorted({f"{imu.low_pass_hz:g}" for imu in imus})
    return (
        f"{len(imus)} (±{' or '.join(ranges)} deg/s, low-pass {' or '.join(low_passes)} Hz as in the "
        "paper; a recording's: tfsat-host logger-settings show)"
    )


def _format_uncertainty(figures: Mapping[str, float] | None) -> str:
    if figures is None:
        return "not stated in the file"
    return ", ".join(f"{key} {value:g}" for key, value in figures.items())


def _format_pulses(pulses: PulseMap | None) -> str:
    if pulses is None:
        return "none"
    return (
        f"{pulses.reference_pulse_us:g} us at {degrees(pulses.reference_angle_rad):g} deg, "
        f"{np.radians(pulses.pulse_us_per_rad):.6g} us/deg, {_format_range(pulses.range_us)} us"
    )


def _format_range(values: Sequence[float]) -> str:
    return f"{values[0]:g} to {values[1]:g}"


def _format_extent(corners_mm: FloatArray) -> str:
    if len(corners_mm) == 0:
        return "not stated"
    return f"{vector(corners_mm.min(axis=0), form='.5g')} to {vector(corners_mm.max(axis=0), form='.5g')}"
