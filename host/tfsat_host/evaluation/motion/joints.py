"""The joints' angles: where they began by the angle sensors, how they moved by the gyros, and both fused.

The paper takes the initial angle from the absolute sensors and integrates the relative rate of adjacent gyros from
there. Here the sensors go on helping: their samples bind the integral's slow errors (bias, scale factor, random walk),
the gyros bind the sensors' noise and bend, each by its uncertainty. All of it is linear, one least squares a joint:

    sensor k:  angle + zero error + bend error + noise
    angle:     start + (1 + scale error) turned + bias error t + random walk
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from tfsat_host.calibration.joints.joint_sensors import JointSensors

FloatArray = NDArray[np.float64]

KNOT_S = 0.2
"""The random walk of an integrated rate is followed so finely."""
UNSENSED_STD_RAD = np.deg2rad(6.0)
"""Of a start that no sensor tells: the paper's joint 1 hung 6 deg from where its servo should have held it."""
SHARED_CAUSE = 2.0
"""Scale factors were calibrated against these very sensors, so that a bend that was missed is in both: their variances
are taken so many times, as two numbers with one error have no better mean than either."""
SENSOR_FLOOR_RAD = np.deg2rad(0.01)
"""No angle sensor is better than that, however quiet its samples look."""


@dataclass(frozen=True, eq=False)
class GyroPart:
    """What the gyros tell of one joint.

    Attributes:
        turned_rad: (n,) integral of its rate, zero at the release.
        density_rad_s_rthz: One-sided noise density of that rate.
        bias_std_rad_s: What its bias may still be.
        scale_std: What its scale factor may still be off.
    """

    turned_rad: FloatArray
    density_rad_s_rthz: float
    bias_std_rad_s: float
    scale_std: float


@dataclass(frozen=True, eq=False)
class SensorDisagreement:
    """One angle sensor beside the fused angle, over the whole fall.

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
        basis: (n, k) what the angle's remaining errors look like.
        covariance: (k, k) of those errors.
        noise_rad: (2,) standard deviation of a sample of either sensor.
        sensors: What each sensor says beside the fused angle.
        sensed: Angle sensors have answered.
    """

    joint: int
    angle_rad: FloatArray
    basis: FloatArray
    covariance: FloatArray
    noise_rad: FloatArray
    sensors: tuple[SensorDisagreement, ...]
    sensed: bool

    def std_rad(self) -> FloatArray:
        """(n,) standard deviation of the angle."""
        return np.asarray(np.sqrt(np.einsum("ni,ij,nj->n", self.basis, self.covariance, self.basis)))

    def difference_std_rad(self, first: int, second: int) -> float:
        """Standard deviation of the angle's change between two samples."""
        change = self.basis[second] - self.basis[first]
        return float(np.sqrt(change @ self.covariance @ change))


def joint_motion(
    t_s: FloatArray,
    gyros: GyroPart,
    shown_rad: FloatArray,
    sensors: JointSensors,
    start_rad: float,
) -> JointMotion:
    """Fuses what gyros and angle sensors tell of one joint.

    Args:
        t_s: (n,) after the release.
        gyros: Their part.
        shown_rad: (n, 2) what both angle sensors show; NaN where one did not answer.
        sensors: Their calibration.
        start_rad: Where the servo holds the joint before the first stroke: for want of an answer.
    """
    shown_by = sensors.each(shown_rad)
    basis = _basis(t_s, gyros.turned_rad)
    noise = np.array([sample_noise_rad(shown_by[:, k]) for k in range(2)])
    rows, late = [], []
    curves = [-sensors.direction[k] * sensors.bend_curve(k, shown_rad[:, k]) for k in range(2)]
    for k in range(2):
        own = np.zeros((len(t_s), 10))
        own[:, k] = -sensors.direction[k]
        own[:, 2 + 4 * k : 6 + 4 * k] = curves[k]
        known = np.isfinite(shown_by[:, k])
        rows.append(np.column_stack([basis, own])[known] / noise[k])
        late.append((shown_by[:, k] - gyros.turned_rad)[known] / noise[k])
    design, values = np.concatenate(rows), np.concatenate(late)
    sensed = len(values) > 0
    prior = block_diag(
        np.array([[(np.pi if sensed else UNSENSED_STD_RAD) ** 2]]),
        _error_covariance(basis.shape[1], gyros),
        sensors.zero_covariance,
        SHARED_CAUSE * sensors.bend_covariance + 1e-16 * np.eye(8),
    )
    information = np.linalg.inv(prior)
    mean = np.zeros(len(prior))
    if not sensed:
        mean[0] = start_rad
    covariance = np.linalg.inv(information + design.T @ design)
    found = covariance @ (information @ mean + design.T @ values)
    k = basis.shape[1]
    angle = gyros.turned_rad + basis @ found[:k]
    return JointMotion(
        sensors.joint,
        angle,
        basis,
        covariance[:k, :k],
        noise,
        tuple(_disagreement(k, shown_by[:, k], angle, sensors) for k in range(2)),
        sensed,
    )


def _basis(t_s: FloatArray, turned_rad: FloatArray) -> FloatArray:
    """(n, k): the start, the bias, the scale factor, and the random walk's knots."""
    knots = np.arange(0.0, t_s[-1] + KNOT_S, KNOT_S)
    hats = np.column_stack([np.interp(t_s, knots, row) for row in np.eye(len(knots))])
    return np.column_stack([np.ones_like(t_s), t_s, turned_rad, hats[:, 1:]])


def _error_covariance(size: int, gyros: GyroPart) -> FloatArray:
    """(size - 1, size - 1) of everything but the start."""
    times = KNOT_S * np.arange(1, size - 2)
    walk = 0.5 * gyros.density_rad_s_rthz**2 * np.minimum.outer(times, times)
    return np.asarray(block_diag([[gyros.bias_std_rad_s**2]], [[SHARED_CAUSE * gyros.scale_std**2]], walk))


def sample_noise_rad(angle_rad: FloatArray) -> float:
    """Of one sample, by second differences, which hardly know of the motion."""
    second = np.diff(angle_rad, 2)
    second = second[np.isfinite(second)]
    if len(second) < 10:
        return float(np.deg2rad(0.1))
    spread = float(np.median(np.abs(second))) / 0.6745 / np.sqrt(6.0)
    return float(max(spread, SENSOR_FLOOR_RAD))


def _disagreement(
    k: int, shown_by: FloatArray, angle_rad: FloatArray, sensors: JointSensors
) -> SensorDisagreement:
    off = shown_by - angle_rad
    off = off[np.isfinite(off)]
    if not len(off):
        return SensorDisagreement(k + 1, *[float("nan")] * 4)
    smooth = np.convolve(off, np.full(9, 1 / 9), mode="valid") if len(off) >= 9 else off
    expected = np.sqrt(
        sensors.zero_covariance[k, k]
        + np.trace(sensors.bend_covariance[4 * k : 4 * k + 4, 4 * k : 4 * k + 4])
    )
    return SensorDisagreement(
        k + 1,
        float(off.mean()),
        float(np.sqrt((off**2).mean())),
        float(np.abs(smooth).max()),
        float(expected),
    )


def turned_from(t_s: FloatArray, rate_rad_s: FloatArray) -> FloatArray:
    """(n, ...) integral of rates, zero at the release."""
    steps = 0.5 * (rate_rad_s[1:] + rate_rad_s[:-1]) * np.diff(t_s).reshape(-1, *[1] * (rate_rad_s.ndim - 1))
    total = np.concatenate([np.zeros((1, *rate_rad_s.shape[1:])), np.cumsum(steps, axis=0)])
    return np.asarray(total - total[int(np.searchsorted(t_s, 0.0))])
