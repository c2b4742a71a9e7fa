"""The robot as one joint divides it: while only that joint moves, two rigid bodies on a hinge.

Everything is written in coordinates whose x axis is the joint's axis. They are fixed to the base's side.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tfsat_host.dynamics.components import (
    cross,
    dot,
    matmul,
    matvec,
    rotated_tensor,
    rotation_about,
    solve_symmetric,
    transpose,
)
from tfsat_host.dynamics.momentum import Composite, gathered
from tfsat_host.dynamics.multibody import Columns, Multibody, Step
from tfsat_host.robot.model import FloatArray

_SIDEWAYS = np.eye(3)


class Hinge(NamedTuple):
    """One joint of a robot, ready to be divided there at any joint angles.

    Attributes:
        step: The joint as seen from the base.
        columns: The robot's arrays in coordinates whose x axis is the direction about which the joint turns
            the side that moves.
        to_global: (3, 3, ...) from those coordinates to global ones, at zero angles.
        fixed: The joints of the base's side, in order from the hinge outwards.
        moving: Those of the side that moves.
        path: Those from the base to the hinge.
    """

    step: Step
    columns: Columns
    to_global: FloatArray
    fixed: tuple[Step, ...]
    moving: tuple[Step, ...]
    path: tuple[Step, ...]

    @classmethod
    def of(cls, body: Multibody, joint: int, batch_ndim: int) -> Hinge:
        """Joint `joint` of the robot, for batches of `batch_ndim` axes.

        Raises:
            ValueError: the robot has no such joint.
        """
        if not 0 <= joint < body.n_joints:
            raise ValueError(f"there is no joint {joint}: the robot has {body.n_joints}, counted from 0")
        step = next(step for step in body.steps if step.joint == joint)
        columns = body.columns(batch_ndim)
        to_global = _aligned(step.sign * columns.axis[joint])
        back = transpose(to_global)
        return cls(
            step,
            Columns(
                mass=columns.mass,
                com=np.stack([matvec(back, c) for c in columns.com]),
                inertia=np.stack([rotated_tensor(back, i) for i in columns.inertia]),
                axis=np.stack([matvec(back, a) for a in columns.axis]),
                point=np.stack([matvec(back, p) for p in columns.point]),
            ),
            to_global,
            fixed=_outwards(body, step.parent, joint),
            moving=_outwards(body, step.child, joint),
            path=_path(body, step.parent),
        )


class Halves(NamedTuple):
    """Both sides of a hinge as rigid bodies, hinge coordinates; `point` (3, ...) lies on the axis.

    The side that moves is given as it lies at joint angle zero.
    """

    fixed: Composite
    moving: Composite
    point: FloatArray


def divide(hinge: Hinge, angles: FloatArray) -> Halves:
    """Both sides at joint angles (n - 1, ...); the hinge's own angle has no part in it."""
    return Halves(
        fixed=gathered(hinge.columns, hinge.step.parent, hinge.fixed, angles),
        moving=gathered(hinge.columns, hinge.step.child, hinge.moving, angles),
        point=hinge.columns.point[hinge.step.joint],
    )


def to_base(hinge: Hinge, angles: FloatArray) -> FloatArray:
    """Rotation (3, 3, ...) from hinge coordinates to base axes at joint angles (n - 1, ...)."""
    rotation = hinge.to_global
    axis = [matvec(hinge.to_global, a) for a in hinge.columns.axis]
    for step in reversed(hinge.path):
        rotation = matmul(rotation_about(axis[step.joint], step.sign * angles[step.joint]), rotation)
    return rotation


def base_rate(halves: Halves, angle: FloatArray) -> FloatArray:
    """Rate (3, ...) of the base's side for unit rate of the hinge at zero momentum, at hinge angle (...).

    With the axis along x a rotation by the hinge's angle mixes y and z alone: the moving side's tensor takes the
    cosine and the sine of the angle and of its double, and nothing else.
    """
    fixed, moving = halves.fixed, halves.moving
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y, z = moving.com - halves.point
    lever_y, lever_z = cosine * y - sine * z, sine * y + cosine * z
    gap = halves.point - fixed.com
    dx, dy, dz = x + gap[0], lever_y + gap[1], lever_z + gap[2]
    reduced = fixed.mass * moving.mass / (fixed.mass + moving.mass)

    own, other = moving.inertia, fixed.inertia
    mean, half = 0.5 * (own[1, 1] + own[2, 2]), 0.5 * (own[1, 1] - own[2, 2])
    cosine2, sine2 = cosine * cosine - sine * sine, 2.0 * sine * cosine
    xy, xz = cosine * own[0, 1] - sine * own[0, 2], sine * own[0, 1] + cosine * own[0, 2]
    bulge, yz = cosine2 * half - sine2 * own[1, 2], sine2 * half + cosine2 * own[1, 2]

    mx, my, mz = reduced * dx, reduced * dy, reduced * dz
    return solve_symmetric(
        (
            (own[0, 0] + other[0, 0]) + my * dy + mz * dz,
            xy + other[0, 1] - mx * dy,
            xz + other[0, 2] - mx * dz,
            mx * dx + mz * dz + bulge + (mean + other[1, 1]),
            yz + other[1, 2] - my * dz,
            mx * dx + my * dy - bulge + (mean + other[2, 2]),
        ),
        (-own[0, 0] - my * lever_y - mz * lever_z, mx * lever_y - xy, mx * lever_z - xz),
    )


def _outwards(body: Multibody, root: int, without: int) -> tuple[Step, ...]:
    """The joints that can be reached from body `root` without crossing joint `without`, outwards."""
    reached, found = [root], list[Step]()
    joints = [step for step in body.steps if step.joint != without]
    grown = True
    while grown:
        grown = False
        for step in joints:
            for way in (step, Step(step.joint, step.child, step.parent, -step.sign)):
                if way.parent in reached and way.child not in reached:
                    reached.append(way.child)
                    found.append(way)
                    grown = True
    return tuple(found)


def _path(body: Multibody, target: int) -> tuple[Step, ...]:
    """The joints from the base to body `target`."""
    path: list[Step] = []
    while target != body.base:
        step = next(step for step in body.steps if step.child == target)
        path.insert(0, step)
        target = step.parent
    return tuple(path)


def _aligned(axis: FloatArray) -> FloatArray:
    """A rotation (3, 3, ...) whose first column is the unit vector `axis` (3, ...)."""
    least = np.argmin(np.abs(axis), axis=0)
    beside = np.moveaxis(_SIDEWAYS[least], -1, 0)
    second = cross(axis, beside)
    second = second / np.sqrt(dot(second, second))
    return np.stack([axis, second, cross(axis, second)], axis=1)
