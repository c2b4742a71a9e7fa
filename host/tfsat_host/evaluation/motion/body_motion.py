"""The attitude of one body over the fall: its rates integrated, and what is uncertain about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tfsat_host.evaluation.attitude import integrate_rates
from tfsat_host.evaluation.motion.lag import derivative

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

GAP_PERIODS = 1.5
"""A step longer than so many sampling periods has samples missing in it."""
_NEAR_GAP_S = 0.1


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """One body at m samples from the release on; inertial axes are its own at the first of them.

    Attributes:
        t_s: (m,) after the release.
        rate_rad_s: (m, 3) body axes, the gyro's lag taken off.
        attitude: m rotations, from body axes to inertial axes.
        by_parameters: (m, 3, p) the attitude's error, inertial axes, by errors of the gyros' parameters.
        parameter_covariance: (p, p) of those.
        noise_covariance: (m, 3, 3) of the attitude from noise and gaps.
        bridged: (m,) its own gyro did not answer.
    """

    t_s: FloatArray
    rate_rad_s: FloatArray
    attitude: Rotation
    by_parameters: FloatArray
    parameter_covariance: FloatArray
    noise_covariance: FloatArray
    bridged: BoolArray

    def covariance(self, index: int = -1) -> FloatArray:
        """(3, 3) of the attitude at a sample, a rotation vector in inertial axes, rad^2."""
        by = self.by_parameters[index]
        return np.asarray(by @ self.parameter_covariance @ by.T + self.noise_covariance[index])

    def reorientation_rad(self, index: int = -1) -> tuple[float, float]:
        """How far it has turned since the release, and the standard deviation of that."""
        turn = self.attitude[index].as_rotvec()
        angle = float(np.linalg.norm(turn))
        # Without a turn any direction is as good as another: the worst one tells.
        if angle < 1e-9:
            return angle, float(np.sqrt(np.linalg.eigvalsh(self.covariance(index)).max()))
        axis = turn / angle
        return angle, float(np.sqrt(axis @ self.covariance(index) @ axis))


@dataclass(frozen=True, eq=False)
class Rates:
    """Rates of one body at n samples and what they rest on.

    Attributes:
        rate_rad_s: (n, 3) body axes.
        jacobian: (n, 3, p) by the gyros' parameters.
        variance: (n, 3, 3) of each sample's noise.
        bridged: (n,) from other bodies' gyros.
    """

    rate_rad_s: FloatArray
    jacobian: FloatArray
    variance: FloatArray
    bridged: BoolArray


def body_motion(
    t_s: FloatArray, rates: Rates, parameter_covariance: FloatArray, rate_hz: float
) -> BodyMotion:
    """Integrates from the first sample after the release.

    Args:
        t_s: (n,) after the release.
        rates: At those times.
        parameter_covariance: (p, p).
        rate_hz: Sampling rate as commanded: longer steps have samples missing.
    """
    fall = t_s >= 0.0
    t, rate = t_s[fall], rates.rate_rad_s[fall]
    attitude = integrate_rates(t, rate)
    matrices = attitude.as_matrix()
    steps = np.diff(t)
    by_rates = matrices @ rates.jacobian[fall]
    by = np.concatenate([np.zeros((1, *by_rates.shape[1:])), _integral(by_rates, steps)])
    turned = matrices @ rates.variance[fall] @ matrices.swapaxes(1, 2)
    weights = np.gradient(t)
    noise = np.cumsum(turned * (weights**2)[:, None, None], axis=0)
    noise = noise + np.concatenate([[0.0], np.cumsum(_gap_variance(t, rate, rate_hz))])[
        :, None, None
    ] * np.eye(3)
    return BodyMotion(t, rate, attitude, by, parameter_covariance, noise, rates.bridged[fall])


def _integral(values: FloatArray, steps: FloatArray) -> FloatArray:
    return np.asarray(np.cumsum(0.5 * (values[1:] + values[:-1]) * steps[:, None, None], axis=0))


def _gap_variance(t_s: FloatArray, rate_rad_s: FloatArray, rate_hz: float) -> FloatArray:
    """(m - 1,) of the turn in each step: the trapezoid over g misses a g^2 / 12 of a rate that bends by a g once."""
    steps = np.diff(t_s)
    variance = np.zeros_like(steps)
    change = np.linalg.norm(derivative(t_s, rate_rad_s), axis=1)
    for gap in np.flatnonzero(steps > GAP_PERIODS / rate_hz):
        near = np.abs(t_s - t_s[gap]) < _NEAR_GAP_S + steps[gap]
        variance[gap] = (change[near].max() * steps[gap] ** 2 / 12.0) ** 2
    return variance
