"""A tree of rigid bodies as the equations need it: seen from its base body, as arrays."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.components import batch_last, pad
from tfsat_host.robot import RobotModel


class Step(NamedTuple):
    """One joint on the way from the base outwards: it turns `child` by `sign * angle` against `parent`."""

    joint: int
    parent: int
    child: int
    sign: float


@dataclass(frozen=True, eq=False)
class Multibody:
    """n bodies and n - 1 hinges. Any array may have further leading batch axes: one robot a sample.

    Attributes:
        base: Index of the body whose frame the equations are written in.
        steps: The joints in order from the base outwards.
        mass_kg: (..., n).
        com_m: (..., n, 3) centers of mass, global, at zero joint angles.
        inertia_kg_m2: (..., n, 3, 3) about the center of mass, body axes.
        joint_axis: (..., n - 1, 3) unit vectors.
        joint_point_m: (..., n - 1, 3) a point on each axis, global, at zero joint angles.
    """

    base: int
    steps: tuple[Step, ...]
    mass_kg: FloatArray
    com_m: FloatArray
    inertia_kg_m2: FloatArray
    joint_axis: FloatArray
    joint_point_m: FloatArray

    @classmethod
    def of(cls, robot: RobotModel, base: int | None = None) -> Multibody:
        """Build the robot as seen from body `base` (its own base body if None)."""
        root = robot.base if base is None else base
        ends = enumerate(zip(robot.joint_inner, robot.joint_outer, strict=True))
        joints = [Step(joint, int(inner), int(outer), 1.0) for joint, (inner, outer) in ends]
        return cls(
            base=root,
            steps=walk_outwards(joints, root),
            mass_kg=robot.mass_kg,
            com_m=robot.origin_m + robot.com_m,
            inertia_kg_m2=robot.inertia_kg_m2,
            joint_axis=robot.joint_axis,
            joint_point_m=robot.joint_point_m,
        )

    def replace(self, **arrays: FloatArray) -> Multibody:
        """Return the same tree with some arrays replaced."""
        return dataclasses.replace(self, **arrays)  # type: ignore[arg-type]

    @property
    def n_bodies(self) -> int:
        """Number of bodies."""
        return len(self.steps) + 1

    @property
    def n_joints(self) -> int:
        """Number of joints."""
        return len(self.steps)

    @property
    def batch_shape(self) -> tuple[int, ...]:
        """Shape of the samples; () for one robot."""
        return np.broadcast_shapes(
            self.mass_kg.shape[:-1],
            self.com_m.shape[:-2],
            self.inertia_kg_m2.shape[:-3],
            self.joint_axis.shape[:-2],
            self.joint_point_m.shape[:-2],
        )

    def tilt_hinges(self, tilt_rad: FloatArray) -> Multibody:
        """Tilt the hinge axes by (..., n - 1, 2) about the two directions `across` each axis."""
        sides = np.array([across(axis) for axis in self.joint_axis])
        # j: joints, k: the two tilts, i: components.
        return self.replace(
            joint_axis=tilt_axes(self.joint_axis, np.einsum("...jk,jki->...ji", tilt_rad, sides))
        )

    def moved_by(self, joint: int) -> tuple[int, ...]:
        """Return the bodies on the far side of `joint`, seen from the base."""
        moved: list[int] = []
        # Joints run outwards: one pass finds the whole branch.
        for step in self.steps:
            if step.joint == joint or step.parent in moved:
                moved.append(step.child)
        return tuple(moved)

    def broadcast(self, *values: FloatArray) -> tuple[tuple[int, ...], list[FloatArray]]:
        """Return the common batch shape of the samples and of values (..., m), and these components first."""
        arrays = [np.asarray(value, dtype=np.float64) for value in values]
        shape = np.broadcast_shapes(self.batch_shape, *(array.shape[:-1] for array in arrays))
        return shape, [pad(batch_last(array), 1, len(shape)) for array in arrays]

    def columns(self, batch_ndim: int) -> Columns:
        """Return the arrays components first, ready to be combined with batches of `batch_ndim` axes."""
        return Columns(
            mass=np.ascontiguousarray(pad(batch_last(self.mass_kg, 1), 1, batch_ndim)),
            com=np.ascontiguousarray(pad(batch_last(self.com_m, 2), 2, batch_ndim)),
            inertia=np.ascontiguousarray(pad(batch_last(self.inertia_kg_m2, 3), 3, batch_ndim)),
            axis=np.ascontiguousarray(pad(batch_last(self.joint_axis, 2), 2, batch_ndim)),
            point=np.ascontiguousarray(pad(batch_last(self.joint_point_m, 2), 2, batch_ndim)),
        )


class Columns(NamedTuple):
    """The arrays of a `Multibody` with the batch axes last: mass (n, ...), com (n, 3, ...), and so on."""

    mass: FloatArray
    com: FloatArray
    inertia: FloatArray
    axis: FloatArray
    point: FloatArray


def walk_outwards(joints: Sequence[Step], root: int) -> tuple[Step, ...]:
    """Return the joints that are reached from body `root`, in order outwards."""
    reached, steps = [root], list[Step]()
    grown = True
    # Until no joint leads to a new body; a joint crossed from outside in turns the other way.
    while grown:
        grown = False
        for step in joints:
            for way in (step, Step(step.joint, step.child, step.parent, -step.sign)):
                if way.parent in reached and way.child not in reached:
                    reached.append(way.child)
                    steps.append(way)
                    grown = True
    return tuple(steps)


_NEAR = 0.55
"""Every unit vector has a greater component, at least 1/sqrt(3); no common direction has one of just this size."""


def across(axis: FloatArray) -> FloatArray:
    """Return two unit vectors (2, 3) perpendicular to the unit vector `axis` (3,).

    They are near to the coordinate axes that name them, and turn with the axis when it is tilted a little.
    """
    # The first coordinate axis that is near, not the nearest: on a diagonal two are, and a small tilt exchanged them.
    along = int(np.argmax(np.abs(axis) > _NEAR))
    # The two others, made square to the axis by Gram-Schmidt.
    first, second = np.eye(3)[(along + 1) % 3], np.eye(3)[(along + 2) % 3]
    first = first - (first @ axis) * axis
    first = first / np.linalg.norm(first)
    second = second - (second @ axis) * axis - (second @ first) * first
    return np.array([first, second / np.linalg.norm(second)])


def tilt_axes(axis: FloatArray, tilt: FloatArray) -> FloatArray:
    """`axis` (n - 1, 3) turned by rotation vectors `tilt` (..., n - 1, 3) square to it."""
    angle = np.sqrt((tilt * tilt).sum(axis=-1, keepdims=True))
    # Rodrigues' formula for a turn square to the axis; sinc takes care of no tilt at all.
    return np.asarray(np.cos(angle) * axis + np.sinc(angle / np.pi) * np.cross(tilt, axis))
