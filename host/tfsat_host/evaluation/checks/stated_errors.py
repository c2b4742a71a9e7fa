"""Covariance of a drop's residual by the errors that calibration and data sheets state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.apply import split_shared
from tfsat_host.calibration.sensors.gyro import MOUNTING, PARAMETERS
from tfsat_host.calibration.statistics import root_of
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.motion.gyro_signal import DELAY_STD_S, READ_APART_STD_S, derivative, sheet_lag
from tfsat_host.evaluation.motion.joints import SHARED_CAUSE, UNSENSED_STD_RAD, sample_noise_rad
from tfsat_host.robot import ASSUMED

GYRO_FLOOR = np.array([*[np.deg2rad(0.005)] * 3, *[np.deg2rad(0.05)] * 3, *[1e-3] * 6])
"""No gyro's bias, mounting, scale and skew are better than this, whatever a certificate states: the earth turns 0.004
deg/s, frames give under a servo's load, and the scale bends by 0.2 % of the range (PS-MPU-6000A rev. 3.4, section
6.1)."""
RATE_FLOOR_RAD_S = np.deg2rad(0.02)
"""Of a mean over 0.1 s: frames that ring after a stroke."""
SENSOR_FLOOR_RAD = np.deg2rad(0.02)
"""Of a mean over 0.1 s: a magnet's play on its shaft."""
MAX_HOLE_S = 0.015
"""While a servo speeds up by 4000 deg/s^2, the trapezoid over a hole of h misses 4000 h^2 / 12 deg: here 0.08 deg."""
MIN_ANSWERED = 0.5
"""Of a block's readings; a mean over fewer is none."""
WANDER_STD_RAD = np.deg2rad(0.2)
"""Of an angle by gyros alone, from where it began: 0.1 % of strokes of 70 deg, there and back, by two gyros."""
_WANDER_KNOT_S = 0.25
_START_STD_RAD = np.pi
_ANGLE_STEP_RAD = 1e-4


@dataclass(frozen=True, eq=False)
class StatedErrors:
    """Of the residual.

    Attributes:
        known: (size,) rows that rest on enough readings.
        sensed: (size,) rows of which the angle sensor answered; its gyros may not have.
        covariance: (size, size).
        by_gyros: How the residual follows the gyros' errors.
        by_sensors: (size, q) by zero points and bends of the angle sensors, each of variance one.
        by_fallback: (size, p) by angles that no sensor tells, each of variance one.
        by_starts: (size, joints) by the angle of each joint at the release, rad.
        noise: (size, size).
    """

    known: BoolArray
    sensed: BoolArray
    covariance: FloatArray
    by_gyros: ByGyros
    by_sensors: FloatArray
    by_fallback: FloatArray
    by_starts: FloatArray
    noise: FloatArray

    def among(self, rows: BoolArray) -> FloatArray:
        """Covariance of some rows (size,)."""
        return np.asarray(self.covariance[np.ix_(rows, rows)])

    def chi_square_of(self, vector: FloatArray, rows: BoolArray) -> tuple[float, int]:
        """Chi-square of those of some rows (size,) that are known, without the others, and how many they are."""
        # Marginal covariance: rows that are not chosen are integrated out.
        chosen = rows & self.known
        residual = vector[chosen]
        return float(residual @ np.linalg.solve(self.among(chosen), residual)) if len(residual) else 0.0, len(
            residual
        )


MOMENTS = 4
"""Of a low-pass's lag: what two of them leave at 5 Hz over a servo's ramp is far above the noise."""


class ByGyros(NamedTuple):
    """k rows by the errors of each of the four gyros.

    Attributes:
        parameters: (k, 4, 12) bias, rotation vector, scale, skew.
        in_fall: (k, 4, 12) the same, were they other ones in the fall alone.
        lag: (k, 4, MOMENTS) of the low-pass: its delay, s, and its higher moments, s^2 to s^4; see
            `motion/gyro_signal.py`.
    """

    parameters: FloatArray
    in_fall: FloatArray
    lag: FloatArray

    @property
    def delay(self) -> FloatArray:
        """(k, 4) by the delay of each gyro's low-pass, s."""
        return self.lag[..., 0]

    def as_stated(self, data: Consistency, floor: FloatArray) -> FloatArray:
        """(k, p) by errors of variance one; no gyro's parameters are better than the floor (12,)."""
        # Of the low-pass's shape the data sheet says nothing: from one pole (0) to a pure delay (d^k / k!). Half of the
        # second moment's range is taken off, see `motion/gyro_signal.py`; the higher ones count whole.
        d = sheet_lag(data.low_pass).delay_s
        moment_std = np.array([DELAY_STD_S, d**2 / 4.0, d**3 / (6.0 * 2.0**0.5), d**4 / (24.0 * 2.0**0.5)])
        # What the gyros have in common by the joints' axes is in the columns of the tilts.
        _, covariance = split_shared(data.parameter_covariance, data.shared)
        root = root_of(covariance + np.diag(np.tile(floor**2, data.bodies)))
        changes = [root_of(c) for c in data.fall_covariance]
        return np.concatenate(
            [
                self.parameters.reshape(len(self.parameters), -1) @ root,
                *(self.in_fall[:, b] @ root for b, root in enumerate(changes)),
                # The reading time of each gyro, then the moments that all have in common.
                self.delay * READ_APART_STD_S,
                self.lag.sum(axis=1) * moment_std,
            ],
            axis=1,
        )


def stated_errors(data: Consistency) -> StatedErrors:
    """Noise, parameters of gyros and angle sensors, lags, and the floors of this module."""
    jacobian = _gyro_jacobian(data)
    # What changes with the fall does not show at rest.
    in_fall = jacobian.copy()
    for body in range(data.bodies):
        in_fall[data.at_rest(body)] = 0.0
    by_gyros = ByGyros(jacobian, in_fall, _by_lag(data))
    starts, sensors, fallback, noise = _by_starts(data), _by_sensors(data), _by_fallback(data), _noise(data)
    # Every lasting error is a column of variance one: the covariance is their outer product, and noise.
    design = np.concatenate(
        [
            by_gyros.as_stated(data, GYRO_FLOOR),
            starts * _START_STD_RAD,
            sensors,
            fallback,
            data.tilt_jacobian * axis_std_rad(data) + by_calibrated_axes(data, jacobian),
        ],
        axis=1,
    )
    known_rows, sensed = _known_rows(data)
    return StatedErrors(
        known_rows, sensed, design @ design.T + noise, by_gyros, sensors, fallback, starts, noise
    )


def by_calibrated_axes(data: Consistency, by_parameters: FloatArray) -> FloatArray:
    """(size, 6) by what tilts of one standard deviation did to the gyros, which were calibrated by these axes.

    `by_parameters` (size, 4, 12) is by those of each gyro.
    """
    gyros_by_tilts, _ = split_shared(data.parameter_covariance, data.shared)
    return np.asarray(by_parameters.reshape(len(by_parameters), -1) @ gyros_by_tilts)


def axis_std_rad(data: Consistency) -> float:
    """Return the standard deviation of each tilt of a joint's axis, as the robot file states it."""
    return (data.model.uncertainty or ASSUMED).joint_axis_rad


def _gyro_jacobian(data: Consistency) -> FloatArray:
    """(size, 4, 12)."""
    out = np.zeros((data.size, data.bodies, PARAMETERS))
    for body in range(data.bodies):
        out[:, body] = data.rate_part(body, np.moveaxis(data.jacobian[:, body], 2, 0), data.rotations).T
        # At rest a gyro shows its bias, from which the certificate's is subtracted.
        out[data.at_rest(body), body, :3] = -np.eye(3)
    return out


def _by_lag(data: Consistency) -> FloatArray:
    """(size, 4, MOMENTS) by the moments of each gyro's low-pass, see `ByGyros`."""
    parts = [
        data.rate_part(body, lag_columns(data.t_s, rates), data.rotations).T
        for body, rates in enumerate(data.rates)
    ]
    return np.stack(parts, axis=1)


def lag_columns(t_s: FloatArray, rates_rad_s: FloatArray) -> FloatArray:
    """(MOMENTS, n, 3) what rates (n, 3) change by with each moment of a lag: their derivatives."""
    changes = [rates_rad_s]
    for _ in range(MOMENTS):
        changes.append(derivative(t_s, changes[-1]))
    return np.array(changes[1:])


def _by_fallback(data: Consistency) -> FloatArray:
    """(size, p) for each joint without angle sensors: its start is unknown, and the integral of its gyros drifts."""
    knots = np.arange(0.0, data.t_s[-1] + _WANDER_KNOT_S, _WANDER_KNOT_S)
    hats = [np.interp(data.t_s, knots, row) for row in np.eye(len(knots))]
    errors = [(np.ones_like(data.t_s), UNSENSED_STD_RAD), *((hat, WANDER_STD_RAD) for hat in hats)]
    columns = [
        std * _by_angle(data, joint, error)
        for joint, pair in enumerate(data.sensed_angles)
        if not np.isfinite(pair).any()
        for error, std in errors
    ]
    return np.stack(columns, axis=1) if columns else np.zeros((data.size, 0))


def _by_angle(data: Consistency, joint: int, error: FloatArray) -> FloatArray:
    """(size,) the residual by an error (n,) of the angle of a joint without angle sensors."""
    out = np.zeros(data.size)
    # Central difference: the angle enters by the joint's rotation, which is not linear.
    for sign in (1.0, -1.0):
        turns = list(data.rotations)
        turns[joint] = data.rotation_by(joint, (data.by_gyros(joint) + sign * _ANGLE_STEP_RAD * error)[None])
        added = np.sum([data.rate_part(b, rates, turns) for b, rates in enumerate(data.rates)], axis=0)
        out += sign * added / (2.0 * _ANGLE_STEP_RAD)
    return out


def _by_starts(data: Consistency) -> FloatArray:
    """(size, joints)."""
    out = np.zeros((data.size, data.joints))
    for joint, sensor in np.ndindex(data.joints, 2):
        out[data.along(joint, sensor), joint] = -1.0
    return out


def _by_sensors(data: Consistency) -> FloatArray:
    """(size, q) for each joint: zero points and bends of its sensors, each of variance one."""
    columns = []
    for joint, sensors in enumerate(data.calibration.joints):
        zeros, bends = np.zeros((data.size, 2)), np.zeros((data.size, 8))
        readings_rad = data.shown_rad[:, data.sensors(joint)]
        for k in range(2):
            rows = data.along(joint, k)
            zeros[rows, k] = -sensors.direction[k]
            curve = np.nan_to_num(-sensors.direction[k] * sensors.bend_curve(k, readings_rad[:, k]))
            bends[rows, 4 * k : 4 * k + 4] = data.mean(curve.T).T
        columns += [
            zeros @ root_of(sensors.zero_covariance),
            bends @ root_of(SHARED_CAUSE * sensors.bend_covariance),
        ]
    return np.concatenate(columns, axis=1)


def _noise(data: Consistency) -> FloatArray:
    """(size, size) of the readings, and of errors that are independent from block to block."""
    out = np.zeros((data.size, data.size))
    counts = data.block.counts
    centers = data.block.edges + counts // 2
    for joint in range(data.joints):
        outer, inner = data.pair(joint)
        sample = data.variance[:, inner] + data.variance[:, outer]
        askew = _askew(data, inner) + _askew(data, outer)
        rows = np.arange(data.size)[data.off_axis(joint)]
        # Means of white noise average out; second-order errors of a mounting last, and do not.
        out[rows, rows] = np.tile(data.mean(sample) / counts + data.mean(askew) ** 2, 2) + RATE_FLOOR_RAD_S**2
        # Integrated noise is a random walk: two blocks share the variance up to the earlier of them.
        walked = np.cumsum(sample * np.gradient(data.t_s) ** 2)[centers]
        walk = np.minimum.outer(walked, walked)
        # Second-order errors of a mounting add up in amplitude: fully correlated.
        bent = np.cumsum(askew * np.gradient(data.t_s))[centers]
        walk = walk + np.outer(bent, bent)
        sensed = data.calibration.joints[joint].each(data.shown_rad[:, data.sensors(joint)])
        for k, m in np.ndindex(2, 2):
            out[data.along(joint, k), data.along(joint, m)] += walk
        for k in range(2):
            rows = np.arange(data.size)[data.along(joint, k)]
            out[rows, rows] += sample_noise_rad(sensed[:, k]) ** 2 / counts + SENSOR_FLOOR_RAD**2
    for body in range(data.bodies):
        std = np.zeros(3) if data.rest is None else np.nan_to_num(data.rest.reading_std_rad_s[body])
        rows = np.arange(data.size)[data.at_rest(body)]
        out[rows, rows] = std**2
    return out


def _askew(data: Consistency, body: int) -> FloatArray:
    """(n,) rate error of second order in the mounting, which counts for a gyro without calibration."""
    turned = np.trace(data.parameter_covariance[body, MOUNTING, MOUNTING])
    return np.asarray(turned * np.linalg.norm(data.rates[body], axis=1))


def _known_rows(data: Consistency) -> tuple[BoolArray, BoolArray]:
    """(size,) rows with enough readings, of an integral with all of them; and rows whose angle sensor answered."""
    out, sensed_rows = np.zeros(data.size, dtype=bool), np.zeros(data.size, dtype=bool)
    share = data.mean(data.answered.T.astype(np.float64))
    # An integral needs every block, and no hole; off the axis each block stands alone.
    through = bool(np.diff(data.t_s).max() <= MAX_HOLE_S)
    for joint in range(data.joints):
        complete_blocks = (share[list(data.pair(joint))] >= MIN_ANSWERED).all(axis=0)
        out[data.off_axis(joint)] = np.tile(complete_blocks, 2)
        for k, angles in enumerate(data.sensed_angles[joint]):
            sensed_rows[data.along(joint, k)] = (
                data.mean(np.isfinite(angles).astype(np.float64)) >= MIN_ANSWERED
            )
            out[data.along(joint, k)] = sensed_rows[data.along(joint, k)] & complete_blocks.all() & through
    for body in range(data.bodies):
        out[data.at_rest(body)] = np.isfinite(data.rest_rad_s[body])
    return out, sensed_rows
