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
from numpy.typing import NDArray
from scipy.linalg import block_diag

from tfsat_host.dynamics import momentum as conserved
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.evaluation.attitude import integrate_rates
from tfsat_host.evaluation.model_fit.offsets import Offsets
from tfsat_host.evaluation.motion.fusion import fuse
from tfsat_host.evaluation.motion.motion import Motion

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

SETTLED_S = 0.03
"""After the release: before, the springs still push and the low-pass remembers the hold."""
_ANGLE_STEP_RAD = 1e-4
_OFFSET_STEP = 0.1


@dataclass(frozen=True, eq=False)
class Flown:
    """What the model is driven by and compared with, at m samples of the fall.

    Attributes:
        t_s: (m,) after the release.
        angles_rad: (m, 3) of the joints.
        joint_rate_rad_s: (m, 3).
        base_rate_rad_s: (m, 3) of the base, base axes, from all gyros.
        rate_covariance: (m, 6, 6) of base and joint rates, noise alone.
        attitude: (m, 3, 3) from base axes to those of the first sample.
        by_gyros: (m, 6, 36) base and joint rates by the gyros' parameters.
        by_angles: (m, 6, 3) base and joint rates by the joint angles that they were fused with.
        gyro_root: (36, r) of the parameters' covariance.
        angle_errors: (m, 3, k) joint angles by independent errors of variance one.
        own: What each body's own gyro says beside them.
    """

    t_s: FloatArray
    angles_rad: FloatArray
    joint_rate_rad_s: FloatArray
    base_rate_rad_s: FloatArray
    rate_covariance: FloatArray
    attitude: FloatArray
    by_gyros: FloatArray
    by_angles: FloatArray
    gyro_root: FloatArray
    angle_errors: FloatArray
    own: OwnGyros


@dataclass(frozen=True, eq=False)
class OwnGyros:
    """What each body's own gyro shows, and what in it the rates from all gyros leave over.

    Attributes:
        rate_rad_s: (m, 4, 3) as the gyros show it, late by their low-pass; bridged where one did not answer.
        seen: (m, 4, 3, 6) each body's rate by base and joint rates.
        by_gyros: (m, 4, 3, 36) what is left over, by the gyros' parameters.
        by_angles: (m, 4, 3, 3) the same by the joint angles.
        variance: (m, 4) of a sample.
        bridged: (m, 4) the gyro did not answer: nothing is left over.
    """

    rate_rad_s: FloatArray
    seen: FloatArray
    by_gyros: FloatArray
    by_angles: FloatArray
    variance: FloatArray
    bridged: BoolArray


def flown_of(motion: Motion, body: Multibody) -> Flown:
    """Collects from a motion what a model needs; `body` gives the joints' axes."""
    fall = motion.t_s >= SETTLED_S
    samples, fused = motion.samples, motion.fused
    n, bodies = samples.answered.shape
    own = np.zeros((n, bodies, 3, 9 * bodies))
    # What a wrong scale factor adds follows the rate at once: it is as late in the reading as the rate is.
    by_own = motion.lag.removed(motion.t_s, np.nan_to_num(samples.rate_jacobian))
    for b in range(bodies):
        own[:, b, :, 9 * b : 9 * b + 9] = np.where(~fused.bridged[:, b, None, None], by_own[:, b], 0.0)
    by_gyros = fused.gains @ own.reshape(n, 3 * bodies, -1)
    by_angles, left_by_angles = _by_angles(motion, body)
    bridged = fused.bridged[..., None, None]
    left_by_gyros = np.where(bridged, 0.0, own - fused.seen @ by_gyros[:, None])
    together = fused.body_rates()
    late = np.stack([motion.lag.applied(motion.t_s, together[:, b]) for b in range(bodies)], axis=1)
    shown = np.where(samples.answered[..., None], samples.rate_rad_s, late)
    return Flown(
        motion.t_s[fall],
        motion.angles_rad[fall],
        fused.joint_rate_rad_s[fall],
        fused.base_rate_rad_s[fall],
        fused.covariance[fall],
        integrate_rates(motion.t_s[fall], fused.base_rate_rad_s[fall]).as_matrix(),
        by_gyros[fall],
        by_angles[fall],
        np.asarray(block_diag(*[_root(c) for c in samples.parameter_covariance])),
        _angle_errors(motion)[fall],
        OwnGyros(
            shown[fall],
            fused.seen[fall],
            left_by_gyros[fall],
            np.where(bridged, 0.0, left_by_angles)[fall],
            motion.variance[fall],
            fused.bridged[fall],
        ),
    )


def _by_angles(motion: Motion, body: Multibody) -> tuple[FloatArray, FloatArray]:
    """(n, 6, 3) and (n, 4, 3, 3): what a wrong joint angle makes of rates that are carried over it, and of the rest."""
    rates = motion.fused.left_over_rad_s + motion.fused.body_rates()
    fused, left = [], []
    for joint in range(body.n_joints):
        ends = []
        for sign in (1.0, -1.0):
            angles = motion.angles_rad.copy()
            angles[:, joint] += sign * _ANGLE_STEP_RAD
            ends.append(
                fuse(body, angles, rates, motion.variance, motion.sensed_rate_rad_s, motion.sensed_variance)
            )
        high, low = ends
        base = high.base_rate_rad_s - low.base_rate_rad_s
        joints = high.joint_rate_rad_s - low.joint_rate_rad_s
        fused.append(np.concatenate([base, joints], axis=1))
        left.append(np.nan_to_num(high.left_over_rad_s - low.left_over_rad_s))
    scale = 2.0 * _ANGLE_STEP_RAD
    return np.stack(fused, axis=-1) / scale, np.stack(left, axis=-1) / scale


def _angle_errors(motion: Motion) -> FloatArray:
    parts = [joint.basis @ _root(joint.covariance) for joint in motion.joints]
    total = sum(part.shape[1] for part in parts)
    errors = np.zeros((len(motion.t_s), len(parts), total))
    start = 0
    for joint, part in enumerate(parts):
        errors[:, joint, start : start + part.shape[1]] = part
        start += part.shape[1]
    return errors


def _root(covariance: FloatArray) -> FloatArray:
    """(p, p) with root root^T = covariance, which may be singular."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def momentum_of(body: Multibody, flown: Flown) -> FloatArray:
    """(..., m, 3) total angular momentum about the center of mass, base axes; `body` may be a batch of robots."""
    inertia = conserved.locked_inertia(body, flown.angles_rad)
    joints = conserved.joint_momentum(body, flown.angles_rad)
    return np.asarray(
        np.einsum("...nij,nj->...ni", inertia, flown.base_rate_rad_s)
        + np.einsum("...nij,nj->...ni", joints, flown.joint_rate_rad_s)
    )


def inertial_momentum(body: Multibody, flown: Flown) -> FloatArray:
    """(..., m, 3) the same in inertial axes: constant, were model and measurement exact."""
    return np.asarray(np.einsum("nij,...nj->...ni", flown.attitude, momentum_of(body, flown)))


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Of the unexplained rate (m, 3), base axes.

    Attributes:
        by_offsets: (m, 3, p) in the offsets' units.
        by_momentum: (m, 3, 3).
        by_errors: (m, 3, r) by independent errors of variance one: the gyros' parameters, the joint angles.
        noise: (m, 3, 3) covariance of a sample.
    """

    by_offsets: FloatArray
    by_momentum: FloatArray
    by_errors: FloatArray
    noise: FloatArray


def unexplained(body: Multibody, flown: Flown, momentum: FloatArray) -> FloatArray:
    """(m, 3) rate of the base that the model with constant `momentum` (3,), inertial axes, does not explain."""
    left = momentum_of(body, flown) - flown.attitude.swapaxes(1, 2) @ momentum
    return np.asarray(
        np.linalg.solve(conserved.locked_inertia(body, flown.angles_rad), left[..., None])[..., 0]
    )


def derivatives(offsets: Offsets, vector: FloatArray, flown: Flown, momentum: FloatArray) -> Derivatives:
    """At offsets `vector` (p,) and momentum (3,), inertial axes.

    They are taken at the rates that the model predicts: with the measured ones, noise times itself would pull masses
    and inertias down together, which nothing but their prior holds.
    """
    left = unexplained(offsets.corrected(vector), flown, momentum)
    flown = replace(flown, base_rate_rad_s=flown.base_rate_rad_s - left)
    steps = _OFFSET_STEP * np.eye(len(offsets))
    ends = momentum_of(offsets.applied(np.concatenate([vector + steps, vector - steps])), flown)
    slope = (ends[: len(offsets)] - ends[len(offsets) :]) / (2.0 * _OFFSET_STEP)
    body = offsets.corrected(vector)
    inertia = conserved.locked_inertia(body, flown.angles_rad)
    inverse = np.linalg.inv(inertia)
    joints = inverse @ conserved.joint_momentum(body, flown.angles_rad)
    both = np.concatenate([np.broadcast_to(np.eye(3), inverse.shape), joints], axis=2)
    by_angles = both @ flown.by_angles + inverse @ _momentum_by_angles(body, flown)
    return Derivatives(
        np.einsum("nij,pnj->nip", inverse, slope),
        -inverse @ flown.attitude.swapaxes(1, 2),
        np.concatenate([both @ flown.by_gyros @ flown.gyro_root, by_angles @ flown.angle_errors], axis=2),
        both @ flown.rate_covariance @ both.swapaxes(1, 2),
    )


def _momentum_by_angles(body: Multibody, flown: Flown) -> FloatArray:
    """(m, 3, 3): momentum, base axes, by each joint angle at the same rates."""
    columns = []
    for joint in range(body.n_joints):
        ends = []
        for sign in (1.0, -1.0):
            angles = flown.angles_rad.copy()
            angles[:, joint] += sign * _ANGLE_STEP_RAD
            ends.append(momentum_of(body, replace(flown, angles_rad=angles)))
        columns.append((ends[0] - ends[1]) / (2.0 * _ANGLE_STEP_RAD))
    return np.stack(columns, axis=-1)
