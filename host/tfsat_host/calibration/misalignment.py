"""Which way each gyro's axes point, from rotations about a joint (paper, sec. Calibrations)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.bias import BiasEstimate
from tfsat_host.calibration.completeness import check_complete
from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.calibration.patterns import MotionPattern
from tfsat_host.calibration.recording import Recording
from tfsat_host.calibration.response import direction
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

LEAST_RMS_RATE_RAD_S = np.deg2rad(5.0)
"""A moved body must turn at least this fast, rms."""
MOST_HELD_FRACTION = 0.05
"""A held body may turn at most this fraction of the moved one's rms rate."""


@dataclass(frozen=True, eq=False)
class AxisEstimate:
    """A joint's axis as one gyro sees it.

    Attributes:
        joint: 1 to 3.
        body: 1 to 4, the body that carries the gyro.
        axis: (3,) unit vector in sensor axes, in the joint's positive direction.
        nominal: (3,) the same where the gyro is mounted as designed.
        angle_deg: Angle between the two.
        std_deg: Standard deviation of the axis's direction, per transverse direction.
        rms_rate_deg_s: Excitation, rms.
        bias_deg_s: (3,) mean reading while still, sensor axes.
        bias_std_deg_s: (3,) its standard deviation.
    """

    joint: int
    body: int
    axis: FloatArray
    nominal: FloatArray
    angle_deg: float
    std_deg: float
    rms_rate_deg_s: float
    bias_deg_s: FloatArray
    bias_std_deg_s: FloatArray

    def cross_axis(self) -> tuple[float, float]:
        """Readings of the two transverse axes per reading of the joint's own, in x, y, z order."""
        main = int(np.argmax(np.abs(self.nominal)))
        others = [index for index in range(3) if index != main]
        first, second = (float(self.axis[index] / self.axis[main]) for index in others)
        return first, second


def estimate_axes(
    pattern: MotionPattern, motion: Recording, biases: Sequence[BiasEstimate], model: RobotModel
) -> list[AxisEstimate]:
    """The joint's axis in the sensor frame of each moved body.

    The direction is the total-least-squares line through the bias-free rates, its sign comes from the joint's angle
    sensors, and its uncertainty from how the parts of the recording scatter (`response.direction`).

    Args:
        pattern: What was moved and what was held.
        motion: The recording of several swings.
        biases: Of bodies 1 to 4, from `estimate_biases`.
        model: For the nominal axis and mounting.

    Raises:
        CalibrationError: samples are missing, too little motion, or a held body moved.
    """
    check_complete(motion, (*pattern.moved, *pattern.held))
    rates = motion.rate_rad_s - np.array([bias.bias_rad_s for bias in biases])
    rms = np.sqrt((rates**2).sum(axis=2).mean(axis=0))
    _check_excitation(pattern, rms)
    turning = _joint_direction(motion, pattern.joint, model)
    return [
        _estimate(pattern, body, rates[:, body - 1], rms[body - 1], biases[body - 1], turning, model)
        for body in pattern.moved
    ]


def _estimate(
    pattern: MotionPattern,
    body: int,
    rates: FloatArray,
    rms_rad_s: float,
    bias: BiasEstimate,
    joint_rate: FloatArray,
    model: RobotModel,
) -> AxisEstimate:
    # Body i turns with the joint about +axis, body i + 1 against it, whichever is held.
    sense = 1.0 if body <= pattern.joint else -1.0
    joint_axis = model.joint_axis[pattern.joint - 1]
    seen = direction(rates, joint_axis, sense * joint_rate)
    axis = seen.reading
    nominal = model.imus[body - 1].sensor_to_body.T @ joint_axis
    return AxisEstimate(
        joint=pattern.joint,
        body=body,
        axis=axis,
        nominal=nominal,
        angle_deg=float(np.rad2deg(np.arctan2(np.linalg.norm(np.cross(axis, nominal)), axis @ nominal))),
        std_deg=float(np.rad2deg(np.sqrt(np.trace(seen.covariance) / 2.0))),
        rms_rate_deg_s=float(np.rad2deg(rms_rad_s)),
        bias_deg_s=np.rad2deg(bias.bias_rad_s),
        bias_std_deg_s=np.rad2deg(np.sqrt(np.diag(bias.covariance))),
    )


def _joint_direction(motion: Recording, joint: int, model: RobotModel) -> FloatArray:
    """(n,) rate of the joint angle from its first angle sensor, rough; only its sign over time matters."""
    index = next(i for i, sensor in enumerate(model.angle_sensors) if sensor.joint == joint - 1)
    unwrapped = np.unwrap(motion.sensor_angle_rad[:, index])
    rate: FloatArray = model.angle_sensors[index].direction * np.gradient(unwrapped, motion.t_s)
    return rate


def _check_excitation(pattern: MotionPattern, rms_rad_s: FloatArray) -> None:
    for body in pattern.moved:
        if rms_rad_s[body - 1] < LEAST_RMS_RATE_RAD_S:
            raise CalibrationError(
                what=f"Body {body} turned at {np.rad2deg(rms_rad_s[body - 1]):.1f} deg/s rms; "
                f"at least {np.rad2deg(LEAST_RMS_RATE_RAD_S):.0f} are needed.",
                meaning="The axis could not be told from noise.",
                next_step=f"Swing body {body} about joint {pattern.joint} wider and faster, and run this again.",
            )
    limit = MOST_HELD_FRACTION * min(rms_rad_s[body - 1] for body in pattern.moved)
    for body in pattern.held:
        if rms_rad_s[body - 1] > limit:
            raise CalibrationError(
                what=f"Body {body} was to be held, but turned at {np.rad2deg(rms_rad_s[body - 1]):.1f} deg/s rms.",
                meaning="The moved bodies did not turn about the joint alone, so the axis would be wrong.",
                next_step=f"Hold bodies {', '.join(map(str, pattern.held))} firmly, and run this again.",
            )
