"""Gyros and angle sensors together: least squares over their lasting errors, with the calibration as prior.

Gauss-Newton. Each step subtracts the errors from the gyros' rates, fuses the rates over the joint angles that follow
from them, and updates the errors by the residuals of angle sensors and neighbouring gyros.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.special import chdtri

from tfsat_host.arrays import BoolArray, FloatArray, IntArray
from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.sensors.gyro import MOUNTING, PARAMETERS, GyroCalibration
from tfsat_host.calibration.steps.low_pass import LowPass
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.evaluation.motion.error_model import (
    ErrorJacobians,
    Prior,
    RandomWalk,
    error_jacobians,
    gyro_errors,
    random_walk,
)
from tfsat_host.evaluation.motion.gyro_signal import (
    MIN_STROKE_RAD,
    PLAUSIBLE_STDS,
    Lag,
    sample_covariance,
    sheet_lag,
    smooth_rates,
)
from tfsat_host.evaluation.motion.joints import (
    END_SHARE,
    NONE_DETERMINED,
    SMOOTHED,
    SMOOTHED_SHARE,
    UNSENSED_STD_RAD,
    SensedJoint,
    Slopes,
    Squares,
    errors_by_sensors,
    sensed_slopes,
)
from tfsat_host.evaluation.motion.rate_fusion import (
    FusedRates,
    bodies_by_tilts,
    fuse,
    information_by_neighbours,
    rates_by_angles,
)
from tfsat_host.evaluation.motion.samples import Readings, Samples, bridge_missing, holes_of, turned_from
from tfsat_host.robot import ASSUMED, RobotModel

_MAX_STEPS = 12
_CLOSE_RAD = 1e-5
"""Far below the resolution of any sensor."""
_EXCESS, _EXCESS_UNCALIBRATED = 1.3, 4.0
"""Neighbouring gyros never count for more: frames give under a servo's load, and mountings without a calibration
are off by so much that products of errors count."""
# Mountings that are known better than this were measured; by design they are within 5 deg.
_CALIBRATED_RAD = np.deg2rad(0.9)
_RAMP_S = 9e-3
"""What two moments leave of a low-pass hangs together over a servo's ramp, and grows with the delay against the ramp's
length. With it emulated strokes at 5 Hz have the errors that are stated."""
_CHANCE_LEAST = 1 / 30_000
"""Of the gyros' errors by their calibration. Where they are less likely, neither they nor the axes are corrected."""
# A joint's rate is the angle sensors' if they have more than half of its information.
_BY_SLOPE = 0.5


@dataclass(frozen=True, eq=False)
class FusionSolution:
    """The least-squares solution, at n samples.

    Attributes:
        errors: (r,) lasting errors, already subtracted.
        lag: Of the gyros.
        rates_rad_s: (n, 4, 3) of each gyro without lag and errors; NaN without a reading.
        late_rate_rad_s: (n, 4, 3) the same with the lag in them; bridged over holes.
        fused: Rates of base and joints from `rates_rad_s`.
        angles_rad: (n, 3) of the joints.
        jacobians: What the errors may still be.
        contradicted: See `Motion`.
        sensors: Of zero points and bends.
        stated: As first found, of what `SensorFusion.solved` gives: of the gyros' errors; of what the certificate alone
            states, for weight and warmth change biases; and of the axes' tilts.
    """

    errors: FloatArray
    lag: Lag
    rates_rad_s: FloatArray
    late_rate_rad_s: FloatArray
    fused: FusedRates
    angles_rad: FloatArray
    jacobians: ErrorJacobians
    contradicted: bool = False
    sensors: Squares = NONE_DETERMINED
    stated: tuple[Squares, Squares, Squares] = (NONE_DETERMINED,) * 3


@dataclass(frozen=True, eq=False)
class SensorFusion:
    """One drop's sensors.

    Attributes:
        samples: Of the drop.
        joints: What the angle sensors say.
        body: The robot.
        readings: What the gyros show.
        noise: (n, 4, 3, 3) covariance of a gyro's sample.
        slopes: Joint rates by the angle sensors.
        sheet: The lag by the data sheet.
        start_rad: (3,) where each joint is taken to begin before any sensor is asked.
        geometry_rad: (n, 3) joint angles good enough to begin with.
        prior: Of the lasting errors.
    """

    samples: Samples
    joints: tuple[SensedJoint, ...]
    body: Multibody
    readings: Readings
    noise: FloatArray
    slopes: Slopes
    sheet: Lag
    start_rad: FloatArray
    geometry_rad: FloatArray
    prior: Prior

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
        """Build the fusion of one drop; arguments as in `motion_of`."""
        body, sheet = Multibody.of(model), sheet_lag(low_pass)
        readings = Readings.of(samples, calibration.gyros)
        t, measured_rates = samples.t_s, readings.rates(calibration.gyros)
        noise = sample_covariance(densities, t, measured_rates, samples.rate_hz, low_pass)
        slopes = sensed_slopes(t, joints, samples.rate_hz)
        start_angles_rad = np.array([servo.start_rad for servo in model.servos])
        answered = np.array([joint.answered for joint in joints])
        geometry = _geometry(t, joints, start_angles_rad)
        # Next to a hole a reading has no derivatives to take the lag off by: leave it out.
        rates = np.where(readings.usable[..., None], sheet.remove(t, measured_rates), np.nan)
        fused = fuse(body, geometry, rates, noise, slopes.rate_rad_s, slopes.variance)
        neighbours = [[int(model.joint_outer[j]), int(model.joint_inner[j])] for j in range(len(joints))]
        walks = [_walk(samples, fused, j, densities[pair], slopes) for j, pair in enumerate(neighbours)]
        # Mountings that were never measured have the tilts of the axes in them.
        axis_std_rad = (
            (model.uncertainty or ASSUMED).joint_axis_rad if _has_calibrated_gyros(samples) else 0.0
        )
        # With angle sensors the start is free; without, it is near to where the servo holds the joint.
        started = np.where(answered, np.pi, UNSENSED_STD_RAD)
        prior = Prior.of(samples, sheet, axis_std_rad, started, walks)
        start = np.where(answered, 0.0, start_angles_rad)
        return cls(samples, joints, body, readings, noise, slopes, sheet, start, geometry, prior)

    def solve(self) -> FusionSolution:
        """Solve the fusion; an implausible delay or implausible errors of the gyros keep their prior values."""
        free = np.ones(len(self.prior), bool)
        solution = self._gauss_newton(free)
        implausible_s = None
        if abs(solution.lag.delay_s - self.sheet.delay_s) > PLAUSIBLE_STDS * self.sheet.delay_std_s:
            # Another fault; as a delay it would spoil every rate.
            implausible_s = solution.lag.delay_s
            free[self.prior.moments] = False
            solution = self._gauss_newton(free)
        # Judge what the fusion changed by what was stated, before anything is held on that account.
        gyros, tilts = np.r_[self.prior.gyro], np.r_[self.prior.tilts]
        stated = (
            self._squares(solution, gyros),
            self._certificate_prior(solution),
            self._squares(solution, tilts),
        )
        contradicted = bool(stated[0].sum > chdtri(stated[0].determined, _CHANCE_LEAST))
        # Something else is wrong: keep gyros and axes as stated, rather than bend them to it.
        if contradicted:
            free[gyros] = free[tilts] = False
            solution = self._gauss_newton(free)
        measured = implausible_s is None and self._has_moving_joint()
        lag = replace(solution.lag, measured=measured, implausible_s=implausible_s)
        return replace(solution, lag=lag, contradicted=contradicted, stated=stated)

    def _squares(self, solution: FusionSolution, errors: IntArray) -> Squares:
        """Compute the chi-square of some of the lasting errors."""
        after = solution.jacobians.covariance[np.ix_(errors, errors)]
        return Squares.of(solution.errors[errors], np.eye(len(errors)), after)

    def _certificate_prior(self, solution: FusionSolution) -> Squares:
        """Compute the chi-square of all that the certificate states, except biases."""
        # Biases are left out: weight and warmth change them, which the certificate does not state.
        kept = np.arange(len(self.prior.gyro_root)).reshape(-1, PARAMETERS)[:, MOUNTING.start :].ravel()
        by_errors = self.prior.own_units[kept]
        off = self.prior.parameters_of(solution.errors).ravel()[kept]
        stated, posterior = by_errors @ by_errors.T, by_errors @ solution.jacobians.covariance @ by_errors.T
        of_gyros = Squares.of(off, np.asarray(np.linalg.pinv(stated), dtype=np.float64), posterior)
        # The errors of gyros and angle sensors are independent: their squares add up.
        return Squares(*map(sum, zip(solution.sensors, of_gyros, strict=True)))

    def without(self, solved: FusionSolution, errors: FloatArray) -> FusionSolution:
        """Return the solution with further lasting errors (r,) subtracted."""
        total, angles = solved.errors + errors, solved.angles_rad + solved.jacobians.angles @ errors
        return self._integrate(total, angles, solved.jacobians.covariance)

    def smoothing_rad(self, fused: FusedRates) -> FloatArray:
        """(n, 3) standard deviation of the angle sensors' smoothed noise, where a joint's rate is theirs."""
        share = np.full((len(fused.by_slopes), 1), SMOOTHED_SHARE)
        share[[0, -1]] = END_SHARE
        return np.where(fused.by_slopes > _BY_SLOPE, share * self.slopes.angle_std_rad, 0.0)

    @property
    def least_excess(self) -> float:
        """Of what neighbouring gyros leave over, by the low-pass and by how well their mountings are known."""
        ramps = (self.sheet.delay_s / _RAMP_S) ** 2
        return max(_EXCESS if _has_calibrated_gyros(self.samples) else _EXCESS_UNCALIBRATED, ramps)

    def _has_moving_joint(self) -> bool:
        """Return whether a joint with angle sensors moved far enough to measure the lag."""
        ranges = [np.nanmax(j.mean_rad) - np.nanmin(j.mean_rad) for j in self.joints if j.answered]
        return bool(max(ranges, default=0.0) > MIN_STROKE_RAD)

    def _gauss_newton(self, free: BoolArray) -> FusionSolution:
        errors, angles = np.zeros(len(self.prior)), self.geometry_rad
        # Begin where the sensors have the joints: with the whole start as a first step, the rates that depend on the
        # pose would be linearized far from it.
        errors[self.prior.starts] = (angles[0] - self.start_rad) / self.prior.start
        covariance, sensors = np.eye(len(errors)), NONE_DETERMINED
        # The lag's columns are derivatives of noisy rates: neighbours, of the same noise, would bias it.
        no_lag = free.copy()
        no_lag[self.prior.moments] = False
        last_rad = np.inf
        for _ in range(_MAX_STEPS):
            # Take off the errors found so far, fuse, and integrate the joints.
            here = self._at(errors, angles)
            columns = self._columns(here, covariance)
            # What is left over: a gyro's own error, less what all gyros together make of it.
            residual_jacobian = columns.gyros - np.where(
                here.fused.bridged[..., None, None], 0.0, columns.bodies
            )
            information = information_by_neighbours(
                self.samples.t_s, here.fused, residual_jacobian, self.noise, errors, no_lag, self.least_excess
            )
            # Angle sensors and neighbours in one system; here the lag is free.
            estimate, posterior, squares = errors_by_sensors(
                self.joints, here.angles, columns.angles, errors, free, information
            )
            # Judge the step by the joint angles that it leads to.
            proposed = here.angles + columns.angles @ (estimate - errors)
            change_rad = float(np.abs(proposed - angles).max())
            # It diverges where sensors contradict each other, as with another robot's certificate.
            if change_rad > max(last_rad, np.pi):
                break
            errors, angles, covariance, last_rad = estimate, proposed, posterior, change_rad
            sensors = squares
            if change_rad < _CLOSE_RAD:
                break
        return replace(self._integrate(errors, angles, covariance), sensors=sensors)

    def _integrate(self, errors: FloatArray, angles: FloatArray, covariance: FloatArray) -> FusionSolution:
        """Compute the solution with the given errors, starting from joint angles near its own."""
        here = self._at(errors, angles)
        # Rates are fused over a pose that follows from them: iterate until both agree.
        for _ in range(_MAX_STEPS):
            if np.abs(here.angles - here.fused_over).max() < _CLOSE_RAD:
                break
            here = self._at(errors, here.angles)
        first = self.prior.moments.start
        std_s = float(self.prior.lag[0] * np.sqrt(covariance[first, first]))
        lag = replace(here.lag, delay_std_s=std_s)
        jacobians = self._columns(here, covariance)
        return FusionSolution(errors, lag, here.rates, here.shown, here.fused, here.angles, jacobians)

    def _at(self, errors: FloatArray, angles: FloatArray) -> _Step:
        """Rates without those errors, fused over joint angles (n, 3), and the joint angles that follow."""
        t, lag = self.samples.t_s, self.prior.lag_of(self.sheet, errors)
        gyros = self.readings.without(self.prior.parameters_of(errors))
        # Bring all gyros to their mean lag first; one lag is then taken off all.
        measured_rates = self.prior.as_late(t, self.readings.rates(gyros), errors)
        rates = np.where(self.readings.usable[..., None], lag.remove(t, measured_rates), np.nan)
        body = self.body.tilt_hinges(self.prior.tilt_of(errors))
        fused = fuse(body, angles, rates, self.noise, self.slopes.rate_rad_s, self.slopes.variance)
        turned = turned_from(t, fused.joint_rate_rad_s) + self.prior.own_angles(errors)
        return _Step(body, gyros, lag, measured_rates, rates, fused, angles, self.start_rad + turned)

    def _columns(self, here: _Step, covariance: FloatArray) -> ErrorJacobians:
        rates = np.where(np.isfinite(here.rates), here.rates, here.fused.body_rates())
        # Smoothed as for the tilts: a turn of all mountings and all axes together shows nothing. Mountings that were
        # never measured are wrong by too much for that, and their axes have no tilt.
        if self.prior.tilt.any():
            rates = smooth_rates(rates)
        by_parameters = np.stack(
            [g.jacobian(g.readings(rates[:, b]) + g.bias_rad_s) for b, g in enumerate(here.gyros)], axis=1
        )
        gyros = gyro_errors(self.prior, self.samples.t_s, here.shown, by_parameters)
        by_angles = rates_by_angles(here.body, here.fused_over, here.fused, self.noise)
        by_tilts = bodies_by_tilts(here.body, here.fused_over, here.fused)
        return error_jacobians(
            self.prior, self.samples.t_s, here.fused, gyros, by_angles, by_tilts, covariance
        )


def _has_calibrated_gyros(samples: Samples) -> bool:
    """Return whether the gyros' mountings were measured."""
    variance = np.diagonal(samples.parameter_covariance, axis1=1, axis2=2)[:, MOUNTING]
    return bool(variance.mean() < _CALIBRATED_RAD**2)


class _Step(NamedTuple):
    """One step: robot, corrected gyros, their lag, rates with and without it, fusion, joint angles."""

    body: Multibody
    gyros: tuple[GyroCalibration, ...]
    lag: Lag
    shown: FloatArray
    rates: FloatArray
    fused: FusedRates
    fused_over: FloatArray
    angles: FloatArray


def _geometry(t_s: FloatArray, joints: tuple[SensedJoint, ...], held_rad: FloatArray) -> FloatArray:
    """(n, 3) joint angles by the angle sensors; a joint without any is taken to stand where its servo holds it."""
    columns = [
        bridge_missing(t_s, joint.mean_rad) if joint.answered else np.full_like(t_s, servo_angle_rad)
        for joint, servo_angle_rad in zip(joints, held_rad, strict=True)
    ]
    return np.column_stack(columns)


def _walk(
    samples: Samples, fused: FusedRates, joint: int, densities: FloatArray, slopes: Slopes
) -> RandomWalk:
    """Build the random walk of one joint between two gyros with these noise densities (2,)."""
    return random_walk(
        samples.t_s,
        # A joint's rate is a difference of two gyros: their noise adds in squares.
        float(np.sqrt((densities**2).sum())),
        fused.by_slopes[:, joint] > _BY_SLOPE,
        float(slopes.angle_std_rad[joint]),
        SMOOTHED / samples.rate_hz,
        holes_of(samples.t_s, fused.joint_rate_rad_s[:, joint], samples.rate_hz),
    )
