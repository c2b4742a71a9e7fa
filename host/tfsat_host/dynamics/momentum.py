"""Angular momentum of a free-floating robot about its center of mass, and what its conservation demands.

With base rate w and joint rates q', both in base axes, the momentum is h = I(q) w + A(q) q'. Without external
torque it is constant in inertial axes; from h = 0 follows w = -I^-1 A q', the connection of the
falling cat (paper, section "Nonholonomic attitude reorientation").
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tfsat_host.dynamics.components import (
    FloatArray,
    cross,
    dot,
    matvec,
    point_tensor,
    rotated_tensor,
    solve_symmetric,
    upper,
)
from tfsat_host.dynamics.multibody import Columns, Multibody, batch_first, batch_last
from tfsat_host.dynamics.poses import Placed, pad, place


class Composite(NamedTuple):
    """Bodies that move as one: mass (...), center of mass (3, ...) and inertia about it (3, 3, ...), base axes."""

    mass: FloatArray
    com: FloatArray
    inertia: FloatArray


class Coefficients(NamedTuple):
    """I (3, 3, ...) and A (3, n - 1, ...) of h = I w + A q', base axes."""

    inertia: FloatArray
    joints: FloatArray


def locked_inertia(body: Multibody, angles_rad: FloatArray) -> FloatArray:
    """Inertia (..., 3, 3), kg m^2, of the robot with locked joints about its center of mass, base axes.

    Args:
        body: The robot, or a batch of robots.
        angles_rad: (..., n - 1) joint angles.
    """
    return batch_first(_coefficients(body, angles_rad).inertia, 2)


def joint_momentum(body: Multibody, angles_rad: FloatArray) -> FloatArray:
    """(..., 3, n - 1): angular momentum for unit rate of each joint while the base is at rest, base axes.

    Args:
        body: The robot, or a batch of robots.
        angles_rad: (..., n - 1) joint angles.
    """
    return batch_first(_coefficients(body, angles_rad).joints, 2)


def connection(body: Multibody, angles_rad: FloatArray) -> FloatArray:
    """(..., 3, n - 1): the base rate for unit rate of each joint at zero momentum, base axes.

    Args:
        body: The robot, or a batch of robots.
        angles_rad: (..., n - 1) joint angles.
    """
    found = _coefficients(body, angles_rad)
    rates = np.empty_like(found.joints)
    for j in range(body.n_joints):
        rates[:, j] = solve_symmetric(upper(found.inertia), -found.joints[:, j])
    return batch_first(rates, 2)


def kinetic_energy_j(
    body: Multibody, angles_rad: FloatArray, rates_rad_s: FloatArray, base_rate_rad_s: FloatArray
) -> FloatArray:
    """Kinetic energy (...) of the motion about the center of mass, J.

    Args:
        body: The robot, or a batch of robots.
        angles_rad: (..., n - 1) joint angles.
        rates_rad_s: (..., n - 1) joint rates.
        base_rate_rad_s: (..., 3) rate of the base body, base axes.

    The batch axes of all arguments are broadcast against each other.
    """
    given = [np.asarray(v, dtype=np.float64) for v in (angles_rad, rates_rad_s, base_rate_rad_s)]
    shape = np.broadcast_shapes(body.batch_shape, *(v.shape[:-1] for v in given))
    columns = body.columns(len(shape))
    angles, joint_rates, base_rate = (pad(batch_last(v), 1, len(shape)) for v in given)
    placed = place(body, columns, angles)
    com = [p.at(columns.com[i]) for i, p in enumerate(placed)]
    rate, velocity = [base_rate] * body.n_bodies, [cross(base_rate, c) for c in com]
    for step in body.steps:
        turn, point = _hinge(step.joint, step.sign, columns, placed[step.parent])
        turn = turn * joint_rates[step.joint]
        for i in body.moved_by(step.joint):
            rate[i] = rate[i] + turn
            velocity[i] = velocity[i] + cross(turn, com[i] - point)
    mass = columns.mass
    mean = sum(m * v for m, v in zip(mass, velocity, strict=True)) / mass.sum(axis=0)
    energy = sum(
        dot(rate[i], matvec(rotated_tensor(placed[i].rotation, columns.inertia[i]), rate[i]))
        + mass[i] * dot(velocity[i] - mean, velocity[i] - mean)
        for i in range(body.n_bodies)
    )
    return np.array(np.broadcast_to(0.5 * energy, shape))


def coefficients(body: Multibody, columns: Columns, angles: FloatArray) -> Coefficients:
    """I and A at joint angles (n - 1, ...), components first."""
    placed = place(body, columns, angles)
    bodies = [
        Composite(columns.mass[i], p.at(columns.com[i]), rotated_tensor(p.rotation, columns.inertia[i]))
        for i, p in enumerate(placed)
    ]
    whole = join(bodies)
    per_joint: list[FloatArray] = [np.empty(0)] * body.n_joints
    for step in body.steps:
        moved = join([bodies[i] for i in body.moved_by(step.joint)])
        axis, point = _hinge(step.joint, step.sign, columns, placed[step.parent])
        swing = moved.mass * cross(moved.com - whole.com, cross(axis, moved.com - point))
        per_joint[step.joint] = matvec(moved.inertia, axis) + swing
    if not per_joint:
        return Coefficients(
            whole.inertia, np.zeros((3, 0, *np.broadcast_shapes(whole.mass.shape, angles.shape[1:])))
        )
    return Coefficients(whole.inertia, np.stack(np.broadcast_arrays(*per_joint), axis=1))


def join(bodies: list[Composite]) -> Composite:
    """The bodies as one rigid body."""
    mass = np.asarray(sum(b.mass for b in bodies))
    com = np.asarray(sum(b.mass * b.com for b in bodies) / mass)
    return Composite(
        mass, com, np.asarray(sum(b.inertia + b.mass * point_tensor(b.com - com) for b in bodies))
    )


def _hinge(joint: int, sign: float, columns: Columns, parent: Placed) -> tuple[FloatArray, FloatArray]:
    """Direction about which the joint turns its far side, and a point on its axis, base frame."""
    return matvec(parent.rotation, sign * columns.axis[joint]), parent.at(columns.point[joint])


def _coefficients(body: Multibody, angles_rad: FloatArray) -> Coefficients:
    """I and A in the whole batch shape of robots and angles."""
    angles = np.asarray(angles_rad, dtype=np.float64)
    shape = np.broadcast_shapes(body.batch_shape, angles.shape[:-1])
    found = coefficients(body, body.columns(len(shape)), pad(batch_last(angles), 1, len(shape)))
    return Coefficients(*(np.broadcast_to(v, v.shape[:2] + shape) for v in found))
