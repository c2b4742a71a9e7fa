"""What errors of the joint angles do to the attitude that the model predicts, at zero angular momentum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.dynamics import Multibody, path_rotation, quaternion
from tfsat_host.dynamics.components import batch_last
from tfsat_host.evaluation.budget.attitude_errors import Turned, exactly, to_first_order
from tfsat_host.maneuver import Schedule
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

_TOLERANCE_RAD = 1e-10
_DERIVATIVE_STEP_RAD = 1e-3


@dataclass(frozen=True, eq=False)
class Path:
    """The strokes as one body sees them.

    Attributes:
        body: The robot, seen from that body.
        joints: (k,) indices.
        deltas_rad: (k,) strokes.
        start_rad: (n - 1,) joint angles at the release.
    """

    body: Multibody
    joints: tuple[int, ...]
    deltas_rad: FloatArray
    start_rad: FloatArray

    @classmethod
    def of(cls, robot: RobotModel, schedule: Schedule, body: int) -> Path:
        """`body`: 1 to n. The strokes do not overlap."""
        return cls(
            Multibody.of(robot, body - 1),
            tuple(stroke.joint - 1 for stroke in schedule.strokes),
            np.radians([stroke.angle_deg for stroke in schedule.strokes]),
            np.array([servo.start_rad for servo in robot.servos]),
        )

    def end(self, start_off_rad: FloatArray, deltas_off_rad: FloatArray) -> FloatArray:
        """(4, ...) attitude at the end, to the body's axes at the release, with errors (..., n - 1) and (..., k)."""
        return batch_last(
            path_rotation(
                self.body,
                self.joints,
                self.deltas_rad + deltas_off_rad,
                start_rad=self.start_rad + start_off_rad,
                tolerance_rad=_TOLERANCE_RAD,
            )
        )


def zero_point(path: Path, size_rad: float) -> tuple[Turned, Turned]:
    """Of each joint by itself, all strokes being as long as they are: to first order, and exactly."""
    joints = len(path.start_rad)
    return _both(path, size_rad, np.eye(joints), np.zeros((joints, len(path.joints))))


def stroke_ends(path: Path, size_rad: float) -> tuple[Turned, Turned]:
    """Of the angle that each stroke reaches by itself; the next stroke of that joint goes to where it should."""
    count = len(path.joints)
    deltas = np.eye(count)
    for stroke, joint in enumerate(path.joints):
        again = next((later for later in range(stroke + 1, count) if path.joints[later] == joint), None)
        if again is not None:
            deltas[stroke, again] = -1.0
    return _both(path, size_rad, np.zeros((count, len(path.start_rad))), deltas)


def _both(
    path: Path, size_rad: float, unit_starts: FloatArray, unit_deltas: FloatArray
) -> tuple[Turned, Turned]:
    senses = np.array([1.0, -1.0])[:, None, None]
    true = path.end(np.zeros(len(path.start_rad)), np.zeros(len(path.joints)))

    def ends(size: float) -> FloatArray:
        return path.end(senses * size * unit_starts, senses * size * unit_deltas)

    near = ends(_DERIVATIVE_STEP_RAD)
    turned = quaternion.logarithm(quaternion.product(near, quaternion.inverse(true[:, None, None])))
    slope = (turned[:, 0] - turned[:, 1]).T / (2.0 * _DERIVATIVE_STEP_RAD)
    return to_first_order(size_rad * slope, true), exactly(ends(size_rad), true)
