"""What a gyro reads while nothing turns (paper, section "Calibrations": trimmed minutes before the drop)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.statistics import mean_and_covariance
from tfsat_host.calibration.steps.recording import Recording, check_complete
from tfsat_host.units import STANDARD_GRAVITY_M_S2

STILL_RATE_RAD_S = np.deg2rad(1.0)
"""A gyro whose readings scatter more than this is not still."""
DRIFT_RAD_S = np.deg2rad(0.1)
"""A body whose rate changes by more from the first half to the second turns slowly, or warms up fast."""
SHAKE_G = 0.05
"""An accelerometer that scatters more is carried or shaken."""
GRAVITY_G = (0.85, 1.15)
"""What a resting accelerometer reads: 1 g, with an MPU-6050's offset and scale (PS-MPU-6000A rev. 3.4,
section 6.2)."""
TILT_RAD = np.deg2rad(0.2)
"""Gravity may turn in a body's axes by so much from the first third to the last: more, and the body turns slowly."""
_MORE_THAN_NOISE = 3.0
"""Standard deviations. The difference of two halves has twice that of the whole's mean."""
_AGAIN = "Let the robot rest on the bench without touching it, and run this command again."


@dataclass(frozen=True, eq=False)
class BiasEstimate:
    """The zero-rate output of one gyro.

    Attributes:
        body: 1 to 4.
        bias_rad_s: (3,) sensor axes.
        covariance: (3, 3) of it, (rad/s)^2; noise that repeats itself through the low-pass is accounted for.
        noise_rad_s: (3,) standard deviation of one sample.
        temperature_c: Mean of the die, for the bias moves with it.
    """

    body: int
    bias_rad_s: FloatArray
    covariance: FloatArray
    noise_rad_s: FloatArray
    temperature_c: float


def estimate_biases(still: Recording) -> tuple[BiasEstimate, ...]:
    """The biases of all four gyros from a recording in which nothing moved.

    Raises:
        CalibrationError: samples or a gyro are missing, or a body moved; says which, and how.
    """
    check_complete(still, range(1, 5))
    return tuple(_estimate(still, body) for body in range(1, 5))


def with_bias(gyro: GyroCalibration, bias: BiasEstimate, taken: datetime) -> GyroCalibration:
    """The same gyro with a new bias."""
    covariance = gyro.covariance.copy()
    covariance[:3, :3] = bias.covariance
    return replace(
        gyro,
        bias_rad_s=bias.bias_rad_s,
        covariance=covariance,
        noise_rad_s=bias.noise_rad_s,
        temperature_c=bias.temperature_c,
        bias_taken=taken,
    )


def _estimate(still: Recording, body: int) -> BiasEstimate:
    rates = still.rate_rad_s[:, body - 1]
    _check_rates(rates, body)
    _check_forces(still.accel_m_s2[:, body - 1] / STANDARD_GRAVITY_M_S2, body)
    bias, covariance = mean_and_covariance(rates)
    covariance = covariance + np.diag(_wandered(rates, covariance) ** 2)
    return BiasEstimate(
        body,
        bias,
        covariance,
        rates.std(axis=0),
        float(still.temperature_c[:, body - 1].mean()),
    )


def _wandered(rates: FloatArray, covariance: FloatArray) -> FloatArray:
    """(3,) how far the bias has gone from its mean by the end of the rest, where that is more than noise."""
    first, second = (half.mean(axis=0) for half in np.array_split(rates, 2))
    # From one half's middle to the other's it goes as far as from the mean to the end.
    apart = np.abs(second - first)
    return np.where(apart > _MORE_THAN_NOISE * 2.0 * np.sqrt(np.diag(covariance)), apart, 0.0)


def _check_rates(rates: FloatArray, body: int) -> None:
    if not np.ptp(rates, axis=0).any():
        raise CalibrationError(
            what=f"The gyro on body {body} gave the very same value in all {len(rates)} samples.",
            meaning="A gyro always has noise: this one measures nothing.",
            next_step="Switch the logger off and on; replace the IMU if tfsat-host monitor shows the same again.",
        )
    scatter = float(rates.std(axis=0).max())
    if scatter > STILL_RATE_RAD_S:
        raise CalibrationError(
            what=f"Body {body} was not still: its gyro scattered by {np.rad2deg(scatter):.2f} deg/s.",
            meaning="The bias would be wrong, and with it every angle.",
            next_step=_AGAIN,
        )
    first, second = (half.mean(axis=0) for half in np.array_split(rates, 2))
    drift = float(np.abs(second - first).max())
    if drift > DRIFT_RAD_S:
        raise CalibrationError(
            what=f"The gyro on body {body} drifted by {np.rad2deg(drift):.2f} deg/s while it was read.",
            meaning="The body turned slowly, or the board is still warming up: the bias would not hold.",
            next_step="Wait some minutes with the power on and the robot at rest, and run this command again.",
        )


def _check_forces(forces_g: FloatArray, body: int) -> None:
    shake = float(forces_g.std(axis=0).max())
    if shake > SHAKE_G:
        raise CalibrationError(
            what=f"Body {body} was shaken: its accelerometer scattered by {shake:.2f} g.",
            meaning="The bias would be wrong, and with it every angle.",
            next_step=_AGAIN,
        )
    first, _, last = (third.mean(axis=0) for third in np.array_split(forces_g, 3))
    tilt = float(np.arctan2(np.linalg.norm(np.cross(first, last)), first @ last))
    if tilt > TILT_RAD:
        raise CalibrationError(
            what=f"Body {body} was tilted by {np.rad2deg(tilt):.1f} deg while its gyro was read.",
            meaning="What it turned would be taken for bias.",
            next_step=_AGAIN,
        )
    size = float(np.linalg.norm(forces_g.mean(axis=0)))
    if not GRAVITY_G[0] <= size <= GRAVITY_G[1]:
        raise CalibrationError(
            what=f"The accelerometer on body {body} reads {size:.2f} g at rest, not 1 g.",
            meaning="The body does not rest, or its IMU is broken; its gyro is not to be trusted.",
            next_step="Check the IMU with tfsat-host monitor; replace it if it stays so, and run this "
            "command again.",
        )
