"""Where the bodies' frames were about the robot's center of mass, which in free fall stays where it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.report.contents.attitudes import settled
from tfsat_host.report.contents.chart import padded
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BodyPoses:
    """All b bodies at k samples from the release on; inertial axes are those of the base at the first of them.

    Attributes:
        t_s: (k,) after the release.
        measured: (k, b, 7) origin of each body's frame from the robot's CoM, m, and its quaternion x y z w. Attitude by
            the base's gyro, angles by gyros and angle sensors, CoM by the corrected model.
        predicted: (k, b, 7) the same by the model as its file has it, driven by the measured joint angles; NaN until
            the release has settled.
    """

    t_s: FloatArray
    measured: FloatArray
    predicted: FloatArray


def body_poses(found: Evaluation) -> BodyPoses:
    """Of one drop."""
    moved = found.motion.bodies[found.model.base]
    angles = found.motion.angles_rad[found.motion.samples.fall]
    attitude = moved.attitude.as_matrix()
    driven = settled(found)
    offsets, sides = found.explained.driven.offsets, found.explained.before
    predicted = attitude[driven][0] @ sides.prediction.attitude
    ghost = _placed(offsets.body, found.model, angles[driven], predicted)
    corrected = offsets.corrected(found.explained.fit.values)
    return BodyPoses(moved.t_s, _placed(corrected, found.model, angles, attitude), padded(driven, ghost))


def _placed(body: Multibody, model: RobotModel, angles_rad: FloatArray, attitude: FloatArray) -> FloatArray:
    """(k, b, 7) of joint angles (k, joints) and attitudes (k, 3, 3) of the base."""
    rotation, translation = poses(body, angles_rad)
    com = np.einsum("kbij,bj->kbi", rotation, body.com_m) + translation
    center = np.einsum("b,kbi->ki", body.mass_kg / body.mass_kg.sum(), com)
    origin = np.einsum("kbij,bj->kbi", rotation, model.origin_m) + translation - center[:, None]
    turned = attitude[:, None] @ rotation
    quaternion = Rotation.from_matrix(turned.reshape(-1, 3, 3)).as_quat().reshape(*turned.shape[:2], 4)
    return np.concatenate([np.einsum("kij,kbj->kbi", attitude, origin), quaternion], axis=2)
