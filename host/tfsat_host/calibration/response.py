"""How a gyro answers to a rotation about an axis of its body that is known: a joint's, or one turned by hand.

A gyro with the response S (scale factors and skews) that is mounted by the rotation M (from sensor to body axes) reads
S (M^T a) for unit rate about the body axis a. This vector, measured about two or three axes, is all that `misalignment`
needs. Its direction comes from every sample of some swings; its length needs the angle that was turned, from rest to
rest, because the sensor's low-pass shortens and delays whatever swings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime

import numpy as np
from scipy.integrate import cumulative_trapezoid

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.sensors.gyro import MOUNTING, GyroCalibration
from tfsat_host.calibration.statistics import student_t_factor
from tfsat_host.calibration.steps.sensor_samples import TURN_SHARE, SensorSamples, find_rests
from tfsat_host.calibration.steps.step import AXES, Step
from tfsat_host.calibration.steps.step_motion import Motion
from tfsat_host.protocol.limits import JOINT_COUNT

TILT_STD_RAD = np.deg2rad(0.2)
"""How far a body's axis may be from the one about which it is turned on a table, about each of two axes: the same for
all gyros (`misalignment`)."""
PLACING_STD_RAD = np.deg2rad(0.1)
"""How straight a person lays an edge of 100 mm on: to 0.2 mm."""
ANGLE_TOLERANCE = 0.1
"""A turn that is off by more than this share (gyros are wrong by 0.03) was another one than the screen says."""
# Rests: the weight of a usual placing error against the scatter of the rests at hand.
EXPERIENCE = 4
_BATCHES = 10
_NEVER = datetime.min.replace(tzinfo=UTC)
# Six rests against three unknowns leave three degrees of freedom for the scatter.
_MIN_SWEEPS = 5


@dataclass(frozen=True, eq=False)
class Response:
    """The reading of one gyro for unit rate about a known axis.

    Attributes:
        axis_body: (3,) unit vector in body axes; the rotation is positive about it.
        reading: (3,) in sensor axes; of length 1 where the length was not measured.
        covariance: (3, 3) of the reading; without `has_length` across it alone.
        has_length: Whether the length is measured, too.
        tilted_by: Which pair of the numbers in `gyro.SHARED` tilts the axis: 0 to 2 a joint's, 3 to 5 a turn's; None:
            none.
        recorded_at: When it was recorded.
        fresh: It was recorded after the last landing.
    """

    axis_body: FloatArray
    reading: FloatArray
    covariance: FloatArray
    has_length: bool
    tilted_by: int | None = None
    recorded_at: datetime = _NEVER
    fresh: bool = True

    @property
    def length(self) -> float:
        """Of the reading."""
        return float(np.linalg.norm(self.reading))


def direction(rate_rad_s: FloatArray, axis_body: FloatArray, along_rad_s: FloatArray) -> Response:
    """Fit the direction of a gyro's response, without its length, from swings.

    The first right singular vector of the rates is the line nearest to them by total least squares. Across it
    lie noise and the sway of the held body, both correlated in time: the scatter of the directions of a tenth
    of the motion each gives the covariance. A tenth of the samples would not do: in one in which the body
    rests, before or after it is swung, the direction is arbitrary.

    Args:
        rate_rad_s: (n, 3) rates in sensor axes, free of bias.
        axis_body: (3,) unit vector, body axes.
        along_rad_s: (n,) rough rate about it by another sensor; only its sign is used.
    """
    axis = main_line(rate_rad_s)
    # A singular vector has no sign of its own; where the other sensor tells none, keep it.
    axis *= np.sign((rate_rad_s @ axis) @ along_rad_s) or 1.0
    # Cut into parts of equal motion, by sum of squares, not into parts of equal time.
    cumulative_squares = np.cumsum((rate_rad_s**2).sum(axis=1))
    ends = np.searchsorted(cumulative_squares, cumulative_squares[-1] * np.arange(1, _BATCHES) / _BATCHES)
    lines = np.array([main_line(part) for part in np.split(rate_rad_s, ends) if len(part)])
    # Align the signs of the parts before taking their scatter.
    lines *= np.sign(lines @ axis)[:, None]
    # Covariance of the mean of the parts, widened as few numbers demand.
    covariance = student_t_factor(_BATCHES - 1) * np.cov(lines, rowvar=False) / _BATCHES
    return Response(axis_body, axis, across(axis) @ covariance @ across(axis), False)


def main_line(rates_rad_s: FloatArray) -> FloatArray:
    """(3,) the direction in which there is most of some rates (n, 3): their first right singular vector."""
    # Eigenvalues ascend: the last vector of the (3, 3) Gram matrix is that singular vector.
    return np.asarray(np.linalg.eigh(rates_rad_s.T @ rates_rad_s)[1][:, -1])


def across(axis: FloatArray) -> FloatArray:
    """(3, 3) that takes off what lies along a unit vector."""
    return np.eye(3) - np.outer(axis, axis)


def with_length(response: Response, length: float, std: float) -> Response:
    """Scale the response to its measured length and add the length's standard deviation."""
    axis = response.reading / response.length
    covariance = length**2 * response.covariance + std**2 * np.outer(axis, axis)
    return replace(response, reading=length * axis, covariance=covariance, has_length=True)


def without_length(response: Response) -> Response:
    """Reduce the response to its direction, a unit vector."""
    axis = response.reading / response.length
    covariance = across(axis) @ response.covariance @ across(axis) / response.length**2
    return replace(response, reading=axis, covariance=covariance, has_length=False)


def rest_means(values: FloatArray, rests: Sequence[slice]) -> FloatArray:
    """(k, ...) means of (n, ...) over each of k rests."""
    return np.array([values[rest].mean(axis=0) for rest in rests])


def length_between_rests(
    t_s: FloatArray,
    along_rad_s: FloatArray,
    rests: list[slice],
    angles_rad: FloatArray,
    expected_rad: float = 0.0,
) -> tuple[float, float]:
    """Fit the integral of a rate per radian turned, from rest to rest, and its standard deviation.

    Each sweep lies between two rests. The remaining bias is fitted, too. An error at one rest, such as an
    edge that was not laid on quite straight, is taken as independent of the other rests.

    Args:
        t_s: (n,) times.
        along_rad_s: (n,) the gyro's rate along its own direction, bias taken off.
        rests: k + 1 stretches in which nothing moved, in order of time.
        angles_rad: (k + 1,) known angle in each rest.
        expected_rad: Standard deviation of an angle by experience, weighted as EXPERIENCE rests, because the
            scatter of a few rests may be small by chance. 0: none.

    Raises:
        ValueError: there are fewer than five sweeps: their scatter would say nothing.
    """
    if len(rests) < 6:
        raise ValueError(f"{len(rests) - 1} sweeps are too few: five at least")
    # A low-pass shortens swings, but keeps integrals between rests.
    means = rest_means(cumulative_trapezoid(along_rad_s, t_s, initial=0), rests)
    times = rest_means(t_s, rests)
    # length * angle + bias left * time + constant; centred times decorrelate the last two.
    columns = np.column_stack([angles_rad, times - times.mean(), np.ones(len(rests))])
    solution, *_ = np.linalg.lstsq(columns, means, rcond=None)
    residuals = means - columns @ solution
    freedom = len(residuals) - 3
    squares = float(residuals @ residuals)
    if expected_rad > 0.0:
        # Pool with experience, because a few rests may agree by chance.
        freedom += EXPERIENCE
        squares += EXPERIENCE * (float(solution[0]) * expected_rad) ** 2
    covariance = student_t_factor(freedom) * squares / freedom * np.linalg.inv(columns.T @ columns)
    return float(solution[0]), float(np.sqrt(covariance[0, 0]))


def axis_response(motion: Motion, body: int) -> Response:
    """Fit the direction of the response of a moved body's gyro (1 to 4) to a rotation about the joint.

    Its covariance includes the scatter of the recording's parts, the uncertainty of the joints in between,
    and the residual motion of the held body if that body's gyro is not calibrated itself.
    """
    readings = motion.readings(body)
    response = direction(readings, motion.axis(body), motion.sense() * motion.joint_rate_rad_s)
    gyro, held_gyro = motion.gyros[body - 1], motion.gyros[motion.held - 1]
    # An error of the axis, in body axes, becomes one of the reading through S Mᵀ.
    to_reading = gyro.response @ gyro.rotation.T
    # The held body's motion is taken off by a mounting that is not exact.
    held_rates = held_gyro.body_rates(motion.recording.rate_rad_s[:, motion.held - 1])
    share = (held_rates**2).sum() / (readings**2).sum()
    # Power taken off times the mounting's mean variance per axis, taken as isotropic.
    residual_variance = share * np.trace(held_gyro.covariance[MOUNTING, MOUNTING]) / 3.0
    covariance = (
        response.covariance
        + to_reading @ motion.axis_covariance(body) @ to_reading.T
        + residual_variance * np.eye(3)
    )
    # A direction has no variance along itself.
    project = across(response.reading)
    return replace(
        response, covariance=project @ covariance @ project, tilted_by=motion.step.moving_joint - 1
    )


def turn_response(recording: SensorSamples, step: Step, gyro: GyroCalibration) -> Response:
    """Fit one gyro's response to turns of the whole robot by hand through a known angle, there and back.

    The turns are for the axis about which no joint turns.

    Raises:
        CalibrationError: too few turns, or they were by another angle or the other way round.
    """
    axis = turn_axis(step)
    readings = recording.rate_rad_s[:, gyro.body - 1] - gyro.bias_rad_s
    response = direction(readings, axis, readings @ gyro.readings(axis))
    along = readings @ response.reading
    rests = find_rests(recording.t_s, along, TURN_SHARE)
    if len(rests) <= _MIN_SWEEPS:
        raise CalibrationError(
            what=f"The robot was turned {max(0, len(rests) - 1)} times; at least {_MIN_SWEEPS} turns are needed.",
            meaning="Their scatter is what tells how sure the scale factor is.",
            next_step="Turn it there and back three times, resting a second at each end, and run this "
            "command again.",
        )
    # The rests alternate between both edges: 0, angle, 0, ...
    angles = np.deg2rad(step.angle_deg) * (np.arange(len(rests)) % 2)
    _check_angles(rest_means(cumulative_trapezoid(along, recording.t_s, initial=0), rests), angles, step)
    length, std = length_between_rests(recording.t_s, along, rests, angles, PLACING_STD_RAD)
    # The table's axis is not quite the body's, for all gyros alike; the length sees second order.
    tilted_by = JOINT_COUNT + int(np.argmax(np.abs(axis)))
    return with_length(replace(response, tilted_by=tilted_by), length, std)


def turn_axis(step: Step) -> FloatArray:
    """(3,) body axis of a turn."""
    if step.axis is None:
        raise ValueError("a turn has an axis")
    return np.asarray(np.eye(3)[AXES.index(step.axis)])


def _check_angles(turned_rad: FloatArray, known_rad: FloatArray, step: Step) -> None:
    """Refuses legs that were others than asked for, by the angles (k,) at the rests."""
    # Compare leg by leg, so that the message can name the turn.
    legs, expected_legs = np.diff(turned_rad), np.diff(known_rad)
    wrong = np.abs(legs / expected_legs - 1.0) > ANGLE_TOLERANCE
    if wrong.any():
        first = int(np.argmax(wrong))
        raise CalibrationError(
            what=f"Turn {first + 1} was one of {np.rad2deg(legs[first]):+.0f} deg, not of "
            f"{np.rad2deg(expected_legs[first]):+.0f} deg.",
            meaning="The scale factor would be wrong by as much.",
            next_step=f"Turn it by {step.angle_deg:g} deg, counter-clockwise as seen against the {step.axis} axis, "
            "then back, from edge to edge, and run this command again.",
        )
