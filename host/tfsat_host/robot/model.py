"""The robot model: frozen, SI units, arrays over bodies and joints."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from tfsat_host.arrays import FloatArray, IntArray, describe_fields
from tfsat_host.errors import UsageError


def frozen(values: ArrayLike, *shape: int) -> FloatArray:
    """`values` as a read-only array of that shape, one length of which may be -1."""
    array = np.array(values, dtype=np.float64).reshape(shape)
    array.flags.writeable = False
    return array


def frozen_indices(values: ArrayLike) -> IntArray:
    """`values` (n,) as a read-only array of indices."""
    array = np.array(values, dtype=np.int64)
    array.flags.writeable = False
    return array


@dataclass(frozen=True)
class PulseMap:
    """How a servo turns pulses into joint angles.

    The angle of pulse p is `reference_angle_rad + (p - reference_pulse_us) / pulse_us_per_rad`.
    """

    range_us: tuple[float, float]
    reference_pulse_us: float
    reference_angle_rad: float
    pulse_us_per_rad: float

    def pulse_us(self, angle_rad: float) -> float:
        """Pulse width that commands `angle_rad`; not limited to the servo's range."""
        return self.reference_pulse_us + (angle_rad - self.reference_angle_rad) * self.pulse_us_per_rad


@dataclass(frozen=True, eq=False)
class ServoDynamics:
    """How fast a servo moves its joint one way.

    Attributes:
        max_rate_rad_s: Greatest joint rate.
        acceleration_rad_s2: Greatest joint acceleration.
        delay_s: From a stroke's time to the joint's first motion.
        covariance: (3, 3) of these three in their order, SI; None: not measured, and strokes take the average rate.
    """

    max_rate_rad_s: float
    acceleration_rad_s2: float
    delay_s: float
    covariance: FloatArray | None = None


@dataclass(frozen=True)
class Servo:
    """How a joint is driven.

    Attributes:
        average_rate_rad_s: Of a whole stroke, as schedules assume it.
        max_rate_rad_s: Greatest joint rate.
        acceleration_rad_s2: Greatest joint acceleration.
        start_rad: Joint angle at the start of a maneuver.
        pulses: None where the file has no pulses, as in a study without boards.
        delay_s: From a stroke's time to the joint's first motion.
        measured: Dynamics towards smaller and towards larger angles; None: not measured.
        play_rad: A joint stops half of it short of where its servo sends it, on the side from which it came.
        stop_std_rad: Of where a single stroke ends about that; None: not measured.
        absent: The joint is not there; see `absent_parts`.
    """

    average_rate_rad_s: float
    max_rate_rad_s: float
    acceleration_rad_s2: float
    start_rad: float
    pulses: PulseMap | None
    delay_s: float = 0.0
    measured: tuple[ServoDynamics | None, ServoDynamics | None] = (None, None)
    play_rad: float = 0.0
    stop_std_rad: float | None = None
    absent: bool = False

    def dynamics(self, delta_rad: float) -> ServoDynamics:
        """Return the dynamics of a stroke of `delta_rad`: as measured that way, else as the file states them."""
        by_file = ServoDynamics(self.max_rate_rad_s, self.acceleration_rad_s2, self.delay_s)
        return self.measured[int(delta_rad > 0.0)] or by_file

    def stop_rad(self, from_rad: float, target_rad: float) -> float:
        """Return the angle at which a joint stops that its servo moves from one angle to another."""
        half_play_rad = 0.5 * self.play_rad
        return min(max(from_rad, target_rad - half_play_rad), target_rad + half_play_rad)


@dataclass(frozen=True, eq=False)
class Imu:
    """One inertial sensor on a body.

    `position_m`: (3,) in the body frame. `sensor_to_body`: (3, 3) rotation as mounted by design. `absent`: it is not
    there; see `absent_parts`.
    """

    body: int
    bus: int
    address: int
    position_m: FloatArray
    sensor_to_body: FloatArray
    gyro_range_rad_s: float
    low_pass_hz: float
    absent: bool = False


@dataclass(frozen=True)
class AngleSensor:
    """One absolute angle sensor: it shows `zero_offset_rad + direction * joint angle`, modulo a turn.

    `nonlinearity_rad`: how far it bends from that, as the standard deviation of each coefficient of sin, cos and of
    those of twice the angle that it shows. `absent`: it is not there; see `absent_parts`.
    """

    joint: int
    direction: int
    zero_offset_rad: float
    nonlinearity_rad: float = 0.05 * math.pi / 180  # assumed: a good magnetic encoder, adjusted
    absent: bool = False


UNCERTAIN: Mapping[str, tuple[str, float]] = {
    "mass_relative": ("mass_relative", 1.0),
    "com_mm": ("com_m", 1e-3),
    "inertia_relative": ("inertia_relative", 1.0),
    "joint_point_mm": ("joint_point_m", 1e-3),
    "joint_axis_deg": ("joint_axis_rad", math.radians(1.0)),
    "stroke_deg": ("stroke_rad", math.radians(1.0)),
    "stroke_relative": ("stroke_relative", 1.0),
    "servo_speed_relative": ("servo_speed_relative", 1.0),
    "servo_delay_ms": ("servo_delay_s", 1e-3),
}
"""The keys of a file's `[uncertainty]`: which attribute each is, and its unit in SI units."""
MAX_RELATIVE = 0.2
"""Of a relative figure: five standard deviations below it, something must be left of a mass, an inertia or a rate."""


@dataclass(frozen=True)
class Uncertainty:
    """One standard deviation of what the file's figures may be wrong by, for Monte Carlo studies.

    Errors are drawn from normal distributions with mean zero. A figure of 0 is taken as exact.

    Attributes:
        mass_relative: Of each body's mass, independent; a share of the mass.
        com_m: Of each coordinate of each center of mass.
        inertia_relative: Of each body's inertia tensor as a whole, a share of it: errors of single
            entries would soon leave what a rigid body can have.
        joint_point_m: Of each coordinate of each joint's point.
        joint_axis_rad: Of each axis's direction, about each of two axes perpendicular to it.
        stroke_rad: Of the angle at which a stroke ends, drawn for every stroke.
        stroke_relative: Of a servo's scale, drawn once for a joint: it goes `1 + error` times as far as
            commanded, there and back.
        servo_speed_relative: Of a servo's rate, drawn once for a joint; a share of the rate.
        servo_delay_s: Of a servo's delay, drawn once for a joint.
    """

    mass_relative: float = 0.0
    com_m: float = 0.0
    inertia_relative: float = 0.0
    joint_point_m: float = 0.0
    joint_axis_rad: float = 0.0
    stroke_rad: float = 0.0
    stroke_relative: float = 0.0
    servo_speed_relative: float = 0.0
    servo_delay_s: float = 0.0

    @classmethod
    def of(cls, stated: Mapping[str, float]) -> Uncertainty:
        """Build the uncertainty from a file's values, in the units of their keys.

        A value left out is 0.
        """
        return cls(**{name: stated[key] * unit for key, (name, unit) in UNCERTAIN.items() if key in stated})

    def figures(self) -> dict[str, float]:
        """Return the values as a file states them, by the keys of `UNCERTAIN`."""
        return {key: float(f"{getattr(self, name) / unit:.12g}") for key, (name, unit) in UNCERTAIN.items()}


ASSUMED = Uncertainty(
    mass_relative=0.02,
    com_m=0.003,
    inertia_relative=0.03,
    joint_point_m=0.5e-3,
    joint_axis_rad=math.radians(0.5),
)
"""Of a robot whose file states none: that of the drop tower's."""


@dataclass(frozen=True, eq=False)
class RobotModel:
    """A tree of n rigid bodies and n - 1 hinges.

    At zero joint angles all body frames are parallel to the global frame. The angle of joint j is that of
    body `joint_outer[j]` relative to body `joint_inner[j]`, positive about `joint_axis[j]`.

    Attributes:
        path: The file that the model was read from.
        name: What people call the robot.
        source: Where its figures come from, in a sentence; empty if the file does not say.
        base: Index of the body whose attitude is the robot's attitude.
        body_names: n names.
        mass_kg: (n,).
        origin_m: (n, 3) origin of each body frame, global, at zero joint angles.
        com_m: (n, 3) center of mass in the body frame.
        inertia_kg_m2: (n, 3, 3) tensor about the center of mass, body axes; its off-diagonal entries are
            minus the products of inertia.
        shape_m: n arrays (k, 3), corners in the body frame whose convex hull holds the body; (0, 3) for a
            body without a stated shape.
        joint_names: n - 1 names.
        joint_inner, joint_outer: (n - 1,) body indices.
        joint_axis: (n - 1, 3) unit vectors.
        joint_point_m: (n - 1, 3) a point on the axis, global, at zero joint angles.
        joint_limits_rad: (n - 1, 2) least and greatest angle.
        servos: One a joint.
        imus: In the order of the log; may be empty.
        angle_sensors: In the order of the log; may be empty.
        uncertainty: None if the file states none.
    """

    path: Path
    name: str
    source: str
    base: int
    body_names: tuple[str, ...]
    mass_kg: FloatArray
    origin_m: FloatArray
    com_m: FloatArray
    inertia_kg_m2: FloatArray
    shape_m: tuple[FloatArray, ...]
    joint_names: tuple[str, ...]
    joint_inner: IntArray
    joint_outer: IntArray
    joint_axis: FloatArray
    joint_point_m: FloatArray
    joint_limits_rad: FloatArray
    servos: tuple[Servo, ...]
    imus: tuple[Imu, ...]
    angle_sensors: tuple[AngleSensor, ...]
    uncertainty: Uncertainty | None

    __repr__ = describe_fields

    @property
    def n_bodies(self) -> int:
        """Number of bodies."""
        return len(self.body_names)

    @property
    def n_joints(self) -> int:
        """Number of joints."""
        return len(self.joint_names)

    @property
    def has_sequencer(self) -> bool:
        """Whether the sequencer commands every servo: the file says what its pulses do."""
        return all(servo.pulses is not None for servo in self.servos)

    def body_index(self, body: str) -> int:
        """Index of a body by its name, or by its number from 1.

        Raises:
            UsageError: there is no such body.
        """
        names = self.body_names
        # Names before numbers: a body may be called "2".
        if body in names:
            return names.index(body)
        if body.isascii() and body.isdigit() and 1 <= int(body) <= len(names):
            return int(body) - 1
        raise UsageError(
            what=f"{self.path} has no body {body!r}.",
            meaning="Nothing was done.",
            next_step=f"Name one of its bodies ({', '.join(names)}) or a number from 1 to {len(names)}.",
        )
