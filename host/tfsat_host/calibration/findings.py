"""What steps of a calibration have found, as people ask for it: typed rows."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.mounting_checks import angle_between
from tfsat_host.calibration.response import across
from tfsat_host.calibration.sensors.gyro import MOUNTING, GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import JointSensors
from tfsat_host.calibration.servos.dynamics_fit import MeasuredDynamics
from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.step import AXES, StepKind, bodies
from tfsat_host.quantity import plus_minus, vector
from tfsat_host.robot import RobotModel


@dataclass(frozen=True, eq=False)
class ZeroPoints:
    """The zero points of a joint's two sensors: what each reads at joint angle zero.

    Attributes:
        sensors: The joint's.
        disagreement_deg: The joint's angle by the first sensor less that by the second, by the zero points known
            before; None if none were.
    """

    sensors: JointSensors
    disagreement_deg: float | None = None

    @property
    def joint(self) -> int:
        """1 to 3."""
        return self.sensors.joint

    @property
    def zero_deg(self) -> FloatArray:
        """(2,) readings at joint angle zero, 0 to 360 deg."""
        return np.asarray(np.rad2deg(self.sensors.zero_rad) % 360.0)

    @property
    def std_deg(self) -> FloatArray:
        """(2,) standard deviations."""
        return np.asarray(np.rad2deg(np.sqrt(np.diag(self.sensors.zero_covariance))))


def zero_points(sensors: JointSensors, before: JointSensors | None) -> ZeroPoints:
    """Build a joint's zero points, compared with those known before, if any were measured."""
    if before is None or before.zero_recorded_at is None:
        return ZeroPoints(sensors)
    # Read the new zeros by the old calibration: what sets both sensors apart is a slip since then.
    by_each = before.each(sensors.zero_rad[None, :])[0]
    return ZeroPoints(sensors, float(np.rad2deg(wrap_angle(by_each[:1] - by_each[1:])[0])))


@dataclass(frozen=True, eq=False)
class JointAxis:
    """A joint's axis in the frame of a gyro that a swing moved.

    Attributes:
        gyro: Of the moved body.
        axis_sensor: (3,) the axis, sensor frame.
        nominal_sensor: (3,) its direction if the gyro is mounted as designed.
        rms_rate_deg_s: Of the swing, bias taken off.
    """

    gyro: GyroCalibration
    axis_sensor: FloatArray
    nominal_sensor: FloatArray
    rms_rate_deg_s: float

    @property
    def angle_deg(self) -> float:
        """Angle between the axis and its direction by design."""
        return float(np.rad2deg(angle_between(self.axis_sensor, self.nominal_sensor)))

    @property
    def std_deg(self) -> float:
        """Standard deviation of the axis's direction, per transverse direction."""
        # A rotation vector along the axis leaves it where it is; one across moves it by as much.
        project = across(self.axis_sensor)
        return float(
            np.rad2deg(np.sqrt(np.trace(project @ self.gyro.covariance[MOUNTING, MOUNTING] @ project) / 2.0))
        )

    @property
    def cross_axis(self) -> tuple[float, ...]:
        """The two transverse components, in x, y, z order, relative to the component along the main axis."""
        # The component along the design's main axis is what the other two are compared with.
        main = int(np.argmax(np.abs(self.nominal_sensor)))
        return tuple(float(self.axis_sensor[i] / self.axis_sensor[main]) for i in range(3) if i != main)


@dataclass(frozen=True, eq=False)
class GyroAxis:
    """A gyro about one axis of its body.

    Attributes:
        gyro: The body's.
        index: Of the axis, 0 to 2.
        nominal: (3, 3) the gyro's rotation from sensor to body axes by design.
    """

    gyro: GyroCalibration
    index: int
    nominal: FloatArray

    @property
    def axis(self) -> str:
        """Its name, x, y or z."""
        return AXES[self.index]

    @property
    def scale(self) -> float:
        """Reading over truth."""
        return self.gyro.scale_about(self.index)[0]

    @property
    def scale_std(self) -> float:
        """Standard deviation of the scale factor."""
        return self.gyro.scale_about(self.index)[1]

    @property
    def axis_sensor(self) -> FloatArray:
        """(3,) the body axis, sensor frame."""
        return np.asarray(self.gyro.rotation[self.index])

    @property
    def misalignment_deg(self) -> float:
        """Angle, in sensor axes, from the body axis to where the design has it."""
        return float(np.rad2deg(angle_between(self.axis_sensor, self.nominal[self.index])))

    @property
    def misalignment_std_deg(self) -> float:
        """Standard deviation of the axis's direction, in the worst transverse direction."""
        # A small rotation d moves the axis by d x axis; the largest eigenvalue is the worst way across.
        cross = np.cross(np.eye(3), self.axis_sensor)
        spread = cross @ self.gyro.covariance[MOUNTING, MOUNTING] @ cross.T
        return float(np.rad2deg(np.sqrt(np.linalg.eigvalsh(spread)[-1])))


@dataclass(frozen=True, eq=False)
class SensorBend:
    """The nonlinearity of one angle sensor.

    Attributes:
        joint: 1 to 3.
        sensor: 1 or 2.
        bend_deg: (4,) amplitudes of sin, cos, sin 2 and cos 2 of the angle shown.
        std_deg: (4,) standard deviations.
    """

    joint: int
    sensor: int
    bend_deg: FloatArray
    std_deg: FloatArray

    @property
    def largest_error_deg(self) -> float:
        """Largest possible error of the sensor: amplitudes of both harmonics add up at worst."""
        return float(np.hypot(*self.bend_deg[:2]) + np.hypot(*self.bend_deg[2:]))


def joint_axes(gyros: Sequence[GyroCalibration], swing: Evidence, model: RobotModel) -> list[JointAxis]:
    """Build the joint's axis in the frame of each gyro that a swing moved."""
    joint_axis = model.joint_axis[swing.step.moving_joint - 1]
    rows = []
    for gyro in (gyros[body - 1] for body in swing.step.moved):
        rates = swing.recording.rate_rad_s[:, gyro.body - 1] - gyro.bias_rad_s
        rms_deg_s = float(np.rad2deg(np.sqrt((rates**2).sum(axis=1).mean())))
        nominal = model.imus[gyro.body - 1].sensor_to_body.T @ joint_axis
        rows.append(JointAxis(gyro, gyro.rotation.T @ joint_axis, nominal, rms_deg_s))
    return rows


def scale_axes(gyros: Sequence[GyroCalibration], moved: Evidence, model: RobotModel) -> list[GyroAxis]:
    """Build each gyro that a sweep or a turn moved, about the body axis nearest to the rotation's."""
    step = moved.step
    index = (
        AXES.index(step.axis)
        if step.axis
        else int(np.argmax(np.abs(model.joint_axis[step.moving_joint - 1])))
    )
    return [GyroAxis(gyros[body - 1], index, model.imus[body - 1].sensor_to_body) for body in step.moved]


def sensor_bends(calibration: Calibration, steps: Iterable[Evidence]) -> list[SensorBend]:
    """Build the bends of both sensors of each joint that was swept."""
    swept_joints = {evidence.step.joint for evidence in steps if evidence.step.kind == StepKind.SWEEP}
    bends = []
    for sensors in calibration.joints:
        if sensors.joint in swept_joints:
            stds = np.rad2deg(np.sqrt(np.diag(sensors.bend_covariance))).reshape(2, 4)
            rows = enumerate(zip(np.rad2deg(sensors.bend), stds, strict=True), 1)
            bends += [SensorBend(sensors.joint, number, bend, std) for number, (bend, std) in rows]
    return bends


def step_findings(
    steps: Sequence[Evidence], before: Calibration | None, now: Calibration, model: RobotModel
) -> Sequence[GyroCalibration | ZeroPoints | JointAxis | GyroAxis | MeasuredDynamics]:
    """Build the results of steps of one kind, for all their gyros, joints or axes."""
    kind = steps[0].step.kind
    if kind == StepKind.REST:
        return now.present_gyros
    if kind == StepKind.ZERO:
        joints = {evidence.step.joint for evidence in steps}
        earlier_joints = [None] * len(now.joints) if before is None else before.joints
        pairs = zip(now.joints, earlier_joints, strict=True)
        return [
            zero_points(sensors, old)
            for sensors, old in pairs
            if joints & {None, sensors.joint} and not sensors.absent
        ]
    if kind == StepKind.STROKES:
        joints = {evidence.step.joint for evidence in steps}
        return [fit for fit in now.servo_dynamics if fit.joint in joints]
    if kind == StepKind.SWING:
        return [row for evidence in steps for row in joint_axes(now.gyros, evidence, model)]
    return [row for evidence in steps for row in scale_axes(now.gyros, evidence, model)]


def finding_lines(step: Evidence, calibration: Calibration, model: RobotModel) -> list[str]:
    """Format the results of an accepted step, one line each."""
    kind = step.step.kind
    if kind == StepKind.SERVO:
        return [f"servo of joint {step.step.joint}: {len(step.visits)} places visited"]
    findings = step_findings([step], None, calibration, model)
    if kind == StepKind.REST:
        gyros = calibration.present_gyros
        largest = max(gyro.bias_std_rad_s.max() for gyro in gyros)
        return [f"biases of {bodies(gyro.body for gyro in gyros)}: max. ± {np.rad2deg(largest):.4f} deg/s"]
    return [_LINES[kind](finding) for finding in findings]


def _scale_line(row: GyroAxis) -> str:
    return f"body {row.gyro.body}: scale factor {row.axis} {plus_minus(row.scale, row.scale_std)}"


_LINES: Final[Mapping[StepKind, Callable[[Any], str]]] = {
    StepKind.ZERO: lambda row: f"joint {row.joint}: zero at {vector(row.zero_deg, row.std_deg)} deg",
    StepKind.SWING: lambda row: (
        f"body {row.gyro.body}: misalignment {plus_minus(row.angle_deg, row.std_deg)} deg"
    ),
    StepKind.SWEEP: _scale_line,
    StepKind.TURN: _scale_line,
}


def certificate_values(
    calibration: Calibration, model: RobotModel
) -> dict[str, GyroCalibration | ZeroPoints | GyroAxis | ServoMap]:
    """Return what holds the value of everything in a certificate, by the names that `quantities` has for it."""
    rows: dict[str, GyroCalibration | ZeroPoints | GyroAxis | ServoMap] = {}
    for gyro in calibration.gyros:
        rows[f"bias of body {gyro.body}"] = gyro
        for index, axis in enumerate(AXES):
            row = GyroAxis(gyro, index, model.imus[gyro.body - 1].sensor_to_body)
            rows[f"scale factor {axis} of body {gyro.body}"] = row
            rows[f"misalignment of body {gyro.body} about {axis}"] = row
    rows |= {f"zero point of joint {sensors.joint}": ZeroPoints(sensors) for sensors in calibration.joints}
    return rows | {f"servo of joint {servo.joint}": servo for servo in calibration.servo_maps}
