"""The rotation that one stroke gives the base at zero momentum.

While one joint moves, the robot is two rigid bodies on a hinge, so its inertia and its momentum follow from two
composites that are computed once for the stroke, in coordinates whose x axis is the joint's axis, fixed to the base's
side. The rotation depends on the path in joint angles alone, not on the speed (as in every motion without momentum);
it solves dR/da = R [w(a)] over the joint's angle, here by Magnus' series of order 6 on Gauss nodes (Blanes, Casas,
Oteo, Ros, "The Magnus expansion and some of its applications", Physics Reports 470, 2009, section 5).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.components import (
    batch_first,
    batch_last,
    cross,
    dot,
    matmul,
    matvec,
    pad,
    rotated_tensor,
    rotation_about,
    solve_symmetric,
    transpose,
)
from tfsat_host.dynamics.multibody import Columns, Multibody, Step, walk_outwards
from tfsat_host.dynamics.spatial_momentum import Composite, compose_bodies

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
        others = [other for other in body.steps if other.joint != joint]
        columns = body.columns(batch_ndim)
        # With the joint's axis along x a turn of the hinge mixes y and z alone.
        to_global = _align_with_x(step.sign * columns.axis[joint])
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
            fixed=walk_outwards(others, step.parent),
            moving=walk_outwards(others, step.child),
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
    """Combine the bodies on each side of the hinge at joint angles (n - 1, ...).

    The hinge's own angle has no effect.
    """
    return Halves(
        fixed=compose_bodies(hinge.columns, hinge.step.parent, hinge.fixed, angles),
        moving=compose_bodies(hinge.columns, hinge.step.child, hinge.moving, angles),
        point=hinge.columns.point[hinge.step.joint],
    )


def to_base(hinge: Hinge, angles: FloatArray) -> FloatArray:
    """Rotation (3, 3, ...) from hinge coordinates to base axes at joint angles (n - 1, ...)."""
    rotation = hinge.to_global
    # The axes are kept in hinge coordinates: take them to global ones.
    axis = [matvec(hinge.to_global, a) for a in hinge.columns.axis]
    # From the hinge back to the base, joint by joint.
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
    # Lever from the axis to the moving side's center of mass, turned by the hinge's angle.
    x, y, z = moving.com - halves.point
    lever_y, lever_z = cosine * y - sine * z, sine * y + cosine * z
    # Distance of the two centers of mass: with the reduced mass it couples both sides.
    gap = halves.point - fixed.com
    dx, dy, dz = x + gap[0], lever_y + gap[1], lever_z + gap[2]
    reduced = fixed.mass * moving.mass / (fixed.mass + moving.mass)

    own, other = moving.inertia, fixed.inertia
    # Turned about x, yy, zz and yz take the double angle, xy and xz the single, xx none.
    mean, half = 0.5 * (own[1, 1] + own[2, 2]), 0.5 * (own[1, 1] - own[2, 2])
    cosine2, sine2 = cosine * cosine - sine * sine, 2.0 * sine * cosine
    xy, xz = cosine * own[0, 1] - sine * own[0, 2], sine * own[0, 1] + cosine * own[0, 2]
    bulge, yz = cosine2 * half - sine2 * own[1, 2], sine2 * half + cosine2 * own[1, 2]

    # I w = -A for unit rate of the hinge, by the parallel axis theorem with the reduced mass.
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


def _path(body: Multibody, target: int) -> tuple[Step, ...]:
    """Return the joints from the base to body `target`."""
    path: list[Step] = []
    # Inwards from the target: one joint of each body leads to the base.
    while target != body.base:
        step = next(step for step in body.steps if step.child == target)
        path.insert(0, step)
        target = step.parent
    return tuple(path)


def _align_with_x(axis: FloatArray) -> FloatArray:
    """Return a rotation (3, 3, ...) whose first column is the unit vector `axis` (3, ...)."""
    # The coordinate axis least along it is safe for the cross product.
    least = np.argmin(np.abs(axis), axis=0)
    across = np.moveaxis(_SIDEWAYS[least], -1, 0)
    second = cross(axis, across)
    second = second / np.sqrt(dot(second, second))
    return np.stack([axis, second, cross(axis, second)], axis=1)


# Two steps of order 6 leave 5e-5 deg on the loop 90/90 of the drop tower robot; 0.05 deg with other robots.
STEPS = 2
TOLERANCE_RAD = math.radians(1e-4)
# Half as long a step leaves a 64th of the error, once steps are short; until then it may be a 16th.
GAIN = 16.0
# The first try has no step longer than 45 deg.
_MAX_STEP_RAD = math.pi / 4.0
_STEPS_MAX = 4096
# Nodes of Gauss-Legendre quadrature of order 6, on a step of length 1.
_ROOT15 = 15.0**0.5
GAUSS = np.array([0.5 - _ROOT15 / 10.0, 0.5, 0.5 + _ROOT15 / 10.0])


def stroke_rotation(
    body: Multibody,
    joint: int,
    angles_rad: FloatArray,
    delta_rad: FloatArray,
    *,
    steps: int | None = None,
    tolerance_rad: float = TOLERANCE_RAD,
) -> FloatArray:
    """Rotation of the base by a stroke of one joint at zero angular momentum.

    Args:
        body: The robot, or a batch of robots.
        joint: Index of the joint that moves.
        angles_rad: (..., n - 1) joint angles before the stroke.
        delta_rad: (...) by how much the joint moves.
        steps: Steps of order 6 into which the stroke is divided. None: as many as `tolerance_rad` needs for
            every sample; a stated number is several times faster.
        tolerance_rad: Greatest error of the rotation, estimated by halving the steps.

    Returns:
        Quaternions (..., 4), scalar last: from base axes after the stroke to base axes before it. The batch axes
        of all arguments are broadcast against each other.

    Raises:
        ValueError: there is no such joint, a number is not finite, or no number of steps is enough.
    """
    angles, delta = np.asarray(angles_rad, dtype=np.float64), np.asarray(delta_rad, dtype=np.float64)
    shape = np.broadcast_shapes(body.batch_shape, angles.shape[:-1], delta.shape)
    hinge = Hinge.of(body, joint, len(shape))
    padded, delta = pad(batch_last(angles), 1, len(shape)), np.broadcast_to(delta, shape)
    if steps is None:
        return batch_first(turned_within(hinge, padded, delta, tolerance_rad))
    return batch_first(rotate_base(hinge, padded, delta, steps))


def path_rotation(
    body: Multibody,
    joints: Sequence[int],
    deltas_rad: FloatArray,
    *,
    start_rad: FloatArray | None = None,
    steps: int | None = None,
    tolerance_rad: float = TOLERANCE_RAD,
) -> FloatArray:
    """Rotation of the base by strokes one after another, at zero angular momentum.

    Args:
        body: The robot, or a batch of robots.
        joints: (k,) index of the joint of each stroke.
        deltas_rad: (..., k) by how much each moves.
        start_rad: (..., n - 1) joint angles at the start; zero if None.
        steps: Steps of order 6 into which each stroke is divided. None: as many as `tolerance_rad` needs for
            every sample; a stated number is several times faster.
        tolerance_rad: Greatest error of the whole rotation, estimated by halving the steps.

    Returns:
        Quaternions (..., 4), scalar last: from base axes at the end to base axes at the start. The batch axes of
        all arguments are broadcast against each other. After a closed loop, which leads every joint back, the
        rotation is the same for every body.

    Raises:
        ValueError: `deltas_rad` does not fit `joints`, or as `stroke_rotation`.
    """
    deltas = np.asarray(deltas_rad, dtype=np.float64)
    if deltas.shape[-1:] != (len(joints),):
        raise ValueError(f"angles of shape {deltas.shape} do not fit {len(joints)} strokes")
    start = np.zeros(body.n_joints) if start_rad is None else np.asarray(start_rad, dtype=np.float64)
    shape = np.broadcast_shapes(body.batch_shape, start.shape[:-1], deltas.shape[:-1])
    angles = np.array(np.broadcast_to(start, (*shape, body.n_joints)))
    rotation = quaternion.identity(shape)
    for stroke, joint in enumerate(joints):
        # Errors of strokes at most add up: each gets an equal share of the tolerance.
        turned = stroke_rotation(
            body,
            joint,
            angles,
            deltas[..., stroke],
            steps=steps,
            tolerance_rad=tolerance_rad / len(joints),
        )
        rotation = quaternion.product(rotation, batch_last(turned))
        angles[..., joint] += deltas[..., stroke]
    return batch_first(rotation)


def turned_within(hinge: Hinge, angles: FloatArray, delta: FloatArray, tolerance_rad: float) -> FloatArray:
    """Compute the rotations of `rotate_base`, with as many steps as the tolerance needs for the whole batch.

    Raises:
        ValueError: a number is not finite, or no number of steps is enough.
    """
    # A NaN would never meet the tolerance, and halve the steps to the last.
    if not (np.isfinite(angles).all() and np.isfinite(delta).all()):
        raise ValueError("joint angles and strokes must be finite")
    if delta.size == 0:
        return rotate_base(hinge, angles, delta)
    longest = float(np.abs(delta).max())
    steps = max(STEPS, math.ceil(min(longest / _MAX_STEP_RAD, _STEPS_MAX)))
    rotation = rotate_base(hinge, angles, delta, steps)
    # Halve until the change is small: what is still wrong is a 16th of it at most.
    while steps < _STEPS_MAX:
        steps *= 2
        coarse, rotation = rotation, rotate_base(hinge, angles, delta, steps)
        change = quaternion.angle(quaternion.product(quaternion.inverse(coarse), rotation))
        if float(change.max()) <= GAIN * tolerance_rad:
            return rotation
    raise ValueError(
        f"a stroke of {longest:g} rad needs more than {_STEPS_MAX} steps for {tolerance_rad:g} rad"
    )


def rotate_base(hinge: Hinge, angles: FloatArray, delta: FloatArray, steps: int = STEPS) -> FloatArray:
    """Quaternions (4, ...) of the base by strokes of `delta` (...) from joint angles (n - 1, ...).

    `delta` has the whole batch shape; angles may have axes of length 1.
    """
    # Two rigid bodies for the whole stroke: only the hinge's own angle changes.
    halves = divide(hinge, angles)
    start = angles[hinge.step.joint]
    # A step's nodes are one more axis before the batch: (steps, 3 nodes, ...).
    nodes = ((np.arange(steps)[:, None] + GAUSS) / steps).reshape(steps, 3, *(1,) * np.ndim(delta))
    rates = base_rate(_with_axes(halves), start + nodes * delta)
    increments = magnus6(rates, delta / steps)
    # Rotations do not commute: multiply the steps in their order.
    rotation = quaternion.exponential(increments[:, 0])
    for step in range(1, steps):
        rotation = quaternion.product(rotation, quaternion.exponential(increments[:, step]))
    # A change of axes turns a quaternion's vector part, and leaves its scalar.
    rotation[:3] = matvec(to_base(hinge, angles), rotation[:3])
    return rotation


def _with_axes(halves: Halves) -> Halves:
    """Room for two axes, steps and nodes, between components and batch."""

    def wide(values: FloatArray, core_ndim: int) -> FloatArray:
        return values.reshape(*values.shape[:core_ndim], 1, 1, *values.shape[core_ndim:])

    fixed, moving = (Composite(c.mass, wide(c.com, 1), wide(c.inertia, 2)) for c in halves[:2])
    return Halves(fixed, moving, wide(halves.point, 1))


def magnus6(rates: FloatArray, length: FloatArray) -> FloatArray:
    """Rotation vectors (3, s, ...) of steps of `length` (...) from the rates (3, s, 3, ...) at the Gauss nodes."""
    first, middle, last = rates[:, :, 0], rates[:, :, 1], rates[:, :, 2]
    # Value, slope and curvature of the rate in the middle of the step, times its length.
    b1 = length * middle
    b2 = (_ROOT15 / 3.0) * length * (last - first)
    b3 = (10.0 / 3.0) * length * (last - 2.0 * middle + first)
    # For dR = R [w] the bracket of the series is minus the cross product.
    inner = -cross(b1, b2)
    outer = b2 + cross(b1, 2.0 * b3 + inner) / 60.0
    # The series to order 6, with three commutators.
    return b1 + b3 / 12.0 - cross(-20.0 * b1 - b3 + inner, outer) / 240.0
