"""Where the robot's center of mass lies in each body, and from there to each IMU."""

from __future__ import annotations

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.robot import RobotModel


def com_in_bodies_m(model: RobotModel, joint_angles_rad: FloatArray) -> FloatArray:
    """(n, 3) the whole robot's CoM in the frame of each of its n bodies.

    Args:
        model: The robot.
        joint_angles_rad: (n - 1,) as they stand.
    """
    tree = Multibody.of(model)
    rotation, translation = poses(tree, np.asarray(joint_angles_rad, dtype=np.float64))
    com = np.einsum("nij,nj->ni", rotation, tree.com_m) + translation
    center = tree.mass_kg @ com / tree.mass_kg.sum()
    # A body's point x, global at zero angles, lies at rotation x + translation; its own frame starts at origin_m.
    at_zero_angles = np.einsum("nji,nj->ni", rotation, center - translation)
    return np.asarray(at_zero_angles - model.origin_m)


def sensor_arms_m(model: RobotModel, joint_angles_rad: FloatArray) -> FloatArray:
    """(4, 3) from the robot's CoM to the IMU of bodies 1 to 4, axes of the IMU's body; arguments as above."""
    center = com_in_bodies_m(model, joint_angles_rad)
    arms = np.full((len(model.imus), 3), np.nan)
    for imu in model.imus:
        arms[imu.body] = imu.position_m - center[imu.body]
    return arms
