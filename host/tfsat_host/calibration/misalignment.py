"""Which way each gyro's axes point, from rotations about a joint (paper, sec. Calibrations)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.patterns import MotionPattern
from tfsat_host.calibration.recording import Recording
from tfsat_host.calibration.response import direction
from tfsat_host.errors import TfsatError
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

STILL_RATE_RAD_S = np.deg2rad(1.0)
"""A gyro whose readings scatter more than this is not still."""
LEAST_RMS_RATE_RAD_S = np.deg2rad(5.0)
"""A moved body must turn at least this fast, rms."""
MOST_HELD_FRACTION = 0.05
"""A held body may turn at most this fraction of the moved one's rms rate."""
MOST_LOST_FRACTION = 0.01
"""More lost samples than this, and the rest may not stand for the motion."""


class CalibrationError(TfsatError):
    """The recording does not support a calibration; nothing was kept."""


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
    """

    joint: int
    body: int
    axis: FloatArray
    nominal: FloatArray
    angle_deg: float
    std_deg: float
    rms_rate_deg_s: float
    bias_deg_s: FloatArray

    def cross_axis(self) -> tuple[float, float]:
        """Readings of the two transverse axes per reading of the joint's own, in x, y, z order."""
        main = int(np.argmax(np.abs(self.nominal)))
        others = [index for index in range(3) if index != main]
        first, second = (float(self.axis[index] / self.axis[main]) for index in others)
        return first, second


def gyro_bias(still: Recording) -> FloatArray:
    """(4, 3) mean rates in rad/s of a recording in which nothing moved.

    Raises:
        CalibrationError: samples or a gyro are missing, or something moved.
    """
    _check_complete(still, range(1, 5))
    scatter = still.rate_rad_s.std(axis=0).max(axis=1)
    for body, value in enumerate(scatter, 1):
        if value > STILL_RATE_RAD_S:
            raise CalibrationError(
                what=f"Body {body} was not still: its gyro scattered by {np.rad2deg(value):.2f} deg/s.",
                meaning="The bias would be wrong, and with it every angle.",
                next_step="Let the robot rest on the bench without touching it, and run this command again.",
            )
    bias: FloatArray = still.rate_rad_s.mean(axis=0)
    return bias


def estimate_axes(
    pattern: MotionPattern, motion: Recording, bias_rad_s: FloatArray, model: RobotModel
) -> list[AxisEstimate]:
    """The joint's axis in the sensor frame of each moved body.

    The direction is the total-least-squares line through the bias-free rates, its sign comes from the joint's angle
    sensors, and its uncertainty from how the parts of the recording scatter (`response.direction`).

    Args:
        pattern: What was moved and what was held.
        motion: The recording of several swings.
        bias_rad_s: (4, 3) from `gyro_bias`.
        model: For the nominal axis and mounting.

    Raises:
        CalibrationError: samples are missing, too little motion, or a held body moved.
    """
    _check_complete(motion, (*pattern.moved, *pattern.held))
    rates = motion.rate_rad_s - bias_rad_s
    rms = np.sqrt((rates**2).sum(axis=2).mean(axis=0))
    _check_excitation(pattern, rms)
    direction = _joint_direction(motion, pattern.joint, model)
    return [
        _estimate(pattern, body, rates[:, body - 1], rms[body - 1], bias_rad_s, direction, model)
        for body in pattern.moved
    ]


def _estimate(
    pattern: MotionPattern,
    body: int,
    rates: FloatArray,
    rms_rad_s: float,
    bias_rad_s: FloatArray,
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
        bias_deg_s=np.rad2deg(bias_rad_s[body - 1]),
    )


def _joint_direction(motion: Recording, joint: int, model: RobotModel) -> FloatArray:
    """(n,) rate of the joint angle from its first angle sensor, rough; only its sign over time matters."""
    index = next(i for i, sensor in enumerate(model.angle_sensors) if sensor.joint == joint - 1)
    unwrapped = np.unwrap(motion.sensor_angle_rad[:, index])
    rate: FloatArray = model.angle_sensors[index].direction * np.gradient(unwrapped, motion.t_s)
    return rate


def _check_complete(recording: Recording, bodies: range | tuple[int, ...]) -> None:
    if np.any(np.diff(recording.t_s) <= 0):
        raise CalibrationError(
            what="The logger's clock went backwards during the measurement: the logger restarted.",
            meaning="The samples do not belong together; nothing was kept.",
            next_step="Check the logger's supply and cable with tfsat-host status, and run this command again.",
        )
    if recording.samples_lost > MOST_LOST_FRACTION * (len(recording.t_s) + recording.samples_lost):
        raise CalibrationError(
            what=f"{recording.samples_lost} of {len(recording.t_s) + recording.samples_lost} samples "
            "never reached this computer.",
            meaning=f"More than {100 * MOST_LOST_FRACTION:g} % is missing: bias and axis would be doubtful.",
            next_step="Plug the logger in without a hub, close other programs, and run this command again.",
        )
    for body in bodies:
        missing = int((~recording.imu_valid[:, body - 1]).sum())
        if missing:
            raise CalibrationError(
                what=f"{missing} of {len(recording.t_s)} samples of the gyro on body {body} are invalid or clipped.",
                meaning="An axis fitted to the rest would be doubtful.",
                next_step="Check the gyro with tfsat-host status, swing slower than 500 deg/s, and run this again.",
            )


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
