"""The attitude of a body over the fall: its rates integrated, and what is uncertain about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.evaluation.motion.samples import GAP_PERIODS, holes_of


def integrate_rates(t_s: FloatArray, rate_rad_s: FloatArray) -> Rotation:
    """Attitudes relative to the first sample.

    Between two samples the rate is taken to change linearly; the step is the Magnus expansion to second order, so that
    its error is of the fifth order in the step.

    Args:
        t_s: (n,) sample times.
        rate_rad_s: (n, 3) rates in the frame that they were measured in.

    Returns:
        n rotations from that frame to where it was at the first sample.
    """
    before, after, steps_s = rate_rad_s[:-1], rate_rad_s[1:], np.diff(t_s)[:, None]
    # Magnus expansion: the trapezoid, and the commutator of the rates at both ends.
    turns = 0.5 * steps_s * (before + after) + steps_s**2 / 12.0 * np.cross(before, after)
    steps = Rotation.from_rotvec(np.concatenate([np.zeros((1, 3)), turns])).as_quat()
    return Rotation.from_quat(_products(steps))


def _products(quaternions: FloatArray) -> FloatArray:
    """(n, 4): the product of all up to each, by doubling the reach of every one in each round."""
    reach = 1
    total = quaternions.T.copy()
    # Prefix products in log2(n) rounds, each for all samples at once; the product is associative.
    while reach < total.shape[1]:
        total[:, reach:] = quaternion.product(total[:, :-reach], total[:, reach:])
        reach *= 2
    return np.ascontiguousarray(total.T)


def reorientation_deg(start: Rotation, end: Rotation) -> float:
    """Angle of the rotation that leads from one attitude to another."""
    return float(np.rad2deg((start.inv() * end).magnitude()))


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """One body at m samples from the release on; inertial axes are its own at the first of them.

    Attributes:
        t_s: (m,) after the release.
        rate_rad_s: (m, 3) body axes, the gyro's lag taken off.
        attitude: m rotations, from body axes to inertial axes.
        by_errors: (m, 3, r) the attitude's error, inertial axes, by the lasting errors.
        error_covariance: (r, r) of those.
        noise_covariance: (m, 3, 3) of the attitude from noise and gaps.
        bridged: (m,) its own gyro did not answer.
    """

    t_s: FloatArray
    rate_rad_s: FloatArray
    attitude: Rotation
    by_errors: FloatArray
    error_covariance: FloatArray
    noise_covariance: FloatArray
    bridged: BoolArray

    def covariance(self, index: int = -1) -> FloatArray:
        """(3, 3) of the attitude at a sample, a rotation vector in inertial axes, rad^2."""
        by = self.by_errors[index]
        return np.asarray(by @ self.error_covariance @ by.T + self.noise_covariance[index])

    def reorientation_rad(self, index: int = -1) -> tuple[float, float]:
        """Compute the angle turned since the release and its standard deviation."""
        turn = self.attitude[index].as_rotvec()
        angle = float(np.linalg.norm(turn))
        # Without a turn the axis is undefined: the worst one counts.
        if angle < 1e-9:
            return angle, float(np.sqrt(np.linalg.eigvalsh(self.covariance(index)).max()))
        # To first order only an error about the rotation's axis changes its angle.
        axis = turn / angle
        return angle, float(np.sqrt(axis @ self.covariance(index) @ axis))


@dataclass(frozen=True, eq=False)
class Rates:
    """Rates of one body at n samples and what they rest on.

    Attributes:
        rate_rad_s: (n, 3) body axes.
        by_errors: (n, 3, r) by the lasting errors.
        variance: (n, 3, 3) of each sample's noise.
        bridged: (n,) from other bodies' gyros.
    """

    rate_rad_s: FloatArray
    by_errors: FloatArray
    variance: FloatArray
    bridged: BoolArray


def body_motion(t_s: FloatArray, rates: Rates, error_covariance: FloatArray, rate_hz: float) -> BodyMotion:
    """Integrates from the release, or the first sample after it.

    `t_s` (n,) is after the release, `error_covariance` (r, r). `rate_hz` is the sampling rate as commanded:
    longer steps have samples missing.
    """
    fall = t_s >= 0.0
    t, rate = t_s[fall], rates.rate_rad_s[fall]
    start, start_variance = _since_release(t[0], rate[0], rate_hz)
    attitude = start * integrate_rates(t, rate)
    matrices = attitude.as_matrix()
    # J = integral of R dw/dp: an error that lasts adds up in amplitude.
    by = cumulative_trapezoid(matrices @ rates.by_errors[fall], t, axis=0, initial=0)
    # Noise adds up in variance, after it is turned into inertial axes.
    turned = matrices @ rates.variance[fall] @ matrices.swapaxes(1, 2)
    weights = np.gradient(t)
    noise = np.cumsum(turned * (weights**2)[:, None, None], axis=0)
    holes = holes_of(t, rate, rate_hz)
    # What straight lines across holes may miss: alike in all directions, as its axis is unknown.
    missed = start_variance + holes.variance_between(np.full_like(t, t[0]), t)
    noise = noise + missed[:, None, None] * np.eye(3)
    return BodyMotion(t, rate, attitude, by, error_covariance, noise, rates.bridged[fall])


def _since_release(t_s: float, rate_rad_s: FloatArray, rate_hz: float) -> tuple[Rotation, float]:
    """Compute the turn until the first sample and its variance, for samples missing after the release.

    A released body is taken to turn evenly.
    """
    if t_s <= GAP_PERIODS / rate_hz:
        return Rotation.identity(), 0.0
    turn = rate_rad_s * t_s
    # As of a rate that jumps anywhere in a hole: see `holes_of`.
    return Rotation.from_rotvec(turn), float(turn @ turn) / 12.0
