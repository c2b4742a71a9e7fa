"""From calibrated samples to what the robot did: joint angles, rates and attitudes of all bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.joint_sensors import sensor_columns
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.evaluation.motion.body_motion import BodyMotion, Rates, body_motion
from tfsat_host.evaluation.motion.fusion import Fused
from tfsat_host.evaluation.motion.integral import turned_from
from tfsat_host.evaluation.motion.joint_fit import SensedJoint
from tfsat_host.evaluation.motion.joints import JointMotion
from tfsat_host.evaluation.motion.lag import Lag
from tfsat_host.evaluation.motion.samples import GREATEST_GAP_S, Samples
from tfsat_host.evaluation.motion.sensor_fusion import SensorFusion, Solved
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Motion:
    """What the robot did, at n samples from just before the release to just before the landing.

    Attributes:
        samples: What it follows from.
        densities_rad_s_rthz: (4,) noise of each gyro.
        fusion: All sensors together.
        solved: What they agree on.
        joints: Of joints 1 to 3.
        bodies: Of bodies 1 to 4, from the release on.
    """

    samples: Samples
    densities_rad_s_rthz: FloatArray
    fusion: SensorFusion
    solved: Solved
    joints: tuple[JointMotion, ...]
    bodies: tuple[BodyMotion, ...]

    @property
    def t_s(self) -> FloatArray:
        """(n,) after the release."""
        return self.samples.t_s

    @property
    def angles_rad(self) -> FloatArray:
        """(n, 3) of the joints."""
        return np.column_stack([joint.angle_rad for joint in self.joints])

    @property
    def lag(self) -> Lag:
        """Of the gyros' low-pass; taken off all rates and angles here."""
        return self.solved.lag

    @property
    def fused(self) -> Fused:
        """Rates from all gyros together."""
        return self.solved.fused

    @property
    def variance(self) -> FloatArray:
        """(n, 4) of each axis of a gyro's sample."""
        return self.fusion.variance

    @property
    def contradicted(self) -> bool:
        """The sensors would have the gyros farther off than their calibration allows: none is corrected by another."""
        return self.solved.contradicted


def motion_of(
    samples: Samples, calibration: Calibration, model: RobotModel, densities: FloatArray, low_pass: LowPass
) -> Motion:
    """Joint angles, rates and attitudes.

    Args:
        samples: Of one drop.
        calibration: That they were calibrated with.
        model: Joints and bodies.
        densities: (4,) noise of each gyro, rad/s/sqrt(Hz).
        low_pass: Of the gyros.
    """
    sensed = tuple(
        SensedJoint.of(
            sensors,
            samples.sensor_angle_rad[:, sensor_columns(model, sensors.joint)],
            servo.start_rad,
            _turned_by_gyros(samples, model, sensors.joint - 1),
        )
        for sensors, servo in zip(calibration.joints, model.servos, strict=True)
    )
    fusion = SensorFusion.of(samples, sensed, calibration, model, densities, low_pass)
    solved = fusion.solved()
    left = fusion.smoothing_rad(solved.fused)
    joints = tuple(
        JointMotion.of(
            one, solved.angles_rad[:, j], solved.slow.angles[:, j], solved.slow.covariance, left[:, j]
        )
        for j, one in enumerate(sensed)
    )
    return Motion(samples, densities, fusion, solved, joints, _bodies(samples, solved, fusion.variance))


def _bodies(samples: Samples, solved: Solved, variance: FloatArray) -> tuple[BodyMotion, ...]:
    """Each by its own gyro, and where that did not answer by the others."""
    fused, slow = solved.fused, solved.slow
    bridge = fused.body_rates()
    found = []
    for b in range(variance.shape[1]):
        bridged = fused.bridged[:, b]
        apart = bridged[:, None, None]
        by_errors = np.where(apart, slow.bodies[:, b], slow.gyros[:, b])
        spread = fused.seen[:, b] @ fused.covariance @ fused.seen[:, b].swapaxes(1, 2)
        spread = np.where(apart, spread, variance[:, b, None, None] * np.eye(3))
        rate = np.where(bridged[:, None], bridge[:, b], solved.rates_rad_s[:, b])
        found.append(
            body_motion(
                samples.t_s, Rates(rate, by_errors, spread, bridged), slow.covariance, samples.rate_hz
            )
        )
    return tuple(found)


def _turned_by_gyros(samples: Samples, model: RobotModel, joint: int) -> FloatArray:
    """(n,) of one joint, by its own two gyros alone; NaN if one of them lacks more than it can be carried over."""
    outer, inner = int(model.joint_outer[joint]), int(model.joint_inner[joint])
    # What turns about the axis looks the same from both bodies.
    rate = (samples.rate_rad_s[:, outer] - samples.rate_rad_s[:, inner]) @ model.joint_axis[joint]
    known = np.isfinite(rate)
    if (
        not known.any()
        or np.diff(samples.t_s[known], prepend=samples.t_s[0], append=samples.t_s[-1]).max() > GREATEST_GAP_S
    ):
        return np.full_like(rate, np.nan)
    return turned_from(samples.t_s, np.interp(samples.t_s, samples.t_s[known], rate[known]))
