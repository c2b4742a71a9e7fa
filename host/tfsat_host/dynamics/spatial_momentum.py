"""Angular momentum of a free-floating robot about its center of mass, and what its conservation demands.

With base rate w and joint rates q', both in base axes, the momentum is h = I(q) w + A(q) q'. Without external
torque it is constant in inertial axes; from h = 0 follows w = -I^-1 A q', the connection of the
falling cat (paper, section "Nonholonomic attitude reorientation").
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.components import (
    batch_first,
    cross,
    dot,
    matvec,
    point_tensor,
    rotated_tensor,
    rotation_about,
    solve_symmetric,
    upper,
)
from tfsat_host.dynamics.multibody import Columns, Multibody, Step
from tfsat_host.dynamics.poses import BodyPlacement, place


class Composite(NamedTuple):
    """Bodies as one, in the axes of one of them.

    Attributes:
        mass: (...).
        com: (3, ...) center of mass.
        inertia: (3, 3, ...) about the center of mass.
        velocity: (3, ...) of the center of mass, by the joints between the bodies; None while they rest.
        momentum: (3, ...) angular momentum about the center of mass, likewise.
    """

    mass: FloatArray
    com: FloatArray
    inertia: FloatArray
    velocity: FloatArray | None = None
    momentum: FloatArray | None = None


def locked_inertia(body: Multibody, angles_rad: FloatArray) -> FloatArray:
    """Inertia (..., 3, 3), kg m^2, of the robot with locked joints about its center of mass, base axes.

    Args:
        body: The robot, or a batch of robots.
        angles_rad: (..., n - 1) joint angles.
    """
    shape, (posed,) = body.broadcast(angles_rad)
    composite = compose_bodies(body.columns(len(shape)), body.base, body.steps, posed)
    return batch_first(np.broadcast_to(composite.inertia, (3, 3, *shape)), 2)


def joint_momentum(body: Multibody, angles_rad: FloatArray) -> FloatArray:
    """(..., 3, n - 1): angular momentum for unit rate of each joint while the base is at rest, base axes.

    Args:
        body: The robot, or a batch of robots.
        angles_rad: (..., n - 1) joint angles.
    """
    return batch_first(_unit_rates(body, angles_rad)[1], 2)


def inertia_and_joint_momentum(body: Multibody, angles_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """I (..., 3, 3) and A (..., 3, n - 1) of the same pose at once; see `locked_inertia` and `joint_momentum`."""
    inertia, momentum = _unit_rates(body, angles_rad)
    return batch_first(np.broadcast_to(inertia, (3, 3, 1, *momentum.shape[2:]))[:, :, 0], 2), batch_first(
        momentum, 2
    )


def angular_momentum(
    body: Multibody, angles_rad: FloatArray, base_rate_rad_s: FloatArray, rates_rad_s: FloatArray
) -> FloatArray:
    """h (..., 3), kg m^2/s, about the center of mass, base axes.

    Args:
        body: The robot, or a batch of robots.
        angles_rad: (..., n - 1) joint angles.
        base_rate_rad_s: (..., 3) rate of the base body, base axes.
        rates_rad_s: (..., n - 1) joint rates.

    The batch axes of all arguments are broadcast against each other.
    """
    shape, (angles, base_rate, rates) = body.broadcast(angles_rad, base_rate_rad_s, rates_rad_s)
    composite = compose_bodies(body.columns(len(shape)), body.base, body.steps, angles, list(rates))
    momentum = matvec(composite.inertia, base_rate) + _or_zero(composite.momentum)
    return batch_first(np.broadcast_to(momentum, (3, *shape)), 1)


def connection(body: Multibody, angles_rad: FloatArray) -> FloatArray:
    """(..., 3, n - 1): the base rate for unit rate of each joint at zero momentum, base axes.

    Args:
        body: The robot, or a batch of robots.
        angles_rad: (..., n - 1) joint angles.
    """
    inertia, momentum = _unit_rates(body, angles_rad)
    return batch_first(solve_symmetric(upper(inertia), -momentum), 2)


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
    shape, (angles, joint_rates, base_rate) = body.broadcast(angles_rad, rates_rad_s, base_rate_rad_s)
    columns = body.columns(len(shape))
    placed = place(body, columns, angles)
    com = [p.at(columns.com[i]) for i, p in enumerate(placed)]
    # Every body turns as the base; each joint then adds its turn to the bodies that it moves.
    rate, velocity = [base_rate] * body.n_bodies, [cross(base_rate, c) for c in com]
    for step in body.steps:
        turn, point = _hinge(step, columns, placed)
        turn = turn * joint_rates[step.joint]
        for i in body.moved_by(step.joint):
            rate[i] = rate[i] + turn
            velocity[i] = velocity[i] + cross(turn, com[i] - point)
    mass = columns.mass
    # Take off the velocity of the center of mass: only motion about it counts.
    mean = sum(m * v for m, v in zip(mass, velocity, strict=True)) / mass.sum(axis=0)
    energy = sum(
        dot(rate[i], matvec(rotated_tensor(placed[i].rotation, columns.inertia[i]), rate[i]))
        + mass[i] * dot(velocity[i] - mean, velocity[i] - mean)
        for i in range(body.n_bodies)
    )
    return np.array(np.broadcast_to(0.5 * energy, shape))


def compose_bodies(
    columns: Columns,
    root: int,
    steps: Sequence[Step],
    angles: Sequence[FloatArray] | FloatArray,
    rates: Sequence[FloatArray | None] | None = None,
) -> Composite:
    """Combine body `root` and the bodies that `steps` lead to into one body, in its axes.

    Args:
        columns: The robot's arrays.
        root: Index of the body.
        steps: Joints, in order from it outwards.
        angles: n - 1 angles (...) of the joints, each of its own shape.
        rates: n - 1 rates (...), None for a joint at rest; None if all are.
    """
    attached = [
        [Composite(m, c, i)] for m, c, i in zip(columns.mass, columns.com, columns.inertia, strict=True)
    ]
    # Composite rigid bodies, leaves first: a branch is whole before its joint joins it to the parent.
    for step in reversed(steps):
        branch, axis, point = join(attached[step.child]), columns.axis[step.joint], columns.point[step.joint]
        turn = rotation_about(axis, step.sign * angles[step.joint])
        lever = matvec(turn, branch.com - point)
        inertia = rotated_tensor(turn, branch.inertia)
        velocity, momentum = (v if v is None else matvec(turn, v) for v in (branch.velocity, branch.momentum))
        # The joint's own spin, on top of what the joints inside the branch do.
        if rates is not None and (rate := rates[step.joint]) is not None:
            spin = step.sign * axis * rate
            velocity = _or_zero(velocity) + cross(spin, lever)
            momentum = _or_zero(momentum) + matvec(inertia, spin)
        attached[step.parent].append(Composite(branch.mass, point + lever, inertia, velocity, momentum))
    return join(attached[root])


def join(bodies: Sequence[Composite]) -> Composite:
    """Combine the bodies into one."""
    return reduce(_join_composites, bodies)


def _join_composites(a: Composite, b: Composite) -> Composite:
    mass, gap = a.mass + b.mass, b.com - a.com
    share = b.mass / mass
    # Parallel axis theorem about the common center of mass, with the reduced mass.
    reduced = a.mass * share
    composite = Composite(
        mass, a.com + share * gap, a.inertia + b.inertia + reduced * point_tensor(gap), a.velocity, a.momentum
    )
    if a.velocity is None and b.velocity is None:
        return composite
    velocity, momentum = _or_zero(a.velocity), _or_zero(a.momentum) + _or_zero(b.momentum)
    # The centers' relative motion carries angular momentum of the reduced mass.
    apart = _or_zero(b.velocity) - velocity
    return composite._replace(
        velocity=velocity + share * apart, momentum=momentum + reduced * cross(gap, apart)
    )


def _or_zero(motion: FloatArray | None) -> FloatArray:
    return np.zeros(()) if motion is None else motion


def _hinge(step: Step, columns: Columns, placed: list[BodyPlacement]) -> tuple[FloatArray, FloatArray]:
    """Direction about which the joint turns its far side, and a point on its axis, base frame."""
    parent = placed[step.parent]
    return matvec(parent.rotation, step.sign * columns.axis[step.joint]), parent.at(columns.point[step.joint])


def _unit_rates(body: Multibody, angles_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """I (3, 3, 1, ...) and A (3, n - 1, ...): the joints turn one after another, on one axis more than the batch's."""
    shape, (posed,) = body.broadcast(angles_rad)
    # Along the added axis joint k alone turns in sample k: one pass gives all columns of A.
    rates = np.expand_dims(np.eye(body.n_joints), tuple(range(2, 2 + len(shape))))
    composite = compose_bodies(
        body.columns(len(shape) + 1), body.base, body.steps, posed[:, None], list(rates)
    )
    return composite.inertia, np.zeros((3, body.n_joints, *shape)) + _or_zero(composite.momentum)
