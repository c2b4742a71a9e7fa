"""One base rate and one rate for each joint at every sample, from all gyros that answered.

Four gyros measure twelve numbers at each sample, and the robot has six: the base's rate and three joint rates. They
follow by least squares; what is left over, neighbours that contradict each other off their joint's axis, belongs to
no motion and checks the sensors. Where a gyro did not answer, the others bridge it; where its joint's rate would
then be unknown, the angle sensors give that, less well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray
from tfsat_host.dynamics.multibody import Multibody, across
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.motion.gyro_signal import smooth_rates
from tfsat_host.evaluation.motion.samples import Blocks


@dataclass(frozen=True, eq=False)
class FusedRates:
    """Rates at n samples.

    Attributes:
        base_rate_rad_s: (n, 3) of the base, base axes.
        joint_rate_rad_s: (n, 3).
        covariance: (n, 6, 6) of both, from the noise given.
        by_slopes: (n, 3) how much of a joint's rate is the angle sensors': 0 if gyros tell it, 1 if they do not.
        gains: (n, 6, 12) what each gyro's number has to do with them.
        gyro_map: (n, 4, 3, 6) what each gyro sees of them (`gyro_map`).
        residual_rad_s: (n, 4, 3) reading less what the fused rates explain, body axes; NaN without a reading.
        bridged: (n, 4) the gyro did not answer: its body's rate is from the others.
    """

    base_rate_rad_s: FloatArray
    joint_rate_rad_s: FloatArray
    covariance: FloatArray
    by_slopes: FloatArray
    gains: FloatArray
    gyro_map: FloatArray
    residual_rad_s: FloatArray
    bridged: BoolArray

    @property
    def rates(self) -> FloatArray:
        """(n, 6) of base and joints."""
        return np.concatenate([self.base_rate_rad_s, self.joint_rate_rad_s], axis=1)

    def body_rates(self) -> FloatArray:
        """(n, 4, 3) of each body in its own axes, by all gyros together."""
        return np.asarray(np.einsum("nbij,nj->nbi", self.gyro_map, self.rates))


def fuse(
    body: Multibody,
    angles_rad: FloatArray,
    rates_rad_s: FloatArray,
    noise: FloatArray,
    sensed_rate_rad_s: FloatArray,
    sensed_variance: FloatArray,
) -> FusedRates:
    """Fuse the rates of all gyros by least squares at each sample.

    Args:
        body: The robot, seen from its base.
        angles_rad: (n, 3) of the joints.
        rates_rad_s: (n, 4, 3) body axes; NaN where a gyro did not answer, and one did at every sample.
        noise: (n, 4, 3, 3) covariance of each gyro's sample.
        sensed_rate_rad_s: (n, 3) joint rates by the angle sensors, used where a gyro is missing.
        sensed_variance: (3,) variances of `sensed_rate_rad_s`.
    """
    n, bodies = rates_rad_s.shape[:2]
    answered = np.logical_and.reduce(np.isfinite(rates_rad_s), axis=2)
    gyro_jacobian = gyro_map(body, angles_rad)
    design = gyro_jacobian.reshape(n, 3 * bodies, -1)
    information: FloatArray = np.where(answered[..., None, None], np.linalg.inv(noise), 0.0)
    weighted = (information @ gyro_jacobian).reshape(design.shape)
    # Normal equations of six unknowns at each sample, (n, 6, 6).
    normal = design.swapaxes(1, 2) @ weighted
    # The angle sensors' slopes are worse than gyros: use them only where one is missing.
    joint_weights = np.where(answered.all(axis=1)[:, None], 0.0, 1.0 / sensed_variance)
    joints = np.arange(3, 3 + body.n_joints)
    normal[:, joints, joints] += joint_weights
    inverse = np.asarray(np.linalg.inv(normal), dtype=np.float64)
    gains = inverse @ weighted.swapaxes(1, 2)
    readings = np.where(answered[..., None], rates_rad_s, 0.0).reshape(n, -1)
    both = np.einsum("nij,nj->ni", gains, readings)
    # The slopes measure joint rates themselves: they enter by the joints' columns of the inverse.
    both += np.einsum("nij,nj->ni", inverse[:, :, 3:], joint_weights * np.nan_to_num(sensed_rate_rad_s))
    explained = np.einsum("nij,nj->ni", design, both).reshape(n, bodies, 3)
    return FusedRates(
        both[:, :3],
        both[:, 3:],
        inverse,
        inverse[:, joints, joints] * joint_weights,
        gains,
        gyro_jacobian,
        rates_rad_s - explained,
        ~answered,
    )


def gyro_map(body: Multibody, angles_rad: FloatArray) -> FloatArray:
    """(n, bodies, 3, 3 + joints): the rate of each body in its own axes, by base rate and joint rates.

    The robot is seen from its base; the base rate is in base axes. Angles are (n, joints).
    """
    rotation, _ = poses(body, angles_rad)
    jacobian = np.zeros((*rotation.shape[:2], 3, 3 + body.n_joints))
    # Every body has the base's rate, in its own axes; a joint adds its axis to all bodies beyond.
    jacobian[..., :3] = rotation.swapaxes(-1, -2)
    for step in body.steps:
        axis = step.sign * np.einsum("nij,j->ni", rotation[:, step.parent], body.joint_axis[step.joint])
        for far in body.moved_by(step.joint):
            jacobian[:, far, :, 3 + step.joint] = np.einsum("nji,nj->ni", rotation[:, far], axis)
    return jacobian


# Central differences of sines and cosines: the truncation stays below 1e-8.
_STEP_RAD = 1e-4


def rates_by_angles(
    body: Multibody, angles_rad: FloatArray, fused: FusedRates, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """(n, 6, 3) base and joint rates, and (n, 4, 3, 3) the bodies' rates that follow, by the joint angles.

    With x = P D^T W r, D the map from x to the gyros, dx = P dD^T W (r - D x) - P D^T W dD x.

    Arguments as of `fuse`; `fused` are its rates over these angles.
    """
    n, joints = angles_rad.shape
    steps = _STEP_RAD * np.concatenate([np.eye(joints), -np.eye(joints)])
    high, low = gyro_map(body, (angles_rad + steps[:, None]).reshape(-1, joints)).reshape(
        2, joints, n, *fused.gyro_map.shape[1:]
    )
    # dD by each joint, (joints, n, 12, 6).
    turned = (high - low).reshape(joints, n, -1, 3 + joints) / (2.0 * _STEP_RAD)
    # W (r - D x); a silent gyro has no residual.
    weighted = np.linalg.solve(noise, np.nan_to_num(fused.residual_rad_s)[..., None]).reshape(n, -1)
    # dD x, (n, 12, joints).
    direct = np.moveaxis(turned @ fused.rates[..., None], 0, -1)[:, :, 0]
    both = fused.covariance @ np.einsum("knij,ni->njk", turned, weighted) - fused.gains @ direct
    bodies = direct.reshape(*fused.gyro_map.shape[:3], joints) + fused.gyro_map @ both[:, None]
    return both, bodies


def bodies_by_tilts(body: Multibody, angles_rad: FloatArray, fused: FusedRates) -> FloatArray:
    """(n, 4, 3, 6) the bodies' rates in their own axes by tilts of the axes, base and joint rates as they are.

    A tilt u of the axis a of a joint with rate q', its outer body c and that body's rate w, base axes: all bodies
    beyond turn by f = R_p u - R_c u, and in their axes their rates change by q' R_p (u x a) - f x w.

    Arguments as of `fuse`; `fused` are its rates over these angles.
    """
    rotation, _ = poses(body, angles_rad)
    # Smoothed: with a sample's noise in them columns would correlate with what they are to explain.
    rates, joint_rate = smooth_rates(fused.body_rates()), smooth_rates(fused.joint_rate_rad_s)
    out = np.zeros((*rates.shape, 2 * body.n_joints))
    for step in body.steps:
        parent, child = rotation[:, step.parent], rotation[:, step.child]
        rate = np.einsum("nij,nj->ni", child, rates[:, step.child])
        spin = step.sign * joint_rate[:, step.joint, None]
        axis = body.joint_axis[step.joint]
        # Two effects of a tilt: the joint spins about another axis, and all beyond it are turned.
        for side, tilt in enumerate(across(axis)):
            turned = spin * (parent @ np.cross(tilt, axis)) - np.cross((parent - child) @ tilt, rate)
            for far in body.moved_by(step.joint):
                out[:, far, :, 2 * step.joint + side] = np.einsum("nji,nj->ni", rotation[:, far], turned)
    return out


_BLOCK_S = 0.1
"""What is left over is not noise within so long."""


def information_by_neighbours(
    t_s: FloatArray,
    fused: FusedRates,
    left_by_errors: FloatArray,
    noise: FloatArray,
    errors: FloatArray,
    free: BoolArray,
    least_excess: float,
) -> tuple[FloatArray, FloatArray]:
    """(r, r) information on the errors in the fall, and (r,) the right-hand side to go with it.

    What no motion of the robot explains would be noise, were the errors right. Where more is left, frames that give
    have their part in it, and all of it counts that much less.

    Args:
        t_s: (n,) after the release; what comes before it tells nothing.
        fused: Rates with the errors as believed.
        left_by_errors: (n, 4, 3, r) what more of them does to what is left over.
        noise: (n, 4, 3, 3) covariance of a gyro's sample.
        errors: (r,) as believed.
        free: (r,) which ones may be estimated.
        least_excess: What is left counts as so many times its noise at least.
    """
    fall = t_s >= 0.0
    n, r = int(fall.sum()), len(errors)
    bridged = fused.bridged[fall]
    # Whiten each gyro's three rows; a silent one has none.
    whitening = np.where(bridged[..., None, None], 0.0, np.linalg.inv(np.linalg.cholesky(noise[fall])))
    residuals = (whitening @ np.nan_to_num(fused.residual_rad_s[fall])[..., None]).reshape(n, -1)
    rows = (whitening @ left_by_errors[fall]).reshape(n, -1, r) * free
    flat = rows.reshape(-1, r)
    normal, pull = flat.T @ flat, flat.T @ residuals.ravel()
    # The errors that are yet to be found explain a part of it.
    residuals = residuals + rows @ np.linalg.solve(normal + np.eye(r), -pull - errors)
    # Discount it all by what is left over: ringing frames correlate samples, see `Blocks.excess`.
    excess = max(least_excess, Blocks.of(t_s[fall], _BLOCK_S).excess(rows, residuals, normal, np.eye(r)))
    # The right-hand side is for absolute errors, not for a step from those believed.
    return normal / excess, (normal @ errors - pull) / excess
