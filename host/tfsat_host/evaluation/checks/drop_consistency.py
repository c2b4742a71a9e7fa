"""The consistency vector of one drop, from its motion and the rest before it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.evaluation.checks.consistency import Consistency, Readings
from tfsat_host.evaluation.checks.hanging import Hanging
from tfsat_host.evaluation.motion.lag import Lag, sheet_lag
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]


def consistency_of(
    motion: Motion, rest: Hanging | None, low_pass: LowPass, calibration: Calibration, model: RobotModel
) -> Consistency:
    """Of one drop.

    Args:
        motion: Its samples. Its lag is not used: a sensor that is wrong spoils that first.
        rest: Before the release.
        low_pass: As the header has it.
        calibration: That the samples were calibrated with.
        model: Joints and sensors.
    """
    samples, lag = motion.samples, sheet_lag(low_pass)
    late = np.stack([_readings(motion, lag, b, gyro) for b, gyro in enumerate(calibration.gyros)], axis=1)
    fall = samples.fall
    rested = np.full((4, 3), np.nan) if rest is None else rest.reading_rad_s
    return Consistency(
        samples.t_s[fall],
        late[fall],
        Readings(lag.removed(samples.t_s, late)[fall], samples.sensor_angle_rad[fall], rested),
        samples.answered[fall],
        motion.variance[fall],
        np.nan_to_num(samples.rate_jacobian[fall]),
        samples.hanging_covariance,
        samples.parameter_covariance - samples.hanging_covariance,
        rest,
        low_pass,
        calibration,
        model,
    )


def _readings(motion: Motion, lag: Lag, body: int, gyro: GyroCalibration) -> FloatArray:
    """(n, 3) of one gyro, sensor axes; where it did not answer what the others would have had it show.

    A straight line would miss a stroke that begins or ends in the hole, and blame a sensor for it.
    """
    own = motion.samples.rate_rad_s[:, body]
    others = lag.applied(motion.t_s, motion.fused.body_rates()[:, body])
    return np.asarray(gyro.readings(np.where(np.isfinite(own), own, others)) + gyro.bias_rad_s)
