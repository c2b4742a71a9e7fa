"""The consistency vector of one drop, from its motion and the rest before it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.evaluation.checks.consistency import Consistency, Readings
from tfsat_host.evaluation.checks.rest import Rest
from tfsat_host.evaluation.motion.lag import sheet_lag
from tfsat_host.evaluation.motion.motion import Motion
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]


def consistency_of(
    motion: Motion, rest: Rest | None, dlpf_cfg: int, calibration: Calibration, model: RobotModel
) -> Consistency:
    """Of one drop.

    Args:
        motion: Its samples. Its lag is not used: a sensor that is wrong spoils that first.
        rest: Before the release.
        dlpf_cfg: As the header has it.
        calibration: That the samples were calibrated with.
        model: Joints and sensors.
    """
    samples, lag = motion.samples, sheet_lag(dlpf_cfg)
    late = np.stack(
        [
            gyro.readings(samples.rate_rad_s[:, b]) + gyro.bias_rad_s
            for b, gyro in enumerate(calibration.gyros)
        ],
        axis=1,
    )
    late = _bridged(samples.t_s, late)
    fall = samples.fall
    rested = np.full((4, 3), np.nan) if rest is None else rest.reading_rad_s
    return Consistency(
        samples.t_s[fall],
        late[fall],
        Readings(lag.removed(samples.t_s, late)[fall], samples.sensor_angle_rad[fall], rested),
        samples.answered[fall],
        motion.variance[fall],
        np.nan_to_num(samples.rate_jacobian[fall]),
        samples.parameter_covariance,
        rest,
        dlpf_cfg,
        calibration,
        model,
    )


def _bridged(t_s: FloatArray, readings: FloatArray) -> FloatArray:
    """Straight lines over what did not answer; zero for a gyro that never did."""
    filled = readings.copy()
    for body, axis in np.ndindex(readings.shape[1:]):
        column = readings[:, body, axis]
        known = np.isfinite(column)
        filled[:, body, axis] = np.interp(t_s, t_s[known], column[known]) if known.any() else 0.0
    return filled
