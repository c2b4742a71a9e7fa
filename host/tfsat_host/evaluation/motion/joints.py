"""One joint over the drop: its angle, what is uncertain about it, and what its two angle sensors say beside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.angles import wrapped
from tfsat_host.calibration.sensors.joint_sensors import JointSensors
from tfsat_host.evaluation.motion.joint_fit import SensedJoint

FloatArray = NDArray[np.float64]

UNSENSED_STD_RAD = np.deg2rad(6.0)
"""Of a start that no sensor tells: the paper's joint 1 hung 6 deg from where its servo should have held it."""
_SMOOTHED = 9


@dataclass(frozen=True, eq=False)
class SensorDisagreement:
    """One angle sensor beside the fused angle, over the whole fall.

    Attributes:
        sensor: 1 or 2 of the joint.
        mean_rad: Mean difference; NaN where it never answered.
        rms_rad: Root mean square of the difference.
        greatest_rad: Of the difference smoothed over 9 samples.
        expected_rad: Standard deviation of the mean difference by the calibration.
    """

    sensor: int
    mean_rad: float
    rms_rad: float
    greatest_rad: float
    expected_rad: float


@dataclass(frozen=True, eq=False)
class JointMotion:
    """One joint at n samples.

    Attributes:
        joint: 1 to 3.
        angle_rad: (n,).
        basis: (n, r) the angle by the slow errors.
        covariance: (r, r) of those.
        noise_rad: (2,) standard deviation of a sample of either sensor.
        smoothing_rad: (n,) what is left of that noise in the angle, where no gyro tells the joint's rate; else 0.
        sensors: What each sensor says beside the fused angle.
        sensed: Angle sensors have answered.
    """

    joint: int
    angle_rad: FloatArray
    basis: FloatArray
    covariance: FloatArray
    noise_rad: FloatArray
    smoothing_rad: FloatArray
    sensors: tuple[SensorDisagreement, ...]
    sensed: bool

    @classmethod
    def of(
        cls,
        sensed: SensedJoint,
        angle_rad: FloatArray,
        basis: FloatArray,
        covariance: FloatArray,
        smoothing_rad: FloatArray,
    ) -> JointMotion:
        """Of its angle (n,), what the slow errors do to it, and what noise is left in it."""
        disagreements = tuple(_disagreement(sensed, k, angle_rad) for k in range(2))
        joint = sensed.sensors.joint
        noise = sensed.noise_rad
        return cls(joint, angle_rad, basis, covariance, noise, smoothing_rad, disagreements, sensed.answered)

    def std_rad(self) -> FloatArray:
        """(n,) standard deviation of the angle."""
        variance = ((self.basis @ self.covariance) * self.basis).sum(axis=1) + self.smoothing_rad**2
        return np.asarray(np.sqrt(np.maximum(variance, 0.0)))

    def difference_std_rad(self, first: int, second: int) -> float:
        """Standard deviation of the angle's change between two samples."""
        change = self.basis[second] - self.basis[first]
        noise = self.smoothing_rad[first] ** 2 + self.smoothing_rad[second] ** 2
        return float(np.sqrt(change @ self.covariance @ change + noise))


def _disagreement(sensed: SensedJoint, k: int, angle_rad: FloatArray) -> SensorDisagreement:
    off = wrapped(sensed.sensors.each(sensed.shown_rad)[:, k] - angle_rad)
    off = off[np.isfinite(off)]
    if not len(off):
        return SensorDisagreement(k + 1, *[float("nan")] * 4)
    smooth = (
        np.convolve(off, np.full(_SMOOTHED, 1 / _SMOOTHED), mode="valid") if len(off) >= _SMOOTHED else off
    )
    return SensorDisagreement(
        k + 1,
        float(off.mean()),
        float(np.sqrt((off**2).mean())),
        float(np.abs(smooth).max()),
        _expected_rad(sensed.sensors, k),
    )


def _expected_rad(sensors: JointSensors, k: int) -> float:
    bend = sensors.bend_covariance[4 * k : 4 * k + 4, 4 * k : 4 * k + 4]
    return float(np.sqrt(sensors.zero_covariance[k, k] + np.trace(bend)))
