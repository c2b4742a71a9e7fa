"""From raw counts to body frames and SI units, with what the calibration's uncertainty makes of every number."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from tfsat_host.arrays import FloatArray, describe_fields
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.gyro import BIAS, SCALE, SHARED, GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import sensor_columns
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.protocol.limits import JOINT_COUNT
from tfsat_host.robot import RobotModel
from tfsat_host.units import STANDARD_GRAVITY_M_S2

NOISE_STD_RAD_S = np.deg2rad(0.05)
"""Of a sample of a gyro that never rested (PS-MPU-6000A rev. 3.4, section 6.1, total RMS noise)."""
BIAS_DRIFT_STD_RAD_S_C = np.deg2rad(20.0 / 62.5) / 3.0**0.5
"""For each degree: within 20 deg/s from 25 to -40 or +85 deg C (the same table), evenly spread."""
WEIGHT_STD_RAD_S = np.deg2rad(0.1)
"""Of what its own weight makes a gyro show: 0.1 deg/s for each g (the same table, linear acceleration sensitivity,
static). On the bench and hanging on the crane it is part of the bias; in the fall it is gone."""
IN_RUN_STD_RAD_S = np.deg2rad(0.005)
"""How far a bias wanders from bench to drop: assumed, for the data sheet is silent."""
BENT_STD = 0.002 / 3.0**0.5
"""Of a scale factor at the rates of a fall against that at the rates of its calibration: it bends by 0.2 % (the same
table, nonlinearity)."""
TEMPERATURE_SAMPLES = 256
"""The die's temperature is the mean over so many."""
ACCEL_SCALE_STD = 0.03 / 3.0**0.5
"""Of an accelerometer, which is not calibrated: within 3 % (PS-MPU-6000A rev. 3.4, section 6.2)."""
ACCEL_OFFSET_STD_M_S2 = np.array([0.05, 0.05, 0.08]) / 3.0**0.5 * STANDARD_GRAVITY_M_S2
"""Its zero-g output: within 50 mg, 80 mg for z (the same table)."""


@dataclass(frozen=True, eq=False)
class CalibratedSamples:
    """n samples in body axes; NaN where a sensor was invalid.

    The errors of a gyro's parameters are the same at all samples: integrate `rate_jacobian`, then take its product with
    `parameter_covariance`; `rate_covariance` is that product sample by sample, noise included.

    Attributes:
        t_s: (n,) the logger's clock.
        rate_rad_s: (n, 4, 3) body axes.
        rate_covariance: (n, 4, 3, 3) of each sample, parameters and noise, (rad/s)^2.
        rate_jacobian: (n, 4, 3, 12) by bias, rotation vector, scale and skew of each gyro.
        parameter_covariance: (4, 12, 12), at the temperatures of these samples.
        shared: (4, 12, SHARED) see `GyroCalibration`.
        specific_force_m_s2: (n, 4, 3) at the sensor, body axes.
        specific_force_std_m_s2: (n, 4, 3) by the data sheet, for accelerometers are not calibrated.
        joint_angle_rad: (n, 3) by the absolute sensors.
        joint_angle_std_rad: (n, 3).
        clipped: (n, 4) a value of the IMU is at its full scale: a lower bound.
    """

    t_s: FloatArray
    rate_rad_s: FloatArray
    rate_covariance: FloatArray
    rate_jacobian: FloatArray
    parameter_covariance: FloatArray
    shared: FloatArray
    specific_force_m_s2: FloatArray
    specific_force_std_m_s2: FloatArray
    joint_angle_rad: FloatArray
    joint_angle_std_rad: FloatArray
    clipped: NDArray[np.bool_]

    __repr__ = describe_fields


def apply_calibration(counts: Counts, calibration: Calibration, model: RobotModel) -> CalibratedSamples:
    """Raw counts in body axes and SI units.

    What was never measured keeps its design and the uncertainty of that: a bias of 0 +- 12 deg/s, a scale of
    1 +- 1.7 %.

    Args:
        counts: Of the sensors that the calibration is of; see `Calibration.subject`.
        calibration: Read by `certificate.file.read_calibration`.
        model: For the sensors' places in the log.
    """
    samples = SensorSamples.from_counts(counts)
    rates, covariances, jacobians, parameters, forces, deviations = [], [], [], [], [], []
    for gyro in calibration.gyros:
        # NaN where the IMU did not answer, so that no integral passes over it unnoticed.
        readings = np.where(
            counts.imu_valid[:, gyro.body - 1, None], samples.rate_rad_s[:, gyro.body - 1], np.nan
        )
        jacobian = gyro.jacobian(readings)
        covariance = _in_use(gyro, samples.temperature_c[:, gyro.body - 1])
        # The data sheet's noise for a gyro that never rested; over the scale it is noise of a rate.
        noise = np.where(np.isfinite(gyro.noise_rad_s), gyro.noise_rad_s, NOISE_STD_RAD_S) / gyro.scale
        rates.append(gyro.body_rates(readings))
        jacobians.append(jacobian)
        parameters.append(covariance)
        # (n, 3, 3): J C Jᵀ of the parameters, plus white noise in body axes.
        covariances.append(
            jacobian @ covariance @ jacobian.transpose(0, 2, 1)
            + gyro.rotation @ np.diag(noise**2) @ gyro.rotation.T
        )
        force, deviation = _forces(samples.accel_m_s2[:, gyro.body - 1], gyro.rotation)
        answered = counts.imu_valid[:, gyro.body - 1, None]
        forces.append(np.where(answered, force, np.nan))
        deviations.append(np.where(answered, deviation, np.nan))
    angles, angle_stds = _joint_angles(counts, samples, calibration, model)
    return CalibratedSamples(
        samples.t_s,
        np.stack(rates, axis=1),
        np.stack(covariances, axis=1),
        np.stack(jacobians, axis=1),
        np.array(parameters),
        np.array([gyro.shared for gyro in calibration.gyros]),
        np.stack(forces, axis=1),
        np.stack(deviations, axis=1),
        angles,
        angle_stds,
        counts.clipped,
    )


def weightless(parameter_covariance: FloatArray) -> FloatArray:
    """(..., 12, 12) of gyros that fall, by that of gyros that stood or hung when their biases were taken."""
    fallen = parameter_covariance.copy()
    # Gravity's part of the bias is gone in the fall, and the bias has wandered since the bench.
    fallen[..., BIAS, BIAS] += (WEIGHT_STD_RAD_S**2 + IN_RUN_STD_RAD_S**2) * np.eye(3)
    # The strokes are faster than the motions of the calibration.
    fallen[..., SCALE, SCALE] += BENT_STD**2 * np.eye(3)
    return fallen


def split_shared(
    parameter_covariance: FloatArray, shared: FloatArray, *, exact_axes: bool = False
) -> tuple[FloatArray, FloatArray]:
    """(48, 6) what all gyros' parameters are off by the joints' tilts, and (48, 48) the covariance of the rest.

    Args:
        parameter_covariance: (4, 12, 12) of each gyro.
        shared: (4, 12, SHARED) see `GyroCalibration`.
        exact_axes: The joints' axes are taken as exact: what they did to the calibration is an error like any other.
    """
    own = parameter_covariance - shared @ shared.swapaxes(1, 2)
    all_shared, joints = shared.reshape(-1, SHARED), 2 * JOINT_COUNT
    by_tilts, by_others = np.split(all_shared, [joints], axis=1)
    covariance = block_diag(*own) + by_others @ by_others.T
    if exact_axes:
        return np.zeros_like(by_tilts), covariance + by_tilts @ by_tilts.T
    return by_tilts, covariance


def _in_use(gyro: GyroCalibration, temperature_c: FloatArray) -> FloatArray:
    """(12, 12) covariance of the parameters where the die is warmer or colder than when its bias was taken."""
    covariance = gyro.covariance.copy()
    if np.isfinite(gyro.temperature_c):
        # Over seconds, for one reading's noise is not the die's temperature.
        parts = np.array_split(temperature_c, max(1, len(temperature_c) // TEMPERATURE_SAMPLES))
        # The largest difference, warmer or colder: one covariance has to hold for all samples.
        warmer_c = max(abs(float(np.mean(part)) - gyro.temperature_c) for part in parts)
        covariance[:3, :3] += (BIAS_DRIFT_STD_RAD_S_C * warmer_c) ** 2 * np.eye(3)
    return covariance


def _forces(accel_m_s2: FloatArray, rotation: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n, 3) in body axes, and their standard deviations."""
    # Scale and zero-g errors are independent; M squared elementwise carries the variances over.
    variance = (ACCEL_SCALE_STD * accel_m_s2) ** 2 + ACCEL_OFFSET_STD_M_S2**2
    return accel_m_s2 @ rotation.T, np.sqrt(variance @ (rotation.T**2))


def _joint_angles(
    counts: Counts, samples: SensorSamples, calibration: Calibration, model: RobotModel
) -> tuple[FloatArray, FloatArray]:
    angles, stds = [], []
    for sensors in calibration.joints:
        columns = sensor_columns(model, sensors.joint)
        # The mean of both sensors, or none: one alone has another error than the certificate states.
        answered = counts.angle_valid[:, columns].all(axis=1)
        readings_rad = samples.sensor_angle_rad[:, columns]
        angles.append(np.where(answered, sensors.angle(readings_rad), np.nan))
        stds.append(np.where(answered, np.sqrt(sensors.angle_variance(readings_rad)), np.nan))
    return np.column_stack(angles), np.column_stack(stds)
