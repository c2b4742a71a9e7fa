"""What a joint's angle sensors show while the holding attachment keeps it at zero (paper, fig. jattach)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, sensor_columns
from tfsat_host.calibration.statistics import mean_and_covariance
from tfsat_host.calibration.steps.sensor_samples import SensorSamples, check_answers
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.robot import RobotModel

MAX_MOTION_RAD = np.deg2rad(0.5)
"""A sensor that scatters or drifts by more is not held."""
MAX_DISAGREEMENT_RAD = np.deg2rad(2.0)
"""Between two sensors of a joint, from one calibration to the next: more, and one has slipped on its axis."""


@dataclass(frozen=True, eq=False)
class ZeroEstimate:
    """The zero points of a joint's two sensors.

    Attributes:
        zero_rad: (2,) circular means, within half a turn of zero.
        covariance: (2, 2): noise by batch means, and what is left of the steps of the converter.
        noise_rad: (2,) standard deviation of one sample.
    """

    zero_rad: FloatArray
    covariance: FloatArray
    noise_rad: FloatArray


def estimate_zero(
    samples: SensorSamples, valid: NDArray[np.bool_], before: JointSensors, model: RobotModel
) -> ZeroEstimate:
    """Estimate the zero points of one joint.

    Args:
        samples: A recording in which the attachment was on.
        valid: (n, 6) samples at which an angle sensor answered.
        before: Previous calibration; if its zero was measured, the two sensors must agree by it.
        model: For the sensors' places in the log.

    Raises:
        CalibrationError: a sensor is silent, moves, or has slipped against the other.
    """
    columns = sensor_columns(model, before.joint)
    check_answers(valid[:, columns], before.joint, most_silent=0.01)
    readings_rad = samples.sensor_angle_rad[:, columns]
    centre = np.angle(np.exp(1j * readings_rad).mean(axis=0))
    # About its circular mean a sensor's angle has no wrap: a mean of what is left is a mean.
    deviations = wrap_angle(readings_rad - centre)
    _check_still(deviations, before.joint)
    mean, covariance = mean_and_covariance(deviations)
    noise = deviations.std(axis=0)
    # Batch means do not show the offset that quantization leaves in all of them: add it.
    steps = _step_deviation(noise, samples.angle_step_rad)
    zero = wrap_angle(centre + mean)
    # By the old zeros the new ones should give one joint angle: two mean that a sensor has slipped.
    by_each = before.each(zero[None, :])[0]
    if before.zero_recorded_at is not None:
        _check_slip(by_each, before.joint)
    return ZeroEstimate(zero, covariance + np.diag(steps**2), noise)


def with_zero(sensors: JointSensors, zero: ZeroEstimate, recorded_at: datetime) -> JointSensors:
    """Return the sensors' calibration with a new zero."""
    return replace(
        sensors,
        zero_rad=zero.zero_rad,
        zero_covariance=zero.covariance,
        noise_rad=zero.noise_rad,
        zero_recorded_at=recorded_at,
    )


def _step_deviation(noise_rad: FloatArray, step_rad: float) -> FloatArray:
    """Compute the standard deviation of a mean due to the converter's quantization.

    Noise of a step's size averages it out; without noise it remains. It is the first harmonic of the
    quantization error, which normal noise damps (Gray and Neuhoff 1998, sec. III).
    """
    damped = np.exp(-2.0 * (np.pi * noise_rad / step_rad) ** 2)
    return np.asarray(step_rad / (np.pi * np.sqrt(2.0)) * damped)


def _check_still(left_rad: FloatArray, joint: int) -> None:
    # Scatter shows shaking; the means of thirds show a slow drift below it.
    thirds = [part.mean(axis=0) for part in np.array_split(left_rad, 3)]
    motion = max(float(left_rad.std(axis=0).max()), float(np.ptp(thirds, axis=0).max()))
    if motion > MAX_MOTION_RAD:
        raise CalibrationError(
            what=f"Joint {joint} moved by {np.rad2deg(motion):.2f} deg while its zero was read.",
            meaning="The attachment does not hold it; a zero taken now would be wrong, and every joint angle with it.",
            next_step="Put the attachment on and screw it down, and run this command again.",
        )


def _check_slip(by_each_rad: FloatArray, joint: int) -> None:
    apart_rad = abs(float(wrap_angle(by_each_rad[:1] - by_each_rad[1:])[0]))
    if apart_rad > MAX_DISAGREEMENT_RAD:
        first, second = np.rad2deg(by_each_rad)
        raise CalibrationError(
            what=f"The two sensors of joint {joint} disagree by {np.rad2deg(apart_rad):.1f} deg: by the zero points of "
            f"the last calibration they stand at {first:+.1f} and {second:+.1f} deg.",
            meaning="One of them has slipped on the joint's axis since, and may slip again in the drop.",
            next_step=Advice(
                "Fasten the one that is farther from 0, then take its zero with ",
                NextStep("calibrate zero", ("--joint", str(joint), "--anew")),
            ),
        )
