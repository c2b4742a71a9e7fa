"""The two absolute angle sensors of a joint: their zero points, their bend, and the joint's angle from both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import FloatArray
from tfsat_host.robot import RobotModel


@dataclass(frozen=True, eq=False)
class JointSensors:
    """What the two sensors of a joint show: zero + direction * joint angle + bend, modulo a turn.

    Attributes:
        joint: 1 to 3.
        direction: (2,) +1 or -1.
        zero_rad: (2,) shown at joint angle zero.
        zero_covariance: (2, 2).
        bend: (2, 4) coefficients of sin, cos, sin 2, cos 2 of the angle shown, less their value at zero; rad.
        bend_covariance: (8, 8) of both, rad^2.
        noise_rad: (2,) standard deviation of one sample about its mean; NaN where none rested.
        zero_recorded_at, bend_recorded_at: When each was recorded; None: not yet, the zero is by design.
        absent: The robot has no such joint; it stands at 0.
    """

    joint: int
    direction: FloatArray
    zero_rad: FloatArray
    zero_covariance: FloatArray
    bend: FloatArray
    bend_covariance: FloatArray
    noise_rad: FloatArray
    zero_recorded_at: datetime | None
    bend_recorded_at: datetime | None
    absent: bool = False

    @property
    def has_zero(self) -> bool:
        """Whether its zero points are known: measured, or of a joint that is not there."""
        return self.zero_recorded_at is not None or self.absent

    def each(self, shown_rad: FloatArray) -> FloatArray:
        """(n, 2) joint angle by each sensor, of what both show (n, 2); within half a turn of zero."""
        # Take the bend off in the angle shown, wrap, then turn it by the direction into the joint's angle.
        columns = [
            self.direction[k]
            * wrap_angle(
                shown_rad[:, k] - self.zero_rad[k] - self.bend_curve(k, shown_rad[:, k]) @ self.bend[k]
            )
            for k in range(2)
        ]
        return np.column_stack(columns)

    def angle(self, shown_rad: FloatArray) -> FloatArray:
        """(n,) joint angle, the mean of both sensors."""
        return np.asarray(self.each(shown_rad).mean(axis=1))

    def from_start(self, angles_rad: FloatArray) -> FloatArray:
        """(n, ...) angles as they are; without a measured zero, from where the recording begins."""
        if self.has_zero:
            return angles_rad
        # Every step begins closed and at rest: the first fiftieth stands for angle zero.
        return np.asarray(angles_rad - angles_rad[: max(1, len(angles_rad) // 50)].mean(axis=0))

    def angle_variance(self, shown_rad: FloatArray) -> FloatArray:
        """(n,) variance of that from zero points, bend and one sample's noise, rad^2."""
        # (n, 8) gradient of the mean angle by the amplitudes of both sensors.
        curves = np.concatenate(
            [-0.5 * self.direction[k] * self.bend_curve(k, shown_rad[:, k]) for k in range(2)], axis=1
        )
        half = -0.5 * self.direction
        systematic = float(half @ self.zero_covariance @ half)
        bend = np.einsum("ni,ij,nj->n", curves, self.bend_covariance, curves)
        # Noise of the mean of two; a sensor that never rested (NaN) adds none.
        noise = 0.25 * float(np.nansum(self.noise_rad**2))
        return np.asarray(systematic + bend + noise)

    def bend_curve(self, sensor: int, shown_rad: FloatArray) -> FloatArray:
        """(n, 4) what each coefficient of the bend of sensor 0 or 1 adds to what it shows."""
        return harmonics(shown_rad) - harmonics(self.zero_rad[sensor : sensor + 1])


def harmonics(shown_rad: FloatArray) -> FloatArray:
    """(n, 4) sin, cos, sin 2, cos 2 of the angle shown: what an eccentric or tilted magnet adds."""
    return np.column_stack(
        [np.sin(shown_rad), np.cos(shown_rad), np.sin(2 * shown_rad), np.cos(2 * shown_rad)]
    )


_ABSENT_STD_RAD = np.deg2rad(0.05)


def sensor_columns(model: RobotModel, joint: int) -> list[int]:
    """Return the log's columns of the two angle sensors of a joint (1 to 3)."""
    return [i for i, sensor in enumerate(model.angle_sensors) if sensor.joint == joint - 1]


def sensors_by_design(model: RobotModel, joint: int) -> JointSensors:
    """Build the calibration of a joint's sensors by design, before anything is measured.

    The zero points are those of the robot file, and may lie anywhere.
    """
    sensors = [model.angle_sensors[i] for i in sensor_columns(model, joint)]
    absent = all(sensor.absent for sensor in sensors)
    return JointSensors(
        joint,
        np.array([float(sensor.direction) for sensor in sensors]),
        np.array([sensor.zero_offset_rad for sensor in sensors]),
        # Uniform over a whole turn; of a joint that is not there, half a count.
        np.diag([_ABSENT_STD_RAD**2 if absent else np.pi**2 / 3.0] * 2),
        np.zeros((2, 4)),
        np.diag(np.repeat([sensor.nonlinearity_rad**2 for sensor in sensors], 4)),
        np.full(2, np.nan),
        None,
        None,
        absent,
    )


def joint_angles(
    sensor_angle_rad: FloatArray, joints: Sequence[JointSensors], model: RobotModel
) -> FloatArray:
    """(n, n_joints) of all angle sensors (n, sensors), rad.

    A joint without a calibrated zero counts from where the recording begins: every step begins with closed joints.
    """
    angles = []
    for sensors in joints:
        readings_rad = sensor_angle_rad[:, sensor_columns(model, sensors.joint)]
        # Each alone: without a zero one may wrap where the other does not, and their mean jumps by half a turn.
        angles.append(sensors.from_start(np.unwrap(sensors.each(readings_rad), axis=0)).mean(axis=1))
    return np.column_stack(angles)
