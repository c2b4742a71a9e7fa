"""What the consistency vector may be by the errors that calibration and data sheets state: its covariance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.calibration.statistics import root_of
from tfsat_host.evaluation.checks.consistency import Consistency
from tfsat_host.evaluation.motion.gyro_signal import DELAY_STD_S, derivative, sheet_lag
from tfsat_host.evaluation.motion.joints import SHARED_CAUSE, UNSENSED_STD_RAD, sample_noise_rad

GYRO_FLOOR = np.array([*[np.deg2rad(0.005)] * 3, *[np.deg2rad(0.05)] * 3, *[1e-3] * 3])
"""No gyro's bias, mounting and scale are better than this, whatever a certificate states: the earth turns 0.004 deg/s,
frames give under a servo's load, and the scale bends by 0.2 % of the range (PS-MPU-6000A rev. 3.4, section 6.1)."""
RATE_FLOOR_RAD_S = np.deg2rad(0.02)
"""Of a mean over 0.1 s: frames that ring after a stroke."""
SENSOR_FLOOR_RAD = np.deg2rad(0.02)
"""Of a mean over 0.1 s: a magnet's play on its shaft."""
READ_APART_STD_S = 0.3e-3
"""Of each gyro: IMUs are read one after the other."""
LONGEST_HOLE_S = 0.015
"""While a servo speeds up by 4000 deg/s^2, the trapezoid over a hole of h misses 4000 h^2 / 12 deg: here 0.08 deg."""
LEAST_ANSWERED = 0.5
"""Of a block's readings; a mean over fewer is none."""
WANDER_STD_RAD = np.deg2rad(0.2)
"""Of an angle by gyros alone, from where it began: 0.1 % of strokes of 70 deg, there and back, by two gyros."""
_WANDER_KNOT_S = 0.25
_START_STD_RAD = np.pi
_ANGLE_STEP_RAD = 1e-4


@dataclass(frozen=True, eq=False)
class StatedErrors:
    """What is to be expected of the vector; k rows of it are known.

    Attributes:
        known: (size,) rows that rest on enough readings.
        sensed: (size,) rows of which the angle sensor answered; its gyros may not have.
        covariance: (size, size).
        whitening: (k, k) makes numbers of variance one of the known rows.
        by_gyros: (size, 4, 9) the vector by each gyro's parameters.
    """

    known: BoolArray
    sensed: BoolArray
    covariance: FloatArray
    whitening: FloatArray
    by_gyros: FloatArray

    def whitened(self, rows: FloatArray) -> FloatArray:
        """(..., k) of vectors (..., size)."""
        return np.asarray(rows[..., self.known] @ self.whitening.T)

    def among(self, rows: BoolArray) -> FloatArray:
        """Covariance of some rows (size,)."""
        return np.asarray(self.covariance[np.ix_(rows, rows)])

    def surprise(self, vector: FloatArray, rows: BoolArray) -> tuple[float, int]:
        """Chi-square of those of some rows (size,) that are known, by themselves, and how many they are."""
        chosen = rows & self.known
        left = vector[chosen]
        return float(left @ np.linalg.solve(self.among(chosen), left)) if len(left) else 0.0, len(left)


def stated_errors(of: Consistency) -> StatedErrors:
    """Noise, parameters of gyros and angle sensors, lags, and the floors of this module."""
    by_gyros, (by_delay, by_second) = _by_gyros(of), _by_lag(of)
    # The sheet tells nothing of the second moment: one pole to a pure delay, as in `motion/gyro_signal.py`.
    second_std_s2 = 0.25 * sheet_lag(of.low_pass).delay_s ** 2
    roots = [np.linalg.cholesky(c + np.diag(GYRO_FLOOR**2)) for c in of.parameter_covariance]
    in_fall = by_gyros.copy()
    for body in range(of.bodies):
        in_fall[of.at_rest(body)] = 0.0
    design = np.concatenate(
        [
            *(by_gyros[:, b] @ root for b, root in enumerate(roots)),
            *(in_fall[:, b] @ root_of(changed) for b, changed in enumerate(of.fall_covariance)),
            by_delay * READ_APART_STD_S,
            by_delay.sum(axis=1, keepdims=True) * DELAY_STD_S,
            by_second.sum(axis=1, keepdims=True) * second_std_s2,
            *_by_sensors(of),
            _by_fallback(of),
        ],
        axis=1,
    )
    covariance = design @ design.T + _noise(of)
    known, sensed = _known(of)
    root = np.linalg.cholesky(covariance[np.ix_(known, known)])
    return StatedErrors(known, sensed, covariance, np.linalg.inv(root), by_gyros)


def _by_gyros(of: Consistency) -> FloatArray:
    """(size, 4, 9)."""
    out = np.zeros((of.size, of.bodies, 9))
    for body in range(of.bodies):
        out[:, body] = of.of_body(body, np.moveaxis(of.jacobian[:, body], 2, 0), of.own_turns).T
        # At rest a gyro shows its bias: what the certificate's has too much is missing there.
        out[of.at_rest(body), body, :3] = -np.eye(3)
    return out


def _by_lag(of: Consistency) -> tuple[FloatArray, FloatArray]:
    """(size, 4) by the delay of each gyro's low-pass, s, and by its second moment, s^2; see `motion/gyro_signal.py`."""
    first = [derivative(of.t_s, rates) for rates in of.own_rates]
    second = [derivative(of.t_s, change) for change in first]
    by_delay, by_second = (
        np.stack([of.of_body(b, change, of.own_turns) for b, change in enumerate(changes)], axis=1)
        for changes in (first, second)
    )
    return by_delay, by_second


def _by_fallback(of: Consistency) -> FloatArray:
    """(size, p): a joint without angle sensors begins at an unknown angle, and its integral wanders."""
    knots = np.arange(0.0, of.t_s[-1] + _WANDER_KNOT_S, _WANDER_KNOT_S)
    hats = [np.interp(of.t_s, knots, row) for row in np.eye(len(knots))]
    errors = [(np.ones_like(of.t_s), UNSENSED_STD_RAD), *((hat, WANDER_STD_RAD) for hat in hats)]
    columns = [
        std * _by_angle(of, joint, error)
        for joint, pair in enumerate(of.own_sensed)
        if not np.isfinite(pair).any()
        for error, std in errors
    ]
    return np.stack(columns, axis=1) if columns else np.zeros((of.size, 0))


def _by_angle(of: Consistency, joint: int, error: FloatArray) -> FloatArray:
    """(size,) the vector by an error (n,) of a joint's angle that only gyros tell."""
    out = np.zeros(of.size)
    for sign in (1.0, -1.0):
        turns = list(of.own_turns)
        turns[joint] = of.turned_by(joint, (of.by_gyros(joint) + sign * _ANGLE_STEP_RAD * error)[None])
        added = np.sum([of.of_body(b, rates, turns) for b, rates in enumerate(of.own_rates)], axis=0)
        out += sign * added / (2.0 * _ANGLE_STEP_RAD)
    return out


def _by_sensors(of: Consistency) -> list[FloatArray]:
    """Columns of the joints' starts, and of the zero points and bends of their sensors, each of variance one."""
    columns = []
    for joint, sensors in enumerate(of.calibration.joints):
        start, zeros, bends = np.zeros((of.size, 1)), np.zeros((of.size, 2)), np.zeros((of.size, 8))
        shown = of.readings.shown_rad[:, of.sensors(joint)]
        for k in range(2):
            rows = of.along(joint, k)
            start[rows] = _START_STD_RAD
            zeros[rows, k] = -sensors.direction[k]
            curve = np.nan_to_num(-sensors.direction[k] * sensors.bend_curve(k, shown[:, k]))
            bends[rows, 4 * k : 4 * k + 4] = of.mean(curve.T).T
        columns += [
            start,
            zeros @ root_of(sensors.zero_covariance),
            bends @ root_of(SHARED_CAUSE * sensors.bend_covariance),
        ]
    return columns


def _noise(of: Consistency) -> FloatArray:
    """(size, size): of readings, and of what is the same in no two blocks."""
    out = np.zeros((of.size, of.size))
    counts = of.block.counts
    centers = of.block.edges + counts // 2
    for joint in range(of.joints):
        outer, inner = of.pair(joint)
        sample = of.variance[:, inner] + of.variance[:, outer]
        askew = _askew(of, inner) + _askew(of, outer)
        rows = np.arange(of.size)[of.off_axis(joint)]
        out[rows, rows] = np.tile(of.mean(sample) / counts + of.mean(askew) ** 2, 2) + RATE_FLOOR_RAD_S**2
        walked = np.cumsum(sample * np.gradient(of.t_s) ** 2)[centers]
        walk = np.minimum.outer(walked, walked)
        bent = np.cumsum(askew * np.gradient(of.t_s))[centers]
        walk = walk + np.outer(bent, bent)
        sensed = of.calibration.joints[joint].each(of.readings.shown_rad[:, of.sensors(joint)])
        for k, m in np.ndindex(2, 2):
            out[of.along(joint, k), of.along(joint, m)] += walk
        for k in range(2):
            rows = np.arange(of.size)[of.along(joint, k)]
            out[rows, rows] += sample_noise_rad(sensed[:, k]) ** 2 / counts + SENSOR_FLOOR_RAD**2
    for body in range(of.bodies):
        std = np.zeros(3) if of.rest is None else np.nan_to_num(of.rest.reading_std_rad_s[body])
        rows = np.arange(of.size)[of.at_rest(body)]
        out[rows, rows] = std**2
    return out


def _askew(of: Consistency, body: int) -> FloatArray:
    """(n,) rate that a turned mounting adds beyond its first order: for a gyro without calibration."""
    turned = np.trace(of.parameter_covariance[body, 3:6, 3:6])
    return np.asarray(turned * np.linalg.norm(of.own_rates[body], axis=1))


def _known(of: Consistency) -> tuple[BoolArray, BoolArray]:
    """(size,) rows that rest on enough readings, an integral on all of them; and those whose angle sensor answered."""
    out, shown = np.zeros(of.size, dtype=bool), np.zeros(of.size, dtype=bool)
    share = of.mean(of.answered.T.astype(np.float64))
    through = bool(np.diff(of.t_s).max() <= LONGEST_HOLE_S)
    for joint in range(of.joints):
        whole = (share[list(of.pair(joint))] >= LEAST_ANSWERED).all(axis=0)
        out[of.off_axis(joint)] = np.tile(whole, 2)
        for k, angles in enumerate(of.own_sensed[joint]):
            shown[of.along(joint, k)] = of.mean(np.isfinite(angles).astype(np.float64)) >= LEAST_ANSWERED
            out[of.along(joint, k)] = shown[of.along(joint, k)] & whole.all() & through
    for body in range(of.bodies):
        out[of.at_rest(body)] = np.isfinite(of.readings.rest_rad_s[body])
    return out, shown
