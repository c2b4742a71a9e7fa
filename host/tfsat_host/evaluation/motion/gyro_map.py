"""What each gyro sees of the base's rate and the joints' rates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses

FloatArray = NDArray[np.float64]


def gyro_map(body: Multibody, angles_rad: FloatArray) -> FloatArray:
    """(n, bodies, 3, 3 + joints): the rate of each body in its own axes, by base rate and joint rates.

    Args:
        body: The robot, seen from its base; the base rate is in base axes.
        angles_rad: (n, joints).
    """
    rotation, _ = poses(body, angles_rad)
    seen = np.zeros((*rotation.shape[:2], 3, 3 + body.n_joints))
    seen[..., :3] = rotation.swapaxes(-1, -2)
    for step in body.steps:
        axis = step.sign * np.einsum("nij,j->ni", rotation[:, step.parent], body.joint_axis[step.joint])
        for far in body.moved_by(step.joint):
            seen[:, far, :, 3 + step.joint] = np.einsum("nji,nj->ni", rotation[:, far], axis)
    return seen
