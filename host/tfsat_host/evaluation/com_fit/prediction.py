"""The model driven by the measured joint history, against the measured attitude; as its file has it, and corrected.

Nothing but the joints' motion and the momentum before the first stroke goes into the prediction. It is then passed
through the gyros' low-pass and integrated as the gyros' readings are, so that both sides have the same lag.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.angles import wrap_angle
from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.dynamics import spatial_momentum as conserved
from tfsat_host.dynamics.euler import euler_zyx_by_turn, euler_zyx_rad
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.evaluation.com_fit.momentum_residual import (
    Derivatives,
    FallSamples,
    inertial_momentum,
)
from tfsat_host.evaluation.motion.attitude import integrate_rates
from tfsat_host.evaluation.motion.gyro_signal import Lag


@dataclass(frozen=True, eq=False)
class Prediction:
    """What the base did by a model, at the m samples that it was driven with.

    Attributes:
        momentum_kg_m2_s: (3,) that it was given, inertial axes.
        rate_rad_s: (m, 3) of the base, base axes.
        attitude: (m, 3, 3) from base axes to those of the first sample.
    """

    momentum_kg_m2_s: FloatArray
    rate_rad_s: FloatArray
    attitude: FloatArray


def initial_momentum(body: Multibody, kinematics: FallSamples, quiet: BoolArray) -> FloatArray:
    """(3,) mean over the quiet samples before the first stroke, inertial axes."""
    return np.asarray(inertial_momentum(body, kinematics)[quiet].mean(axis=0))


def predict(body: Multibody, kinematics: FallSamples, momentum: FloatArray) -> Prediction:
    """Integrates w = I^-1 (R^T H - A q') along the measured joint history, by the trapezoid with one correction.

    `momentum` (3,) is H, inertial axes; `body` is one robot.
    """
    body = body.tilt_hinges(kinematics.tilt_rad)
    # Inertia and joint momentum follow from the joints alone: compute all samples at once.
    inverse = np.linalg.inv(conserved.locked_inertia(body, kinematics.angles_rad))
    joints = conserved.joint_momentum(body, kinematics.angles_rad) @ kinematics.joint_rate_rad_s[..., None]
    driven = -(inverse @ joints)[..., 0]
    rates, attitude = np.empty_like(driven), np.eye(3)
    for k in range(len(driven)):
        if k:
            step_s = kinematics.t_s[k] - kinematics.t_s[k - 1]
            # H is small: where it is seen from the last sample's attitude, it is off by a hundredth of itself.
            ahead = inverse[k] @ (attitude.T @ momentum) + driven[k]
            # Trapezoid, the rate at its end predicted with the attitude at its beginning.
            attitude = attitude @ Rotation.from_rotvec(0.5 * step_s * (rates[k - 1] + ahead)).as_matrix()
        rates[k] = inverse[k] @ (attitude.T @ momentum) + driven[k]
    # Integrate by the routine that integrates the gyros, so that both sides are treated alike.
    return Prediction(momentum, rates, integrate_rates(kinematics.t_s, rates).as_matrix())


@dataclass(frozen=True, eq=False)
class AttitudeError:
    """Measured less predicted attitude of one body, as the gyros see both.

    Attributes:
        t_s: (m,) after the release.
        euler_zyx_rad: (m, 3) Euler angles measured less predicted.
        rate_rad_s: (m, 3) rate measured less predicted, body axes.
        std_rad: (m, 3) of the Euler angles' difference, from everything that the sensors may be off.
        covariance: (3, 3) of the last one, rad^2.
    """

    t_s: FloatArray
    euler_zyx_rad: FloatArray
    rate_rad_s: FloatArray
    std_rad: FloatArray
    covariance: FloatArray

    @property
    def final_rad(self) -> FloatArray:
        """(3,) at the end."""
        return np.asarray(self.euler_zyx_rad[-1])

    @property
    def final_norm_rad(self) -> float:
        """The paper's figure: the norm of the three."""
        return float(np.linalg.norm(self.final_rad))

    @property
    def rms_rad(self) -> float:
        """Root mean square over time of that norm."""
        return float(np.sqrt((self.euler_zyx_rad**2).sum(axis=1).mean()))

    @property
    def z_scores(self) -> FloatArray:
        """(3,) the final error in units of its standard deviation."""
        return np.asarray(self.final_rad / self.std_rad[-1])

    @property
    def mahalanobis(self) -> float:
        """The final error's distance from zero in its own uncertainty: for three angles 2.8 holds 95 % of cases."""
        return float(np.sqrt(self.final_rad @ np.linalg.solve(self.covariance, self.final_rad)))


def attitude_error(
    prediction: Prediction,
    kinematics: FallSamples,
    rotation: FloatArray,
    body: int,
    lag: Lag,
    covariance: FloatArray,
) -> AttitudeError:
    """Compares one body.

    Args:
        prediction: Of the base.
        kinematics: What drove it.
        rotation: (m, 3, 3) from the body's axes to the base's.
        body: Index of the body.
        lag: Of the gyros.
        covariance: (m, 3, 3) by `difference_covariance`, of the same body.
    """
    measured_rates = kinematics.own.rate_rad_s[:, body]
    # The body's rate is the base's in its axes, and what the joints between them add.
    joint_part = np.einsum("nij,nj->ni", kinematics.own.gyro_map[:, body, :, 3:], kinematics.joint_rate_rad_s)
    exact = np.einsum("nji,nj->ni", rotation, prediction.rate_rad_s) + joint_part
    # Delay the model's rates by the gyros' low-pass, so that both sides have the same lag.
    predicted_rates = lag.apply(kinematics.t_s, exact)
    ours = integrate_rates(kinematics.t_s, measured_rates)
    theirs = integrate_rates(kinematics.t_s, predicted_rates)
    # Carry the covariance of a small rotation over to the Euler angles, at the predicted attitude.
    by_turn = euler_zyx_by_turn(theirs.as_matrix())
    spread = by_turn @ covariance @ by_turn.swapaxes(1, 2)
    difference = euler_zyx_rad(ours.as_matrix()) - euler_zyx_rad(theirs.as_matrix())
    # A floor of 1e-12 rad keeps quotients finite where a variance vanishes.
    std = np.sqrt(np.maximum(np.diagonal(spread, axis1=1, axis2=2), 1e-24))
    return AttitudeError(
        kinematics.t_s, wrap_angle(difference), measured_rates - predicted_rates, std, spread[-1]
    )


def difference_covariance(
    kinematics: FallSamples,
    rotation: FloatArray,
    body: int,
    linearization: Derivatives,
    errors: FloatArray,
    quiet: BoolArray,
    *,
    fitted: bool,
) -> FloatArray:
    """(m, 3, 3) of a body's measured less predicted attitude, its own axes at the first sample.

    To first order that difference is the integral of the base's unexplained rate and of what the body's own gyro shows
    against all gyros together. The momentum was taken from the quiet samples: an error that was there already is not
    counted twice.

    Args:
        kinematics: What drove the prediction.
        rotation: (m, 3, 3) from the body's axes to the base's.
        body: Index of the body.
        linearization: Derivatives of the unexplained rate.
        errors: Covariance of the sensors' errors (r, r), or of offsets and those (p + r, p + r) if `fitted`.
        quiet: Samples before the first stroke.
        fitted: The offsets were fitted to this drop; else the model is as it is.
    """
    own = kinematics.own
    own_errors = own.errors[:, body]
    columns = linearization.by_errors
    if fitted:
        columns = np.concatenate([linearization.by_offsets, columns], axis=2)
        own_errors = np.concatenate([np.zeros_like(linearization.by_offsets), own_errors], axis=2)
    # by_momentum = -I^-1 R^T, so its inverse turns a rate back into a momentum.
    to_momentum = np.linalg.inv(linearization.by_momentum[quiet])
    # A mean over the quiet samples: the momentum takes up the errors' mean effect there.
    momentum_by_errors = -np.einsum("nij,njk->ik", to_momentum, columns[quiet]) / quiet.sum()
    explained = columns + linearization.by_momentum @ momentum_by_errors
    # The time that each sample stands for; the attitude turns its rate into the first sample's axes.
    steps = np.gradient(kinematics.t_s)[:, None, None]
    to_first = kinematics.attitude * steps
    by_model, by_own = (np.cumsum(to_first @ part, axis=0) for part in (explained, rotation @ own_errors))
    # Noise adds up in variance: the base's unexplained rate, and the own gyro against all together.
    noise = (
        kinematics.attitude
        @ (linearization.noise + rotation @ own.noise[:, body] @ rotation.swapaxes(1, 2))
        @ kinematics.attitude.swapaxes(1, 2)
    )
    integrated = np.cumsum(noise * steps**2, axis=0)
    # The quiet samples' noise is in the momentum, too.
    by_taken = np.cumsum(to_first @ linearization.by_momentum, axis=0)
    of_taken = to_momentum @ linearization.noise[quiet] / quiet.sum()
    taken_covariance = (of_taken @ to_momentum.swapaxes(1, 2)).sum(axis=0) / quiet.sum()
    in_both = np.zeros_like(integrated)
    in_both[quiet] = -to_first[quiet] @ of_taken.swapaxes(1, 2)
    in_both = np.cumsum(in_both, axis=0) @ by_taken.swapaxes(1, 2)
    integrated = integrated + by_taken @ taken_covariance @ by_taken.swapaxes(1, 2)
    integrated = integrated + in_both + in_both.swapaxes(1, 2)
    # What a fit leaves over varies by less than the noise. The own gyro was fitted to all others before any model was.
    residual = by_model + by_own if fitted else by_own
    total = integrated - residual @ errors @ residual.swapaxes(1, 2)
    if not fitted:
        total = total + by_model @ errors @ by_model.swapaxes(1, 2)
    total = _at_least(total, LEFT_LEAST * integrated)
    # What both sides miss in a hole is alike in their rates, but the one is filtered with it and the other without.
    total = total + kinematics.missed[:, None, None] * np.eye(3)
    return np.asarray(rotation[0].T @ total @ rotation[0])


def _at_least(covariance: FloatArray, least: FloatArray) -> FloatArray:
    """(m, 3, 3) with no direction below the mean variance of `least` (m, 3, 3): differences of equal numbers round."""
    values, axes = np.linalg.eigh(0.5 * (covariance + covariance.swapaxes(1, 2)))
    values = np.maximum(values, np.trace(least, axis1=1, axis2=2)[:, None] / 3.0)
    return np.asarray((axes * values[:, None, :]) @ axes.swapaxes(1, 2))


LEFT_LEAST = 0.1
"""Of the integrated noise, what no fit can follow."""
