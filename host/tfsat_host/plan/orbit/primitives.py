"""Motion primitives: closed loops of two or three joints on a grid, with the rotation and the time of each.

The order of strokes is one of `tfsat_host.plan.loops`: every joint out once and back once. Where the joint that moves
first comes back last, it may be held aside while the others repeat their strokes: between two such loops it would
come back and go out again, which cancels.
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
# Loops with a joint held aside are in the table up to so many times; chains join them to longer ones.
_MAX_REPEATS = 4
# A rotation by less has no axis but that of rounding.
_NO_AXIS_RAD = 1e-9


class Shape(NamedTuple):
    """Which joints a loop moves, in which order, how often.

    Attributes:
        joints: Their indices.
        sequence: The order; +1 opens the first of the joints.
        repeats: How often the strokes between the first and the last are flown; above 1 only if those two are
            of one joint, which is then held aside.
    """

    joints: tuple[int, ...]
    sequence: Sequence
    repeats: int = 1

    @property
    def held(self) -> int | None:
        """Which of the joints moves first and comes back last: it may be held aside; None: none does."""
        return abs(self.sequence[0]) - 1 if self.sequence[0] == -self.sequence[-1] else None

    @property
    def once(self) -> Shape:
        """The shape without repeats."""
        return self._replace(repeats=1)

    @property
    def stroke_order(self) -> Sequence:
        """All strokes, as signed numbers of the shape's joints from 1."""
        first, *inner, last = self.sequence
        return (first, *inner * self.repeats, last)

    @property
    def stroke_counts(self) -> IntArray:
        """(d,) how many strokes each joint makes."""
        return np.bincount(np.abs(self.stroke_order) - 1)

    def strokes(self, displacement_rad: FloatArray) -> list[tuple[int, float]]:
        """Joint index and angle of each stroke, for displacements (d,); a joint that does not move has none."""
        return [
            (self.joints[abs(sign) - 1], float(displacement_rad[abs(sign) - 1]) * (1 if sign > 0 else -1))
            for sign in self.stroke_order
            if displacement_rad[abs(sign) - 1] != 0.0
        ]


@dataclass(frozen=True, eq=False)
class Primitive:
    """One closed loop, or several with a joint held aside.

    Attributes:
        shape: Its joints, their order, how often.
        displacement_rad: (d,) of the shape's joints.
        quaternion_xyzw: (4,) from body axes after it to body axes before it, as the model has it.
        duration_s: At the joints' average rates.
        spans_s: (k, 2) start and end of each stroke where strokes overlap; None: one stroke after another.
    """

    shape: Shape
    displacement_rad: FloatArray
    quaternion_xyzw: FloatArray
    duration_s: float
    spans_s: FloatArray | None = None

    @property
    def strokes(self) -> list[tuple[int, float]]:
        """Joint index and angle in rad of each stroke."""
        return self.shape.strokes(self.displacement_rad)

    @property
    def backwards(self) -> Primitive:
        """The loop flown backwards: it undoes this one, on any robot."""
        return Primitive(
            self.shape._replace(sequence=backwards(self.shape.sequence)),
            self.displacement_rad,
            quaternion.inverse(self.quaternion_xyzw),
            self.duration_s,
            None if self.spans_s is None else self.duration_s - self.spans_s[::-1, ::-1],
        )


@dataclass(frozen=True, eq=False)
class PrimitiveTable:
    """m primitives of one robot.

    Attributes:
        robot: Its file.
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
        made: How many primitives were computed before the useful ones were kept.
        steps: Steps of order 6 into which a stroke is divided, as many as the largest loops need for 1e-4 deg.
        single: The table of loops flown once; None if this is it.
    """

    robot: RobotModel
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
    single: PrimitiveTable | None = None

    @property
    def single_loops(self) -> PrimitiveTable:
        """The table of loops that are flown once: the attitude is measured after each."""
        return self.single or self

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

    @cached_property
    def inner_s(self) -> FloatArray:
        """(m,) durations without the strokes of a joint that may be held aside."""
        seconds = self.duration_s.copy()
        for number, shape in enumerate(self.shapes):
            if shape.held is not None:
                rows = self.shape == number
                out_and_back = 2.0 * np.abs(self.displacement_rad[rows, shape.held])
                seconds[rows] -= out_and_back / self.joint_rate_rad_s[shape.joints[shape.held]]
        return seconds

    @cached_property
    def _loops(self) -> dict[Shape, Loops]:
        return {}

    def rotations(self, shape: Shape, displacements_rad: FloatArray) -> FloatArray:
        """Quaternions (4, b) of primitives of one shape with displacements (d, b)."""
        if shape.once not in self._loops:
            self._loops[shape.once] = Loops(
                self.body, shape.joints, (shape.sequence,), start_rad=self.start_rad, steps=self.steps
            )
        return _repeat(self._loops[shape.once].rotations(displacements_rad)[:, 0], shape.repeats)

    def primitive_of(self, shape: Shape, displacement_rad: FloatArray) -> Primitive:
        """Compute the primitive of a shape with displacements (d,), on the grid or not."""
        column = displacement_rad[:, None]
        duration = float(_durations(shape, column, self.joint_rate_rad_s)[0])
        return Primitive(shape, displacement_rad, self.rotations(shape, column)[:, 0], duration)


def primitive_table(robot: RobotModel, step_deg: float) -> PrimitiveTable:
    """Build the table of useful loops of every two and three joints, from the robot's start pose.

    Those that can be repeated with a joint held aside are in it once, twice, up to `_MAX_REPEATS` times.
    Loops stay within the joint limits. Useful loops turn by 0.02 deg or more and are the fastest of those whose
    rotation vectors fall into the same cell of 0.25 deg a side.

    `step_deg` is the grid step of the loops of two joints; loops of three joints use three times this step.

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
                # Pad to three columns, so that loops of two and of three joints share one table.
                padded = np.zeros((displacements.shape[1], 3))
                padded[:, : len(joints)] = displacements.T
                max_repeats = _MAX_REPEATS if Shape(joints, order).held is not None else 1
                for shape in (Shape(joints, order, repeats) for repeats in range(1, max_repeats + 1)):
                    index = np.full(len(padded), len(shapes))
                    rotation = _repeat(rotations[:, number], shape.repeats)
                    parts.append((index, padded, rotation, _durations(shape, displacements, rates)))
                    shapes.append(shape)
    if not parts:
        grid_axes(robot.joint_limits_rad, start, step_deg)  # says what is wrong
    shape_index, displacement, duration = (
        np.concatenate([part[column] for part in parts]) for column in (0, 1, 3)
    )
    rotation = np.concatenate([part[2] for part in parts], axis=1)
    repeats = np.array([shape.repeats for shape in shapes])[shape_index]

    def table(rows: IntArray, single: PrimitiveTable | None) -> PrimitiveTable:
        keep = rows[_useful(rotation[:, rows], duration[rows])]
        return PrimitiveTable(
            robot,
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
            made=len(rows),
            steps=steps,
            single=single,
        )

    single = table(np.flatnonzero(repeats == 1), None)
    if not len(single):
        raise OrbitError(
            what=f"No loop of {robot.name} on a grid of {step_deg:g} deg turns it by {_MIN_TURN_DEG:g} deg.",
            meaning="No attitude can be reached by this robot's joints.",
            next_step="Check the robot's joint axes (parallel ones hardly turn it) and limits_deg.",
        )
    return table(np.arange(len(duration)), single)


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
    """(b,) of displacements (d, b): every stroke of every joint."""
    return np.asarray(shape.stroke_counts @ (np.abs(displacements) / rates[list(shape.joints), None]))


def _repeat(rotation: FloatArray, count: int) -> FloatArray:
    """Rotations (4, ...) flown `count` times."""
    return rotation if count == 1 else quaternion.exponential(count * quaternion.logarithm(rotation))


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
