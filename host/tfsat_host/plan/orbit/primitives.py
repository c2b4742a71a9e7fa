"""Motion primitives: closed loops of two or three joints on a grid, with the rotation and the time of each.

The order of strokes is one of `tfsat_host.plan.loops`: every joint out once and back once.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray, IntArray
from tfsat_host.dynamics import Multibody, quaternion
from tfsat_host.plan.grid import GridAxis, OrbitError, grid_axes
from tfsat_host.plan.loops import Loops, Sequence, backwards, enough_steps, sequences
from tfsat_host.robot import RobotModel

# Loops of three joints tilt what two joints turn; between them a coarser grid is dense enough.
_COARSER = 3
# Greatest error of a loop's rotation.
_TOLERANCE_RAD = np.radians(1e-4)
# A loop that turns less than this is no use; two that end closer together are one, and the faster is kept.
_MIN_TURN_DEG = 0.02
_SAME_DEG = 0.25
# A rotation by less has no axis but that of rounding.
_NO_AXIS_RAD = 1e-9


class Shape(NamedTuple):
    """Which joints a loop moves, in which order. `joints` are indices; +1 in `sequence` opens the first of them."""

    joints: tuple[int, ...]
    sequence: Sequence

    def strokes(self, displacement_rad: FloatArray) -> list[tuple[int, float]]:
        """Joint index and angle of each stroke, for displacements (d,); a joint that does not move has none."""
        return [
            (self.joints[abs(sign) - 1], float(displacement_rad[abs(sign) - 1]) * (1 if sign > 0 else -1))
            for sign in self.sequence
            if displacement_rad[abs(sign) - 1] != 0.0
        ]


@dataclass(frozen=True, eq=False)
class Primitive:
    """One closed loop.

    Attributes:
        shape: Its joints and their order.
        displacement_rad: (d,) of the shape's joints.
        quaternion_xyzw: (4,) from body axes after it to body axes before it, as the model has it.
        duration_s: At the joints' average rates, one stroke after another.
    """

    shape: Shape
    displacement_rad: FloatArray
    quaternion_xyzw: FloatArray
    duration_s: float

    @property
    def strokes(self) -> list[tuple[int, float]]:
        """Joint index and angle in rad of each stroke."""
        return self.shape.strokes(self.displacement_rad)

    @property
    def backwards(self) -> Primitive:
        """The loop flown backwards: it undoes this one, on any robot."""
        return Primitive(
            Shape(self.shape.joints, backwards(self.shape.sequence)),
            self.displacement_rad,
            quaternion.inverse(self.quaternion_xyzw),
            self.duration_s,
        )


@dataclass(frozen=True, eq=False)
class PrimitiveTable:
    """m primitives of one robot.

    Attributes:
        body: The robot as the planner knows it.
        start_rad: (n,) the pose at which every loop begins and ends.
        limits_rad: (n, 2) of the joints.
        joint_rate_rad_s: (n,) average rates.
        step_deg: The grid of the loops of two joints; three joints have three times this.
        shapes: The loops' shapes.
        shape: (m,) index of each primitive's shape.
        displacement_rad: (m, 3); loops of two joints leave the last column 0.
        rotation: (4, m) quaternions, components first.
        duration_s: (m,).
        made: How many loops were computed before the useful ones were kept.
        steps: Steps of order 6 into which a stroke is divided, as many as the largest loops need for 1e-4 deg.
    """

    body: Multibody
    start_rad: FloatArray
    limits_rad: FloatArray
    joint_rate_rad_s: FloatArray
    step_deg: float
    shapes: tuple[Shape, ...]
    shape: IntArray
    displacement_rad: FloatArray
    rotation: FloatArray
    duration_s: FloatArray
    made: int
    steps: int

    def __len__(self) -> int:
        return len(self.duration_s)

    @cached_property
    def undone(self) -> FloatArray:
        """(4, m) inverses of the rotations: what is still needed after each, if it was the one needed."""
        return quaternion.inverse(self.rotation)

    def primitive(self, index: int) -> Primitive:
        """Return the primitive at `index`."""
        shape = self.shapes[self.shape[index]]
        displacement = self.displacement_rad[index, : len(shape.joints)]
        return Primitive(shape, displacement, self.rotation[:, index], float(self.duration_s[index]))

    def best_rate_about(self, rotation: FloatArray) -> float:
        """Greatest average rate in rad/s of a loop about the axis of a rotation (4,); 0 if that has no axis.

        Its rotation about other axes is not counted.
        """
        vector = quaternion.logarithm(rotation)
        angle = float(np.linalg.norm(vector))
        if angle < _NO_AXIS_RAD:
            return 0.0
        # Project every loop's rotation vector on the axis, per second of the loop.
        rates = vector @ quaternion.logarithm(self.rotation) / (angle * self.duration_s)
        return max(float(rates.max()), 0.0)

    def loops(self, shape: Shape) -> Loops:
        """Return the loops of one shape, whatever their displacements."""
        return Loops(self.body, shape.joints, (shape.sequence,), start_rad=self.start_rad, steps=self.steps)

    def duration_of(self, shape: Shape, displacement_rad: FloatArray) -> float:
        """Time in s of a loop with displacements (d,)."""
        return float(_durations(shape, displacement_rad[:, None], self.joint_rate_rad_s)[0])


def primitive_table(robot: RobotModel, step_deg: float) -> PrimitiveTable:
    """Build the table of useful loops of every two and three joints, from the robot's start pose.

    Loops stay within the joint limits. Useful loops turn by 0.02 deg or more and are the fastest of those whose
    rotation vectors fall into the same cell of 0.25 deg a side.

    Args:
        robot: The robot.
        step_deg: Grid step of the loops of two joints; loops of three joints use three times this step.

    Raises:
        OrbitError: the grid leaves no loop.
    """
    body = Multibody.of(robot)
    start = np.array([servo.start_rad for servo in robot.servos])
    rates = np.array([servo.average_rate_rad_s for servo in robot.servos])
    shapes, steps = list[Shape](), 1
    parts = list[tuple[IntArray, FloatArray, FloatArray, FloatArray]]()
    groups = [joints for size in (2, 3) for joints in combinations(range(robot.n_joints), size)]
    for joints in groups:
        coarser = 1 if len(joints) == 2 else _COARSER
        displacements = _displacements(joints, robot.joint_limits_rad, start, step_deg * coarser)
        orders = sequences(len(joints))
        if displacements.shape[1]:
            # Integration errors grow with the strokes: judge them at the range's corners and half way.
            ends = np.stack([displacements.min(axis=1), displacements.max(axis=1)])
            far = np.array(list(product(*np.concatenate([ends, 0.5 * ends]).T))).T
            steps = max(steps, enough_steps(body, joints, start, far, _TOLERANCE_RAD))
            rotations = Loops(body, joints, orders, start_rad=start, steps=steps).rotations(displacements)
            for number, order in enumerate(orders):
                shape = Shape(joints, order)
                # Pad to three columns, so that loops of two and of three joints share one table.
                padded = np.zeros((displacements.shape[1], 3))
                padded[:, : len(joints)] = displacements.T
                index = np.full(len(padded), len(shapes))
                parts.append((index, padded, rotations[:, number], _durations(shape, displacements, rates)))
                shapes.append(shape)
    if not parts:
        grid_axes(robot.joint_limits_rad, start, step_deg)  # says what is wrong
    shape_index, displacement, duration = (
        np.concatenate([part[column] for part in parts]) for column in (0, 1, 3)
    )
    rotation = np.concatenate([part[2] for part in parts], axis=1)
    keep = _useful(rotation, duration)
    if not len(keep):
        raise OrbitError(
            what=f"No loop of {robot.name} on a grid of {step_deg:g} deg turns it by {_MIN_TURN_DEG:g} deg.",
            meaning="No attitude can be reached by this robot's joints.",
            next_step="Check the robot's joint axes (parallel ones hardly turn it) and limits_deg.",
        )
    return PrimitiveTable(
        body,
        start,
        robot.joint_limits_rad,
        rates,
        step_deg,
        tuple(shapes),
        shape_index[keep],
        displacement[keep],
        np.ascontiguousarray(rotation[:, keep]),
        duration[keep],
        made=len(duration),
        steps=steps,
    )


def _displacements(
    joints: tuple[int, ...], limits: FloatArray, start: FloatArray, step_deg: float
) -> FloatArray:
    """(d, b) all combinations; b is 0 where a joint has no room for a step."""
    chosen = list(joints)
    try:
        axes: list[GridAxis] = grid_axes(limits[chosen], start[chosen], step_deg)
    except OrbitError:
        # No loop of these joints, but no error: others may have room.
        return np.empty((len(joints), 0))
    values = [axis.displacements_rad for axis in axes]
    return np.stack(np.meshgrid(*values, indexing="ij")).reshape(len(joints), -1)


def _durations(shape: Shape, displacements: FloatArray, rates: FloatArray) -> FloatArray:
    """(b,) of displacements (d, b): every joint out and back."""
    return np.asarray(2.0 * (np.abs(displacements) / rates[list(shape.joints), None]).sum(axis=0))


def _useful(rotation: FloatArray, duration: FloatArray) -> IntArray:
    """Indices of the primitives to keep, the fastest first."""
    # Sort by time before cells are formed: the first loop of each cell is then its fastest.
    fastest_first = np.argsort(duration, kind="stable")
    vectors = np.degrees(quaternion.logarithm(rotation[:, fastest_first]))
    turns = np.sqrt((vectors * vectors).sum(axis=0)) >= _MIN_TURN_DEG
    candidates = fastest_first[turns]
    cells = np.round(vectors[:, turns] / _SAME_DEG).astype(np.int64)
    # Cells quantize the rotation vector; sorting the indices below restores the order of time.
    _, first = np.unique(cells, axis=1, return_index=True)
    return np.asarray(candidates[np.sort(first)])
