"""A recorded step seen with what is known so far: rates, joint angles and poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.sensors.gyro import GyroCalibration
from tfsat_host.calibration.sensors.joint_sensors import JointSensors, joint_angles, sensor_columns
from tfsat_host.calibration.steps.evidence import Evidence
from tfsat_host.calibration.steps.patterns import MotionPattern
from tfsat_host.calibration.steps.recording import Recording
from tfsat_host.calibration.steps.relative import (
    axis_in_body,
    body_to_base,
    joints_between,
    reference_of,
    sense_of,
    without_held_motion,
)
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

UNKNOWN_ZERO_STD_RAD = np.deg2rad(1.0)
"""How far a joint may be from closed where the step begins, if its zero was not calibrated."""
_ANGLE_STD_RAD = np.deg2rad(0.05)


@dataclass(frozen=True, eq=False)
class MotionView:
    """A swing or a sweep.

    Attributes:
        pattern: What was moved and held.
        recording: In SI units.
        angle_rad: (n, n_joints) joint angles.
        to_base: n_bodies arrays (n, 3, 3).
        gyros: What is known of them.
        joints: What is known of the angle sensors.
        model: The robot.
    """

    pattern: MotionPattern
    recording: Recording
    angle_rad: FloatArray
    to_base: Sequence[FloatArray]
    gyros: Sequence[GyroCalibration]
    joints: Sequence[JointSensors]
    model: RobotModel

    @classmethod
    def of(
        cls,
        evidence: Evidence,
        gyros: Sequence[GyroCalibration],
        joints: Sequence[JointSensors],
        model: RobotModel,
    ) -> MotionView:
        """Of a recorded swing or sweep."""
        step = evidence.step
        if step.joint is None:
            raise ValueError(f"a {step.kind} moves no joint")
        recording = Recording.from_counts(evidence.counts)
        angles = joint_angles(recording.sensor_angle_rad, joints, model)
        pattern = MotionPattern(step.joint, step.moved, step.held)
        return cls(pattern, recording, angles, body_to_base(model, angles), gyros, joints, model)

    @property
    def held(self) -> int:
        """The held body (1 to 4) beside the joint."""
        return reference_of(self.pattern, self.model)

    def readings(self, body: int) -> FloatArray:
        """(n, 3) of a moved body (1 to 4), free of bias and of the held body's motion, sensor axes."""
        return without_held_motion(self.recording.rate_rad_s, body, self.held, self.gyros, self.to_base)

    def sense(self, body: int) -> float:
        """+1 where the body turns about the joint's axis as the joint opens, -1 where it turns against it."""
        return sense_of(self.model, self.pattern.joint - 1, body - 1)

    def axis(self, body: int) -> FloatArray:
        """(3,) the axis in the body's axes about which it turns, unit vector.

        The joint's, and a little of those between, where a joint that should stay closed follows the motion.
        """
        axis = self._seen(self.pattern.joint - 1, body)
        main = self.angle_rad[:, self.pattern.joint - 1]
        for between in self._between(body):
            follows = np.polyfit(main, self.angle_rad[:, between], 1)[0]
            side = self.sense(body) * sense_of(self.model, between, body - 1)
            axis = axis + side * follows * self._seen(between, body)
        return np.asarray(axis / np.linalg.norm(axis))

    def _seen(self, joint: int, body: int) -> FloatArray:
        """(3,) a joint's axis in the body's axes, as they are while it moves: so does a fitted line weigh it."""
        rate = np.gradient(self.angle_rad[:, self.pattern.joint - 1], self.recording.t_s)
        return axis_in_body(self.model, joint, body - 1, self.to_base, rate**2)

    def _between(self, body: int) -> list[int]:
        """Joints (from 0) between the body and the joint that is moved."""
        inner = int(self.model.joint_inner[self.pattern.joint - 1])
        return [
            joint for joint in joints_between(self.model, inner, body - 1) if joint != self.pattern.joint - 1
        ]

    def axis_covariance(self, body: int) -> FloatArray:
        """(3, 3) of that in body axes: the angles of joints between the body and the axis are not exact."""
        covariance = np.zeros((3, 3))
        for between in self._between(body):
            known = self.joints[between].zero_taken is not None
            std = _ANGLE_STD_RAD if known else UNKNOWN_ZERO_STD_RAD
            turn = np.cross(self._seen(between, body), self.axis(body))
            covariance += std**2 * np.outer(turn, turn)
        return covariance

    def sensors_shown(self) -> FloatArray:
        """(n, 2) what the joint's own sensors show."""
        return self.recording.sensor_angle_rad[:, sensor_columns(self.model, self.pattern.joint)]
