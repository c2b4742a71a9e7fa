"""A recorded swing or sweep by what is known so far: rates, joint angles, and the axes that the bodies turn about."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, joint_angles, sensor_columns
from tfsat_host.calibration.steps.sensor_samples import SensorSamples
from tfsat_host.calibration.steps.step import Step
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.robot import RobotModel

UNKNOWN_ZERO_STD_RAD = np.deg2rad(1.0)
"""How far a joint may be from closed where the step begins, if its zero was not calibrated."""
_ANGLE_STD_RAD = np.deg2rad(0.05)


@dataclass(frozen=True, eq=False)
class Motion:
    """A swing or a sweep.

    Attributes:
        step: What was moved and held.
        recording: In SI units.
        gyros: What is known of them.
        joints: What is known of the angle sensors.
        model: The robot.
    """

    step: Step
    recording: SensorSamples
    gyros: Sequence[GyroCalibration]
    joints: Sequence[JointSensors]
    model: RobotModel

    @cached_property
    def held(self) -> int:
        """The held body (1 to 4) that the joint joins to the moved ones: a hand never holds it quite still."""
        joint = self.step.moving_joint - 1
        ends = (int(self.model.joint_inner[joint]) + 1, int(self.model.joint_outer[joint]) + 1)
        return next(body for body in ends if body in self.step.held)

    @cached_property
    def angle_rad(self) -> FloatArray:
        """(n, n_joints) joint angles."""
        return joint_angles(self.recording.sensor_angle_rad, self.joints, self.model)

    @cached_property
    def joint_rate_rad_s(self) -> FloatArray:
        """(n,) of the joint that is moved, by its angle sensors."""
        return np.gradient(self.angle_rad[:, self.step.moving_joint - 1], self.recording.t_s)

    @cached_property
    def _tree(self) -> Multibody:
        """The robot from the held body outwards."""
        return Multibody.of(self.model, self.held - 1)

    @cached_property
    def _to_held(self) -> FloatArray:
        """(n, n_bodies, 3, 3) from the axes of each body to those of the held one."""
        return poses(self._tree, self.angle_rad)[0]

    def readings(self, body: int) -> FloatArray:
        """(n, 3) of a moved body (1 to 4), less bias and less what the held body's motion adds, sensor axes."""
        gyro, rates = self.gyros[body - 1], self.recording.rate_rad_s
        held_rate = self.gyros[self.held - 1].body_rates(rates[:, self.held - 1])
        # The held body's rate in the moved body's axes; "nji,nj" applies the transposed rotations.
        carried = np.einsum("nji,nj->ni", self._to_held[:, body - 1], held_rate)
        return np.asarray(rates[:, body - 1] - gyro.bias_rad_s - gyro.readings(carried))

    def sense(self, joint: int | None = None) -> float:
        """+1 where the bodies beyond a joint (1 to 3; None: the one that is moved) turn about its axis as it opens."""
        joint_index = (joint or self.step.moving_joint) - 1
        return next(step.sign for step in self._tree.steps if step.joint == joint_index)

    def axis(self, body: int) -> FloatArray:
        """(3,) the axis in the body's axes about which it turns, unit vector.

        The joint's, and a little of those between, where a joint that should stay closed follows the motion.
        """
        joint = self.step.moving_joint
        axis = self._joint_axis(joint, body)
        for between in self._between(body):
            # Slope of this joint's angle on the moved one's: by this share it turns along.
            follows = np.polyfit(self.angle_rad[:, joint - 1], self.angle_rad[:, between - 1], 1)[0]
            # Both joints' senses, so that the shares add up as rotations of the outer bodies.
            side = self.sense() * self.sense(between)
            axis = axis + side * follows * self._joint_axis(between, body)
        return np.asarray(axis / np.linalg.norm(axis))

    def _joint_axis(self, joint: int, body: int) -> FloatArray:
        """(3,) a joint's axis in the body's axes, as they are while it moves: so does a fitted line weigh it."""
        inner = int(self.model.joint_inner[joint - 1])
        axes = self._to_held[:, inner] @ self.model.joint_axis[joint - 1]
        # Total least squares weighs a sample by its squared rate: so must the expected axis.
        weighed = self.joint_rate_rad_s[:, None] ** 2 * axes
        mean = np.einsum("nji,nj->i", self._to_held[:, body - 1], weighed)
        return np.asarray(mean / np.linalg.norm(mean))

    def _between(self, body: int) -> list[int]:
        """Joints (1 to 3) between the body and the joint that is moved."""
        return [
            step.joint + 1
            for step in self._tree.steps
            if step.joint != self.step.moving_joint - 1 and body - 1 in self._tree.moved_by(step.joint)
        ]

    def axis_covariance(self, body: int) -> FloatArray:
        """(3, 3) of that in body axes: the angles of joints between the body and the axis are not exact."""
        covariance = np.zeros((3, 3))
        for between in self._between(body):
            has_zero = self.joints[between - 1].has_zero
            std = _ANGLE_STD_RAD if has_zero else UNKNOWN_ZERO_STD_RAD
            # To first order, an error of a joint between turns the axis about that joint's own.
            tilt = np.cross(self._joint_axis(between, body), self.axis(body))
            covariance += std**2 * np.outer(tilt, tilt)
        return covariance

    def sensors_shown(self) -> FloatArray:
        """(n, 2) what the joint's own sensors show."""
        return self.recording.sensor_angle_rad[:, sensor_columns(self.model, self.step.moving_joint)]
