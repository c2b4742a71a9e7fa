"""The part of the base's measured rate that the model does not explain, and what each uncertain number does to it.

With the momentum H constant, a model predicts the base's rate at every sample from the joints' motion alone:

    predicted = I(q)^-1 (R^T H - A(q) q'),    unexplained = measured - predicted = I^-1 (h - R^T H)

where h is the angular momentum that the model makes of the measured rates. That is the paper's momentum error, counted
in deg/s of the base instead of kg m^2/s: the weights are then those of the sensors. To first order the difference
between the measured and the predicted attitude is its integral, so one set of derivatives serves the fit of the
model and the uncertainty of the comparison.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import cumulative_trapezoid

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.statistics import root_of
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.spatial_momentum import angular_momentum, inertia_and_joint_momentum
from tfsat_host.evaluation.com_fit.offsets import Offsets
from tfsat_host.evaluation.com_fit.slopes import MovingBodies, momentum_slopes
from tfsat_host.evaluation.motion.attitude import integrate_rates
from tfsat_host.evaluation.motion.gyro_signal import smooth_rates
from tfsat_host.evaluation.motion.motion import SETTLED_S, Motion
from tfsat_host.evaluation.motion.samples import holes_of
from tfsat_host.evaluation.motion.sensor_fusion import FusionSolution

# Central differences: truncation goes by the square of the step, rounding by its inverse.
_ANGLE_STEP_RAD = 1e-4


@dataclass(frozen=True, eq=False)
class FallSamples:
    """What the model is driven by and compared with, at m samples of the fall.

    Attributes:
        t_s: (m,) after the release.
        angles_rad: (m, 3) of the joints.
        joint_rate_rad_s: (m, 3).
        base_rate_rad_s: (m, 3) of the base, base axes, from all gyros.
        rate_covariance: (m, 6, 6) of base and joint rates, noise alone.
        attitude: (m, 3, 3) from base axes to those of the first sample.
        removed_errors: (r,) the sensors' errors that have been removed.
        rate_errors: (m, 6, r) base and joint rates by the sensors' errors, which are independent and of variance one.
        angle_errors: (m, 3, r) joint angles by the same.
        sensor_errors: (r, r) what the errors are, by the same: first the gyros' parameters, 12 of each, then the two
            moments of their lag and what is the joint angles' own, in units of what they may be.
        tilt_rad: (3, 2) of the joints' axes, about the two directions `across` each.
        tilt_errors: (3, 2, r) those by the sensors' errors.
        missed: (m,) variance of the base's turn in holes of the samples, since the first, rad^2.
        own: What each body's own gyro shows besides.
    """

    t_s: FloatArray
    angles_rad: FloatArray
    joint_rate_rad_s: FloatArray
    base_rate_rad_s: FloatArray
    rate_covariance: FloatArray
    attitude: FloatArray
    removed_errors: FloatArray
    rate_errors: FloatArray
    angle_errors: FloatArray
    sensor_errors: FloatArray
    tilt_rad: FloatArray
    tilt_errors: FloatArray
    missed: FloatArray
    own: OwnGyros

    def correct(self, errors: FloatArray) -> FallSamples:
        """Return the drop with the sensors' errors (r,) removed to first order.

        The readings of each body's own gyro stay as they are.
        """
        # Only the change counts: what was taken off before stays off.
        off = errors - self.removed_errors
        rates = self.rate_errors @ off
        base = self.base_rate_rad_s + rates[:, :3]
        # All to first order but the attitude, in which a rate's error accumulates: integrate that anew.
        return replace(
            self,
            angles_rad=self.angles_rad + self.angle_errors @ off,
            joint_rate_rad_s=self.joint_rate_rad_s + rates[:, 3:],
            base_rate_rad_s=base,
            attitude=integrate_rates(self.t_s, base).as_matrix(),
            tilt_rad=self.tilt_rad + self.tilt_errors @ off,
            removed_errors=errors,
        )

    def turned_by(self, errors: FloatArray) -> float:
        """Return the greatest error of a joint angle that the errors (r,) would cause, rad."""
        return float(np.abs(self.angle_errors @ (errors - self.removed_errors)).max())


@dataclass(frozen=True, eq=False)
class OwnGyros:
    """What each body's own gyro shows, and what in it the rates from all gyros leave over.

    Attributes:
        rate_rad_s: (m, 4, 3) as the gyros show it, late by their low-pass; bridged where one did not answer.
        gyro_map: (m, 4, 3, 6) each body's rate by base and joint rates.
        errors: (m, 4, 3, r) what is left over, by the sensors' errors.
        noise: (m, 4, 3, 3) covariance of what is left over of a sample's noise, as the fusion counts it; 0 where the
            gyro did not answer.
    """

    rate_rad_s: FloatArray
    gyro_map: FloatArray
    errors: FloatArray
    noise: FloatArray


def flown_of(motion: Motion, errors: FloatArray | None = None) -> FallSamples:
    """Collects from a motion what a model needs, with errors (r,) of its sensors taken off in earnest."""
    # Column k is what the k-th independent error of variance one does.
    root = root_of(motion.solved.jacobians.covariance)
    if errors is None:
        errors, solved = np.zeros(len(root)), motion.solved
    else:
        # Not to first order: fuse again with corrected gyros, over the joint angles that follow.
        solved = motion.fusion.without(motion.solved, root @ errors)
    fall = motion.t_s >= SETTLED_S
    fused, jacobians, prior = solved.fused, solved.jacobians, motion.fusion.prior
    t, base = motion.t_s[fall], fused.base_rate_rad_s[fall]
    holes = holes_of(t, base, motion.samples.rate_hz)
    silent = fused.bridged[..., None, None]
    # An own gyro against all gyros together: its errors less those of the fused rate.
    relative_jacobians = np.where(silent[fall], 0.0, jacobians.gyros[fall] - jacobians.bodies[fall])
    # Least-squares residuals have the noise less the fitted value's covariance, as the gyro is in both.
    fused_covariance = fused.gyro_map @ fused.covariance[:, None] @ fused.gyro_map.swapaxes(2, 3)
    alone = motion.fusion.least_excess * np.where(silent, 0.0, motion.fusion.noise - fused_covariance)
    return FallSamples(
        t,
        solved.angles_rad[fall],
        fused.joint_rate_rad_s[fall],
        base,
        fused.covariance[fall],
        integrate_rates(t, base).as_matrix(),
        errors,
        _by_unit_errors(jacobians.rates[fall], root),
        _by_unit_errors(jacobians.angles[fall], root),
        prior.own_units @ root,
        prior.tilt_of(solved.errors),
        (prior.tilt[:, None] * root[prior.tilts]).reshape(-1, 2, len(root)),
        holes.variance_between(np.full_like(t, t[0]), t),
        OwnGyros(
            _corrected_gyro_rates(motion, solved)[fall],
            fused.gyro_map[fall],
            _by_unit_errors(relative_jacobians, root),
            alone[fall],
        ),
    )


def _by_unit_errors(by_errors: FloatArray, root: FloatArray) -> FloatArray:
    """Return derivatives (..., r) by errors of variance one; `root` (r, r) makes the errors of them."""
    return np.asarray((by_errors.reshape(-1, len(root)) @ root).reshape(by_errors.shape))


def _corrected_gyro_rates(motion: Motion, solved: FusionSolution) -> FloatArray:
    """(n, 4, 3) what each body's gyro shows without its errors, late as it is; by the others where it is silent."""
    rates = solved.fused.body_rates()
    # Pass the others' rates through the low-pass, so that bridged samples lag as the gyro's own do.
    late = [solved.lag.apply(motion.t_s, rates[:, b]) for b in range(rates.shape[1])]
    answered = motion.samples.answered[..., None]
    return np.where(answered, solved.late_rate_rad_s, np.stack(late, axis=1))


def momentum_of(body: Multibody, kinematics: FallSamples) -> FloatArray:
    """(..., m, 3) total angular momentum about the center of mass, base axes; `body` may be a batch of robots."""
    robot = body.tilt_hinges(kinematics.tilt_rad)
    return angular_momentum(
        robot, kinematics.angles_rad, kinematics.base_rate_rad_s, kinematics.joint_rate_rad_s
    )


def _momentum(inertia: FloatArray, joints: FloatArray, kinematics: FallSamples) -> FloatArray:
    of_base = np.einsum("...nij,nj->...ni", inertia, kinematics.base_rate_rad_s)
    return np.asarray(of_base + np.einsum("...nij,nj->...ni", joints, kinematics.joint_rate_rad_s))


def inertial_momentum(body: Multibody, kinematics: FallSamples) -> FloatArray:
    """(..., m, 3) the same in inertial axes: constant, were model and measurement exact."""
    return np.asarray(np.einsum("nij,...nj->...ni", kinematics.attitude, momentum_of(body, kinematics)))


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Of the unexplained rate (m, 3), base axes.

    Attributes:
        by_offsets: (m, 3, p) in the offsets' units.
        by_momentum: (m, 3, 3).
        by_errors: (m, 3, r) by the sensors' errors, which are independent and of variance one.
        noise: (m, 3, 3) covariance of a sample.
        residual_rad_s: (m, 3) the rate itself.
    """

    by_offsets: FloatArray
    by_momentum: FloatArray
    by_errors: FloatArray
    noise: FloatArray
    residual_rad_s: FloatArray


def residual_rate(body: Multibody, kinematics: FallSamples, momentum: FloatArray) -> FloatArray:
    """(m, 3) rate of the base that the model with constant `momentum` (3,), inertial axes, does not explain."""
    return _residual(body, kinematics, momentum)[2]


def _residual(
    body: Multibody, kinematics: FallSamples, momentum: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Locked inertia (m, 3, 3), momentum by joint rates (m, 3, joints), and the unexplained rate (m, 3)."""
    inertia, of_joints = inertia_and_joint_momentum(
        body.tilt_hinges(kinematics.tilt_rad), kinematics.angles_rad
    )
    # Turn the constant momentum into base axes, and what is left over into a rate of the base.
    measured = _momentum(inertia, of_joints, kinematics)
    residual_momentum = measured - kinematics.attitude.swapaxes(1, 2) @ momentum
    rate = np.linalg.solve(inertia, residual_momentum[..., None])[..., 0]
    return inertia, of_joints, np.asarray(rate, dtype=np.float64)


def derivatives(
    offsets: Offsets, vector: FloatArray, kinematics: FallSamples, momentum: FloatArray
) -> Derivatives:
    """Compute the derivatives at offsets `vector` (p,) and momentum (3,), inertial axes.

    They are taken at smoothed rates, for the base those that the model predicts: see `smooth_rates`.
    """
    body = offsets.correct(vector)
    inertia, of_joints, rate = _residual(body, kinematics, momentum)
    # The inverse of the locked inertia turns momentum into the base's rate, (m, 3, 3).
    inverse = np.linalg.inv(inertia)
    # Take the slopes at the predicted rate, smoothed: noise in columns would count as information.
    kinematics = replace(
        kinematics,
        base_rate_rad_s=smooth_rates(kinematics.base_rate_rad_s - rate),
        joint_rate_rad_s=smooth_rates(kinematics.joint_rate_rad_s),
    )
    moving = MovingBodies.of(
        body.tilt_hinges(kinematics.tilt_rad),
        kinematics.angles_rad,
        kinematics.base_rate_rad_s,
        kinematics.joint_rate_rad_s,
    )
    # The unexplained rate follows the base's rate one to one, and each joint's by I^-1 A.
    joints = inverse @ of_joints
    both = np.concatenate([np.broadcast_to(np.eye(3), inverse.shape), joints], axis=2)
    # By the pose only the momentum's slope counts: h - R^T H all but vanishes at the predicted rate.
    by_angles = inverse @ _momentum_by(body, kinematics, "angles_rad", np.eye(body.n_joints)[:, None])
    # One tilt a robot: (6, 1, joints, 2), the second axis for the samples.
    tilts = np.eye(kinematics.tilt_rad.size).reshape(-1, 1, *kinematics.tilt_rad.shape)
    by_each_tilt = _momentum_by(body, kinematics, "tilt_rad", tilts)
    by_tilts = inverse @ np.tensordot(by_each_tilt, kinematics.tilt_errors.reshape(len(tilts), -1), 1)
    # An error that turns the attitude turns the momentum in base axes.
    turned = cumulative_trapezoid(
        kinematics.attitude @ kinematics.rate_errors[:, :3], kinematics.t_s, axis=0, initial=0
    )
    by_momentum = -inverse @ kinematics.attitude.swapaxes(1, 2)
    # A small rotation v of the attitude, inertial axes, changes R^T H by R^T (H x v).
    by_attitude = by_momentum @ np.cross(momentum, np.eye(3), axisb=0, axisc=0)
    # Chain rule: (m, 3, 12) by rates, joint angles and attitude, times (m, 12, r) of those by the errors.
    by_all = np.concatenate([both, by_angles, by_attitude], axis=2)
    return Derivatives(
        inverse @ momentum_slopes(offsets, vector, moving),
        by_momentum,
        by_all @ np.concatenate([kinematics.rate_errors, kinematics.angle_errors, turned], axis=1) + by_tilts,
        both @ kinematics.rate_covariance @ both.swapaxes(1, 2),
        rate,
    )


def _momentum_by(body: Multibody, kinematics: FallSamples, name: str, steps: FloatArray) -> FloatArray:
    """(m, 3, k): momentum, base axes, at the same rates, by `name`, angles or tilts of joints.

    `steps` are k unit steps of them, each broadcast over the samples.
    """
    angles = getattr(kinematics, name)
    # A batch of k robots, one number moved in each.
    high, low = (
        momentum_of(body, replace(kinematics, **{name: angles + sign * _ANGLE_STEP_RAD * steps}))
        for sign in (1.0, -1.0)
    )
    return np.asarray(np.moveaxis((high - low) / (2.0 * _ANGLE_STEP_RAD), 0, -1))
