"""What one command of a calibration has found, as people ask for it: numbers with their standard deviations."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.angles import wrapped
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import JointSensors
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.recording import Recording
from tfsat_host.calibration.steps.step import AXES, Step
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BiasFound:
    """Of one gyro.

    Attributes:
        body: 1 to 4.
        bias_deg_s: (3,) sensor axes.
        std_deg_s: (3,).
        temperature_c: Of the die.
    """

    body: int
    bias_deg_s: FloatArray
    std_deg_s: FloatArray
    temperature_c: float

    @classmethod
    def of(cls, gyro: GyroCalibration) -> BiasFound:
        """From what is known of the gyro."""
        std = np.sqrt(np.diag(gyro.covariance)[:3])
        return cls(gyro.body, np.rad2deg(gyro.bias_rad_s), np.rad2deg(std), gyro.temperature_c)


@dataclass(frozen=True, eq=False)
class ZeroFound:
    """Of one joint.

    Attributes:
        joint: 1 to 3.
        zero_deg: (2,) what each of its sensors shows at joint angle zero, 0 to 360.
        std_deg: (2,).
        disagreement_deg: By the zero points that were known before: the joint's angle by the first sensor less that
            by the second; None where none were known.
    """

    joint: int
    zero_deg: FloatArray
    std_deg: FloatArray
    disagreement_deg: float | None

    @classmethod
    def of(cls, sensors: JointSensors, before: JointSensors | None) -> ZeroFound:
        """From what is known of the joint's sensors now, and what was known before."""
        disagreement = None
        if before is not None and before.zero_taken is not None:
            by_each = before.each(sensors.zero_rad[None, :])[0]
            disagreement = float(np.rad2deg(wrapped(by_each[:1] - by_each[1:])[0]))
        std = np.rad2deg(np.sqrt(np.diag(sensors.zero_covariance)))
        return cls(sensors.joint, np.rad2deg(sensors.zero_rad) % 360.0, std, disagreement)


@dataclass(frozen=True, eq=False)
class AxisFound:
    """A joint's axis in the frame of one gyro.

    Attributes:
        body: 1 to 4, the body that carries the gyro.
        axis: (3,) unit vector in sensor axes, in the joint's positive direction.
        nominal: (3,) the same where the gyro is mounted as designed.
        angle_deg: Angle between the two.
        std_deg: Standard deviation of the axis's direction, per transverse direction.
        rms_rate_deg_s: Excitation, rms.
        bias: Of the gyro.
    """

    body: int
    axis: FloatArray
    nominal: FloatArray
    angle_deg: float
    std_deg: float
    rms_rate_deg_s: float
    bias: BiasFound

    @classmethod
    def of(cls, gyro: GyroCalibration, evidence: Evidence, model: RobotModel) -> AxisFound:
        """From what is known of the gyro now, with the swing that was about the axis."""
        joint_axis = model.joint_axis[_joint(evidence.step) - 1]
        axis = gyro.rotation.T @ joint_axis
        nominal = model.imus[gyro.body - 1].sensor_to_body.T @ joint_axis
        # A rotation vector along the axis leaves it where it is; one across moves it by as much.
        across = np.eye(3) - np.outer(axis, axis)
        variance = float(np.trace(across @ gyro.covariance[3:6, 3:6] @ across)) / 2.0
        rates = Recording.from_counts(evidence.counts).rate_rad_s[:, gyro.body - 1] - gyro.bias_rad_s
        return cls(
            gyro.body,
            axis,
            nominal,
            float(np.rad2deg(np.arctan2(np.linalg.norm(np.cross(axis, nominal)), axis @ nominal))),
            float(np.rad2deg(np.sqrt(variance))),
            float(np.rad2deg(np.sqrt((rates**2).sum(axis=1).mean()))),
            BiasFound.of(gyro),
        )

    def cross_axis(self) -> tuple[float, float]:
        """Components of the two transverse sensor axes per component of the joint's own, in x, y, z order."""
        main = int(np.argmax(np.abs(self.nominal)))
        first, second = (float(self.axis[i] / self.axis[main]) for i in range(3) if i != main)
        return first, second


@dataclass(frozen=True, slots=True)
class ScaleFound:
    """Scale factor of one gyro for rotations about one axis of its body.

    Attributes:
        body: 1 to 4.
        axis: Of the body, x y or z: the one that lies nearest to the rotation's.
        scale: Reading over truth.
        std: Standard deviation.
    """

    body: int
    axis: str
    scale: float
    std: float

    @classmethod
    def of(cls, gyro: GyroCalibration, step: Step, model: RobotModel) -> ScaleFound:
        """About the body axis that a sweep or a turn was about."""
        about = model.joint_axis[_joint(step) - 1] if step.axis is None else np.eye(3)[AXES.index(step.axis)]
        index = int(np.argmax(np.abs(about)))
        return cls(gyro.body, AXES[index], *gyro.scale_about(index))


@dataclass(frozen=True, eq=False)
class BendFound:
    """How far the two angle sensors of a joint depart from a straight line.

    Attributes:
        joint: 1 to 3.
        bend_deg: (2, 4) amplitudes of sine and cosine of the angle shown and of twice that.
        std_deg: (2, 4).
    """

    joint: int
    bend_deg: FloatArray
    std_deg: FloatArray

    @classmethod
    def of(cls, sensors: JointSensors) -> BendFound:
        """From what is known of the joint's sensors."""
        std = np.sqrt(np.diag(sensors.bend_covariance)).reshape(2, 4)
        return cls(sensors.joint, np.rad2deg(sensors.bend), np.rad2deg(std))

    def largest_deg(self) -> FloatArray:
        """(2,) the most by which each sensor can be off, whatever it shows."""
        first, second = np.hypot(self.bend_deg[:, 0], self.bend_deg[:, 1]), np.hypot(*self.bend_deg[:, 2:].T)
        return np.asarray(first + second)


def axes_found(calibration: Calibration, evidence: Iterable[Evidence], model: RobotModel) -> list[AxisFound]:
    """Of the bodies that each swing moved."""
    return [
        AxisFound.of(calibration.gyros[body - 1], one, model) for one in evidence for body in one.step.moved
    ]


def scales_found(
    calibration: Calibration, evidence: Iterable[Evidence], model: RobotModel
) -> list[ScaleFound]:
    """Of the bodies that each sweep or turn moved."""
    return [
        ScaleFound.of(calibration.gyros[body - 1], one.step, model)
        for one in evidence
        for body in one.step.moved
    ]


def _joint(step: Step) -> int:
    if step.joint is None:
        raise ValueError(f"a {step.kind} moves no joint")
    return step.joint
