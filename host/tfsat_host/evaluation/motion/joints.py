"""Joint angles: what the angle sensors measure, and the least-squares step over the lasting errors.

The paper takes the initial angle from the absolute sensors and integrates the relative rate of adjacent gyros from
there. Here the sensors' samples bound the drift of the integrals throughout, and the gyros the sensors' noise and bend,
each by its uncertainty:

    sensor k of joint j:  angle j + zero error + bend error + noise
    angle j:              start + integral of the joint's rate + walk
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag
from scipy.signal import savgol_filter

from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.sensors.joint_sensors import JointSensors
from tfsat_host.evaluation.motion.gyro_signal import derivative
from tfsat_host.evaluation.motion.samples import bridge_missing

SHARED_CAUSE = 4.0
"""Gyros' scale factors are calibrated against these very sensors, so that a bend that was missed is in both. Two
numbers with one error have no better mean than either: its variance taken so often, a bend tells little of a scale."""
SENSOR_FLOOR_RAD = np.deg2rad(0.01)
"""No angle sensor is better than that, however quiet its samples look."""
_NUISANCES = 10
_APART_RAD = np.deg2rad(5.0)
"""Two sensors of one joint that differ by more, and by more than their zero points and bends may be off, are not both
right: a magnet has slipped, or a wire is loose."""
_APART_STDS = 5.0
_LASTING = 0.05
"""Of the samples: what lasts shorter is an outlier."""


@dataclass(frozen=True, eq=False)
class SensedJoint:
    """What the two angle sensors of one joint say.

    Attributes:
        sensors: Their calibration.
        shown_rad: (n, 2) what they show; NaN where one did not answer.
        angle_rad: (n, 2) the joint's angle by each.
        noise_rad: (2,) standard deviation of a sample of each.
        distrusted: 0 or 1, the sensor that is not used, as the other one contradicts it; None: both are.
    """

    sensors: JointSensors
    shown_rad: FloatArray
    angle_rad: FloatArray
    noise_rad: FloatArray
    distrusted: int | None

    @classmethod
    def of(
        cls, sensors: JointSensors, shown_rad: FloatArray, held_rad: float, turned_rad: FloatArray
    ) -> SensedJoint:
        """Build the sensed joint from samples (n, 2) of a joint that its servo held at an angle to begin with.

        `turned_rad` (n,) is its rotation since the first sample by its gyros, the low-pass not removed; NaN where
        unknown.
        """
        angle = sensors.each(shown_rad)
        distrusted = _find_distrusted(sensors, angle, held_rad, turned_rad)
        if distrusted is not None:
            angle[:, distrusted] = np.nan
        noise = np.array([sample_noise_rad(angle[:, k]) for k in range(2)])
        return cls(sensors, shown_rad, angle, noise, distrusted)

    @property
    def answered(self) -> bool:
        """One of them did, at least once."""
        return bool(np.isfinite(self.angle_rad).any())

    @property
    def mean_rad(self) -> FloatArray:
        """(n,) by those that answered, without the jump that one's silence would make; NaN where none did."""
        # Shift both to their common mean, so that one's dropout makes no step.
        apart = self.angle_rad[:, 1] - self.angle_rad[:, 0]
        apart = apart[np.isfinite(apart)]
        half = 0.5 * float(apart.mean()) if len(apart) else 0.0
        each = self.angle_rad + np.array([half, -half])
        is_finite = np.isfinite(each)
        total = np.where(is_finite, each, 0.0).sum(axis=1)
        return np.where(is_finite.any(axis=1), total / np.maximum(is_finite.sum(axis=1), 1), np.nan)


def _find_distrusted(
    sensors: JointSensors, angle_rad: FloatArray, held_rad: float, turned_rad: FloatArray
) -> int | None:
    """Choose, of two sensors that contradict each other, the one that moved against the gyros.

    If neither did, or no gyros tell, choose the one that began farther from where the servo held the joint.
    """
    both = np.isfinite(angle_rad).all(axis=1)
    if not both.any():
        return None
    apart = wrap_angle(angle_rad[both, 1] - angle_rad[both, 0])
    # Both may differ by their zero points and bends, as the calibration states them.
    zeros = np.trace(sensors.zero_covariance) + np.trace(sensors.bend_covariance)
    limit = max(_APART_RAD, _APART_STDS * float(np.sqrt(zeros)))
    # A quantile, as single outliers are no lasting contradiction.
    if np.quantile(np.abs(apart), 1.0 - _LASTING) < limit:
        return None
    usable_rows = both & np.isfinite(turned_rad)
    if usable_rows.any():
        # A sound sensor keeps a constant difference to the gyros' integral; quantiles bound its range.
        drift = np.unwrap(angle_rad[usable_rows] - turned_rad[usable_rows, None], axis=0)
        low, high = np.quantile(drift, [_LASTING, 1.0 - _LASTING], axis=0)
        first, second = high - low
        # Blame the one that strayed more, by a clear margin only.
        if abs(second - first) > 0.5 * limit:
            return int(second > first)
    # Neither strayed, or no gyros tell: compare the first angles with where the servo held the joint.
    return int(np.abs(wrap_angle(angle_rad[both][0] - held_rad)).argmax())


class Squares(NamedTuple):
    """Chi-square of some errors by what was stated of them, and of how many of them a drop determines."""

    sum: float
    determined: float

    @classmethod
    def of(cls, errors: FloatArray, stated: FloatArray, covariance: FloatArray) -> Squares:
        """Compute from errors (k,), their information (k, k) before the drop and covariance (k, k) after it."""
        return cls(float(errors @ stated @ errors), float(len(errors) - (stated * covariance).sum()))


NONE_DETERMINED = Squares(0.0, 0.0)


def errors_by_sensors(
    joints: Sequence[SensedJoint],
    angles_rad: FloatArray,
    by_errors: FloatArray,
    errors: FloatArray,
    free: BoolArray,
    outside_information: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray, Squares]:
    """(r,) the errors and (r, r) their covariance; and what zero points and bends are off by.

    Args:
        joints: What the sensors say.
        angles_rad: (n, 3) with the errors as they are believed to be.
        by_errors: (n, 3, r) what more of them does to the angles.
        errors: (r,) as believed; each of variance one around zero before.
        free: (r,) which ones the sensors may tell; the others keep their variance.
        outside_information: (r, r) information from elsewhere, and (r,) its right-hand side.
    """
    r, extra = len(errors), _NUISANCES * len(joints)
    # Ten nuisances a joint: two zero points, and four coefficients of the bend of each sensor.
    sensors = block_diag(*(_nuisance_covariance(joint.sensors) for joint in joints))
    stated = np.asarray(np.linalg.inv(sensors), dtype=np.float64)
    # Prior: lasting errors of unit variance, nuisances as the calibration states them.
    information = np.asarray(block_diag(np.eye(r), stated))
    right = np.zeros(r + extra)
    # Other evidence, such as the neighbouring gyros', comes as normal equations of its own.
    information[:r, :r] += outside_information[0]
    right[:r] += outside_information[1]
    for j, joint in enumerate(joints):
        nuisance = r + _NUISANCES * j + np.arange(_NUISANCES)
        for k in range(2):
            there = np.isfinite(joint.angle_rad[:, k])
            rows = np.zeros((int(there.sum()), r + extra))
            rows[:, :r] = by_errors[there, j] * free
            # Residual for absolute errors: as if those already in the angles had not been taken off.
            off = (joint.angle_rad[:, k] - angles_rad[:, j])[there] + rows[:, :r] @ errors
            rows[:, nuisance[k]] = -joint.sensors.direction[k]
            bend = nuisance[2 + 4 * k : 6 + 4 * k]
            # Where the joint is, not where a noisy sample has it: a bend that follows the noise would explain it.
            reading_rad = joint.sensors.zero_rad[k] + joint.sensors.direction[k] * angles_rad[there, j]
            curve = joint.sensors.bend_curve(k, reading_rad)
            rows[:, bend] = -joint.sensors.direction[k] * curve
            information += rows.T @ rows / joint.noise_rad[k] ** 2
            right += rows.T @ off / joint.noise_rad[k] ** 2
    # Keep the errors' block of the inverse: this marginalizes the nuisances.
    covariance = np.asarray(np.linalg.inv(information), dtype=np.float64)
    solution = covariance @ right
    return solution[:r], covariance[:r, :r], Squares.of(solution[r:], stated, covariance[r:, r:])


def _nuisance_covariance(sensors: JointSensors) -> FloatArray:
    # A tiny variance keeps the covariance of a sensor that is stated as exact invertible.
    bend = SHARED_CAUSE * sensors.bend_covariance + 1e-16 * np.eye(8)
    return np.asarray(block_diag(sensors.zero_covariance + 1e-16 * np.eye(2), bend))


def sample_noise_rad(angle_rad: FloatArray) -> float:
    """Estimate the noise of one sample from second differences, which are almost free of the motion."""
    second = np.diff(angle_rad, 2)
    second = second[np.isfinite(second)]
    if len(second) < 10:
        return float(np.deg2rad(0.1))
    # Median absolute deviation (0.6745); a second difference has six times the variance of a sample.
    spread = float(np.median(np.abs(second))) / 0.6745 / np.sqrt(6.0)
    return float(max(spread, SENSOR_FLOOR_RAD))


_SMOOTHING_ORDER = 3
SMOOTHED = 9
"""Over so many samples a cubic is laid through a joint's sensed angles: a servo's ramp takes a dozen."""
SMOOTHED_SHARE = 0.505
"""So much of a sample's noise that cubic leaves at its middle: the square root of its largest coefficient, 59 / 231."""
END_SHARE = 0.615
"""So much a straight line over as many leaves at its end: the square root of 17 / 45."""
_UNSENSED_VARIANCE = np.deg2rad(200.0) ** 2
"""Of the rate of a joint that nothing tells: servos turn no faster."""


@dataclass(frozen=True, eq=False)
class Slopes:
    """Of each joint at n samples.

    Attributes:
        rate_rad_s: (n, 3); 0 where no sensor ever answered.
        variance: (3,) of those, (rad/s)^2.
        angle_std_rad: (3,) of one sample of the angle that the slope is of.
    """

    rate_rad_s: FloatArray
    variance: FloatArray
    angle_std_rad: FloatArray


def sensed_slopes(t_s: FloatArray, joints: Sequence[SensedJoint], rate_hz: float) -> Slopes:
    """Compute the joints' rates in one drop as slopes of their angle sensors' samples, at times (n,)."""
    rates = np.zeros((len(t_s), len(joints)))
    variances = np.full(len(joints), _UNSENSED_VARIANCE)
    stds = np.full(len(joints), np.pi)
    for j, joint in enumerate(joints):
        angle = joint.mean_rad
        if np.isfinite(angle).sum() > SMOOTHED:
            # Bridge missing readings: the filter needs equidistant samples.
            whole = bridge_missing(t_s, angle)
            stds[j] = sample_noise_rad(angle)
            # The slope between two samples m steps apart has the variance 2 (sigma / (m step))^2.
            variances[j] = 2.0 * (stds[j] * rate_hz / SMOOTHED) ** 2
            slope = derivative(t_s, smooth_savitzky_golay(whole))
            rates[:, j] = _straighten_rests(t_s, whole, slope, stds[j], rate_hz)
    return Slopes(rates, variances, stds)


_REST = 4 * SMOOTHED + 1
_MOVES_STDS = 6.0


def _straighten_rests(
    t_s: FloatArray, angle_rad: FloatArray, rate_rad_s: FloatArray, noise_rad: float, rate_hz: float
) -> FloatArray:
    """(n,) rates that are, wherever the joint rests for long, the slope of one straight line through that rest.

    Noise in the rate of a joint at rest would be taken for what its mass does: a fit of the model makes the body beyond
    it lighter, until the noise moves nothing.
    """
    if len(angle_rad) < _REST:
        return rate_rad_s
    # The slope of a line through m samples has the variance 12 sigma^2 / (m^3 step^2).
    line_std = noise_rad * rate_hz * (12.0 / _REST**3) ** 0.5
    lines = savgol_filter(angle_rad, _REST, 1, deriv=1, delta=1.0 / rate_hz)
    moving = np.abs(lines) > _MOVES_STDS * line_std
    # Padded with motion, so that a rest at either end has both its edges.
    edges = np.flatnonzero(np.diff(np.concatenate([[True], moving, [True]]).astype(np.int8)))
    straightened = rate_rad_s.copy()
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        if end - begin >= _REST:
            straightened[begin:end] = np.polyfit(t_s[begin:end], angle_rad[begin:end], 1)[0]
    return straightened


def smooth_savitzky_golay(values: FloatArray) -> FloatArray:
    """(n,) each of n >= SMOOTHED equidistant samples by the cubic through those around it (Savitzky and Golay, 1964).

    The first and the last few lie on the straight line through the first and the last window: at its end a cubic keeps
    nearly all of a sample's noise, and its slope has ten times the variance.
    """
    smooth = np.asarray(savgol_filter(values, SMOOTHED, _SMOOTHING_ORDER))
    lines, half = savgol_filter(values, SMOOTHED, 1), SMOOTHED // 2
    smooth[:half], smooth[-half:] = lines[:half], lines[-half:]
    return smooth


UNSENSED_STD_RAD = np.deg2rad(6.0)
"""Of a start that no sensor tells: the paper's joint 1 hung 6 deg from where its servo should have held it."""


@dataclass(frozen=True, eq=False)
class SensorDisagreement:
    """One angle sensor against the fused angle, over the whole fall.

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
        basis: (n, r) the angle by the lasting errors.
        covariance: (r, r) of those.
        noise_rad: (2,) standard deviation of a sample of either sensor.
        smoothing_rad: (n,) what is left of that noise in the angle, where no gyro tells the joint's rate; else 0.
        sensors: Each sensor against the fused angle.
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
        """Build a joint's motion from its angle (n,), the basis of its errors (n, r) and the remaining noise."""
        disagreements = tuple(_disagreement(sensed, k, angle_rad) for k in range(2))
        joint = sensed.sensors.joint
        noise = sensed.noise_rad
        return cls(joint, angle_rad, basis, covariance, noise, smoothing_rad, disagreements, sensed.answered)

    def std_rad(self) -> FloatArray:
        """(n,) standard deviation of the angle."""
        # Diagonal of B C B^T, without the (n, n) matrix.
        variance = ((self.basis @ self.covariance) * self.basis).sum(axis=1) + self.smoothing_rad**2
        return np.asarray(np.sqrt(np.maximum(variance, 0.0)))

    def difference_std_rad(self, first: int, second: int) -> float:
        """Standard deviation of the angle's change between two samples."""
        change = self.basis[second] - self.basis[first]
        noise = self.smoothing_rad[first] ** 2 + self.smoothing_rad[second] ** 2
        return float(np.sqrt(change @ self.covariance @ change + noise))


def _disagreement(sensed: SensedJoint, k: int, angle_rad: FloatArray) -> SensorDisagreement:
    # As shown, so that a sensor which is not trusted is compared as well.
    off = wrap_angle(sensed.sensors.each(sensed.shown_rad)[:, k] - angle_rad)
    off = off[np.isfinite(off)]
    if not len(off):
        return SensorDisagreement(k + 1, *[float("nan")] * 4)
    smooth = np.convolve(off, np.full(SMOOTHED, 1 / SMOOTHED), mode="valid") if len(off) >= SMOOTHED else off
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
