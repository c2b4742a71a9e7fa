"""One base rate and one rate for each joint at every sample, from all gyros that answered.

Four gyros measure twelve numbers at each sample, and the robot has six: the base's rate and three joint rates. They
follow by least squares; what is left over, neighbours that contradict each other off their joint's axis, belongs to
nobody's motion and checks the sensors. Where a gyro did not answer, the others bridge it; where its joint's rate would
then be unknown, the angle sensors give that, less well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.evaluation.motion.gyro_map import gyro_map

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Fused:
    """Rates at n samples.

    Attributes:
        base_rate_rad_s: (n, 3) of the base, base axes.
        joint_rate_rad_s: (n, 3).
        covariance: (n, 6, 6) of both, from the noise given.
        by_slopes: (n, 3) how much of a joint's rate is the angle sensors': 0 if gyros tell it, 1 if they do not.
        gains: (n, 6, 12) what each gyro's number has to do with them.
        seen: (n, 4, 3, 6) what each gyro sees of them (`gyro_map`).
        left_over_rad_s: (n, 4, 3) reading less what the fused rates explain, body axes; NaN without a reading.
        bridged: (n, 4) the gyro did not answer: its body's rate is from the others.
    """

    base_rate_rad_s: FloatArray
    joint_rate_rad_s: FloatArray
    covariance: FloatArray
    by_slopes: FloatArray
    gains: FloatArray
    seen: FloatArray
    left_over_rad_s: FloatArray
    bridged: BoolArray

    def body_rates(self) -> FloatArray:
        """(n, 4, 3) of each body in its own axes, as all gyros together tell it."""
        both = np.concatenate([self.base_rate_rad_s, self.joint_rate_rad_s], axis=1)
        return np.asarray(np.einsum("nbij,nj->nbi", self.seen, both))


def fuse(
    body: Multibody,
    angles_rad: FloatArray,
    rates_rad_s: FloatArray,
    variance: FloatArray,
    sensed_rate_rad_s: FloatArray,
    sensed_variance: FloatArray,
) -> Fused:
    """Least squares at each sample.

    Args:
        body: The robot, seen from its base.
        angles_rad: (n, 3) of the joints.
        rates_rad_s: (n, 4, 3) body axes; NaN where a gyro did not answer, and one did at every sample.
        variance: (n, 4) of each axis of a gyro.
        sensed_rate_rad_s: (n, 3) joint rates by the angle sensors, used where a gyro is missing.
        sensed_variance: (3,) of those.
    """
    n, bodies = rates_rad_s.shape[:2]
    answered = np.logical_and.reduce(np.isfinite(rates_rad_s), axis=2)
    seen = gyro_map(body, angles_rad)
    design = seen.reshape(n, 3 * bodies, -1)
    weights = np.repeat(np.where(answered, 1.0 / variance, 0.0), 3, axis=1)
    weighted = design * weights[..., None]
    normal = design.swapaxes(1, 2) @ weighted
    joint_weights = np.where(answered.all(axis=1)[:, None], 0.0, 1.0 / sensed_variance)
    joints = np.arange(3, 3 + body.n_joints)
    normal[:, joints, joints] += joint_weights
    inverse = np.linalg.inv(normal)
    gains = inverse @ weighted.swapaxes(1, 2)
    readings = np.where(answered[..., None], rates_rad_s, 0.0).reshape(n, -1)
    both = np.einsum("nij,nj->ni", gains, readings)
    both += np.einsum("nij,nj->ni", inverse[:, :, 3:], joint_weights * np.nan_to_num(sensed_rate_rad_s))
    explained = np.einsum("nij,nj->ni", design, both).reshape(n, bodies, 3)
    return Fused(
        both[:, :3],
        both[:, 3:],
        inverse,
        inverse[:, joints, joints] * joint_weights,
        gains,
        seen,
        rates_rad_s - explained,
        ~answered,
    )
