"""Gyros and angle sensors together: what each may be off is learnt from the other, as far as its calibration allows.

Gauss and Newton over the slow errors. Each pass takes them off the gyros' rates, fuses those over the joint angles that
they make, and lets the angle sensors and the neighbouring gyros correct them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.evaluation.motion.gyro_signal import (
    LEAST_STROKE_RAD,
    PLAUSIBLE_STDS,
    Lag,
    sample_variance,
    sheet_lag,
)
from tfsat_host.evaluation.motion.joints import (
    SMOOTHED,
    SMOOTHED_SHARE,
    UNSENSED_STD_RAD,
    SensedJoint,
    Slopes,
    errors_by_sensors,
    sensed_slopes,
)
from tfsat_host.evaluation.motion.rate_fusion import Fused, fuse, information_by_neighbours, rates_by_angles
from tfsat_host.evaluation.motion.samples import Readings, Samples, holes_of, turned_from
from tfsat_host.evaluation.motion.slow_errors import (
    RandomWalk,
    SlowErrors,
    Spread,
    gyro_errors,
    random_walk,
    slow_errors,
)
from tfsat_host.robot import RobotModel

_PASSES = 12
_CLOSE_RAD = 1e-5
"""Far below what any sensor tells."""
_PLAUSIBLE_SQUARES = 80.0
"""Of the gyros' 36 errors as learnt from angle sensors and neighbours, in units of their standard deviations by the
calibration: the sum of squares of 36 such numbers exceeds it by chance once in 30,000 drops, and what is learnt only
in part is smaller. Beyond it no gyro's parameters are corrected."""
_BY_SLOPE = 0.5


@dataclass(frozen=True, eq=False)
class Solved:
    """What gyros and angle sensors agree on, at n samples.

    Attributes:
        errors: (r,) the slow errors that were taken off.
        lag: Of the gyros.
        rates_rad_s: (n, 4, 3) of each gyro, its lag and its errors taken off; NaN without a reading.
        late_rate_rad_s: (n, 4, 3) the same as late as they were; bridged over holes.
        fused: Of those.
        angles_rad: (n, 3) of the joints.
        slow: What the errors may still be.
        contradicted: See `Motion`.
    """

    errors: FloatArray
    lag: Lag
    rates_rad_s: FloatArray
    late_rate_rad_s: FloatArray
    fused: Fused
    angles_rad: FloatArray
    slow: SlowErrors
    contradicted: bool = False


@dataclass(frozen=True, eq=False)
class SensorFusion:
    """One drop's sensors.

    Attributes:
        samples: Of the drop.
        joints: What the angle sensors say.
        body: The robot.
        readings: What the gyros show.
        variance: (n, 4) of each axis of a gyro's sample.
        slopes: Joint rates by the angle sensors.
        sheet: The lag by the data sheet.
        start_rad: (3,) where each joint is taken to begin before any sensor is asked.
        geometry_rad: (n, 3) joint angles good enough to begin with.
        spread: Of the slow errors.
    """

    samples: Samples
    joints: tuple[SensedJoint, ...]
    body: Multibody
    readings: Readings
    variance: FloatArray
    slopes: Slopes
    sheet: Lag
    start_rad: FloatArray
    geometry_rad: FloatArray
    spread: Spread

    @classmethod
    def of(
        cls,
        samples: Samples,
        joints: tuple[SensedJoint, ...],
        calibration: Calibration,
        model: RobotModel,
        densities: FloatArray,
        low_pass: LowPass,
    ) -> SensorFusion:
        """Of one drop; arguments as of `motion_of`."""
        body, sheet, readings = (
            Multibody.of(model),
            sheet_lag(low_pass),
            Readings.of(samples, calibration.gyros),
        )
        t, shown = samples.t_s, readings.rates(calibration.gyros)
        variance = sample_variance(densities, t, shown, samples.rate_hz, low_pass)
        slopes = sensed_slopes(t, joints, samples.rate_hz)
        held = np.array([servo.start_rad for servo in model.servos])
        answered = np.array([joint.answered for joint in joints])
        geometry = _geometry(t, joints, held)
        rates = np.where(readings.usable[..., None], sheet.removed(t, shown), np.nan)
        fused = fuse(body, geometry, rates, variance, slopes.rate_rad_s, slopes.variance)
        neighbours = [[int(model.joint_outer[j]), int(model.joint_inner[j])] for j in range(len(joints))]
        walks = [_walk(samples, fused, j, densities[pair], slopes) for j, pair in enumerate(neighbours)]
        spread = Spread.of(samples, sheet, np.where(answered, np.pi, UNSENSED_STD_RAD), walks)
        start = np.where(answered, 0.0, held)
        return cls(samples, joints, body, readings, variance, slopes, sheet, start, geometry, spread)

    def solved(self) -> Solved:
        """With what each sensor tells of the others, unless that is more than can be."""
        learnt = np.ones(len(self.spread), bool)
        found = self._passed(learnt)
        implausible_s = None
        if abs(found.lag.delay_s - self.sheet.delay_s) > PLAUSIBLE_STDS * self.sheet.delay_std_s:
            # Something else is wrong, and taken off as a delay it would spoil every rate.
            implausible_s = found.lag.delay_s
            learnt[self.spread.moments] = False
            found = self._passed(learnt)
        contradicted = bool((found.errors[self.spread.gyro] ** 2).sum() > _PLAUSIBLE_SQUARES)
        if contradicted:
            learnt[self.spread.gyro] = False
            found = self._passed(learnt)
        measured = implausible_s is None and self._moved()
        lag = replace(found.lag, measured=measured, implausible_s=implausible_s)
        return replace(found, lag=lag, contradicted=contradicted)

    def without(self, solved: Solved, errors: FloatArray) -> Solved:
        """The same with so much more of the slow errors (r,) taken off."""
        total, angles = solved.errors + errors, solved.angles_rad + solved.slow.angles @ errors
        return self._carried(total, angles, solved.slow.covariance)

    def smoothing_rad(self, fused: Fused) -> FloatArray:
        """(n, 3) standard deviation of what smoothing leaves of the angle sensors' noise where they tell the rate."""
        return np.where(fused.by_slopes > _BY_SLOPE, SMOOTHED_SHARE * self.slopes.angle_std_rad, 0.0)

    def _moved(self) -> bool:
        """A joint with angle sensors moved far enough to tell of the lag."""
        ranges = [np.nanmax(j.mean_rad) - np.nanmin(j.mean_rad) for j in self.joints if j.answered]
        return bool(max(ranges, default=0.0) > LEAST_STROKE_RAD)

    def _passed(self, learnt: BoolArray) -> Solved:
        errors, angles = np.zeros(len(self.spread)), self.geometry_rad
        covariance = np.eye(len(errors))
        # What the lag does is a derivative of the rates, so of their noise: noise times itself would bias it.
        no_lag = learnt & ~self.spread.is_lag
        last_rad = np.inf
        for _ in range(_PASSES):
            here = self._at(errors, angles)
            columns = self._columns(here, covariance)
            left = columns.gyros - np.where(here.fused.bridged[..., None, None], 0.0, columns.bodies)
            known = information_by_neighbours(
                self.samples.t_s, here.fused, left, self.variance, errors, no_lag
            )
            found, spread = errors_by_sensors(self.joints, here.angles, columns.angles, errors, learnt, known)
            proposed = here.angles + columns.angles @ (found - errors)
            change_rad = float(np.abs(proposed - angles).max())
            # With sensors that contradict each other, as under another robot's certificate, it may diverge.
            if change_rad > max(last_rad, np.pi):
                break
            errors, angles, covariance, last_rad = found, proposed, spread, change_rad
            if change_rad < _CLOSE_RAD:
                break
        return self._carried(errors, angles, covariance)

    def _carried(self, errors: FloatArray, angles: FloatArray, covariance: FloatArray) -> Solved:
        """Everything with those errors taken off, from joint angles that are nearly those."""
        here = self._at(errors, angles)
        for _ in range(_PASSES):
            if np.abs(here.angles - here.fused_over).max() < _CLOSE_RAD:
                break
            here = self._at(errors, here.angles)
        first = self.spread.moments.start
        std_s = float(self.spread.lag[0] * np.sqrt(covariance[first, first]))
        lag = replace(here.lag, delay_std_s=std_s)
        slow = self._columns(here, covariance)
        return Solved(errors, lag, here.rates, here.shown, here.fused, here.angles, slow)

    def _at(self, errors: FloatArray, angles: FloatArray) -> _Pass:
        """Rates without those errors, fused over joint angles (n, 3), and the joint angles that they make."""
        t, lag = self.samples.t_s, self.spread.lag_of(self.sheet, errors)
        gyros = self.readings.without(self.spread.parameters_of(errors))
        shown = self.readings.rates(gyros)
        rates = np.where(self.readings.usable[..., None], lag.removed(t, shown), np.nan)
        fused = fuse(self.body, angles, rates, self.variance, self.slopes.rate_rad_s, self.slopes.variance)
        turned = turned_from(t, fused.joint_rate_rad_s) + self.spread.own_angles(errors)
        return _Pass(gyros, lag, shown, rates, fused, angles, self.start_rad + turned)

    def _columns(self, here: _Pass, covariance: FloatArray) -> SlowErrors:
        by_parameters = self.readings.by_parameters(here.gyros)
        gyros = gyro_errors(self.spread, self.samples.t_s, here.lag, here.shown, by_parameters)
        by_angles = rates_by_angles(self.body, here.fused_over, here.fused, self.variance)
        return slow_errors(self.spread, self.samples.t_s, here.fused, gyros, by_angles, covariance)


class _Pass(NamedTuple):
    """Rates and angles with some errors taken off: gyros corrected, their lag, what they show, and what follows."""

    gyros: tuple[GyroCalibration, ...]
    lag: Lag
    shown: FloatArray
    rates: FloatArray
    fused: Fused
    fused_over: FloatArray
    angles: FloatArray


def _geometry(t_s: FloatArray, joints: tuple[SensedJoint, ...], held_rad: FloatArray) -> FloatArray:
    """(n, 3) by the angle sensors; a joint of which none answered stands still until its gyros turn it."""
    columns = []
    for joint, held in zip(joints, held_rad, strict=True):
        angle = joint.mean_rad
        known = np.isfinite(angle)
        columns.append(np.interp(t_s, t_s[known], angle[known]) if known.any() else np.full_like(t_s, held))
    return np.column_stack(columns)


def _walk(samples: Samples, fused: Fused, joint: int, densities: FloatArray, slopes: Slopes) -> RandomWalk:
    """Of one joint between two gyros with these noise densities (2,)."""
    return random_walk(
        samples.t_s,
        float(np.sqrt((densities**2).sum())),
        fused.by_slopes[:, joint] > _BY_SLOPE,
        float(slopes.angle_std_rad[joint]),
        SMOOTHED / samples.rate_hz,
        holes_of(samples.t_s, fused.joint_rate_rad_s[:, joint], samples.rate_hz),
    )
