"""How the angular momentum about the center of mass changes with each number by which a model may be off.

With r and v a body's center of mass and its velocity, both relative to the whole robot's, w its rate, R its rotation
and I its inertia, the momentum is h = sum of R I R^T w + m r x v. Since m r and m v sum to zero, the motion of the
whole robot's center drops out of every first derivative:

    mass, by its logarithm        m r x v
    center of mass by d           m (R d x v + r x (w x R d))
    inertia by dI                 R dI R^T w
    hinge point by d              the same as of a center of mass, summed over the bodies beyond the hinge, with
                                  R_i d of the body before the hinge less R_o d of the body beyond it
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.com_fit.offsets import Kind, Offsets, Parameter


class MovingBodies(NamedTuple):
    """The bodies of a robot at m samples, base axes.

    Attributes:
        mass_kg: (n,).
        rotation: (m, n, 3, 3) from each body's axes.
        rate_rad_s: (m, n, 3).
        com_m: (m, n, 3) centers of mass relative to the whole robot's.
        velocity_m_s: (m, n, 3) of those, likewise relative.
    """

    mass_kg: FloatArray
    rotation: FloatArray
    rate_rad_s: FloatArray
    com_m: FloatArray
    velocity_m_s: FloatArray

    @classmethod
    def of(
        cls,
        body: Multibody,
        angles_rad: FloatArray,
        base_rate_rad_s: FloatArray,
        joint_rate_rad_s: FloatArray,
    ) -> MovingBodies:
        """Compute the bodies' motion from the joint angles and the rates of base and joints.

        Joint angles are (m, n - 1), the base's rate (m, 3) and joint rates (m, n - 1).
        """
        rotation, translation = poses(body, angles_rad)
        place = np.einsum("mnij,nj->mni", rotation, body.com_m) + translation
        # First as one rigid body that turns with the base; its translation drops out below.
        rate = np.repeat(base_rate_rad_s[:, None], body.n_bodies, axis=1)
        velocity = np.cross(rate, place)
        # Each joint then turns all bodies beyond it about its hinge.
        for step in body.steps:
            axis = step.sign * rotation[:, step.parent] @ body.joint_axis[step.joint]
            hinge = rotation[:, step.parent] @ body.joint_point_m[step.joint] + translation[:, step.parent]
            turn = axis * joint_rate_rad_s[:, step.joint, None]
            for far in body.moved_by(step.joint):
                rate[:, far] += turn
                velocity[:, far] += np.cross(turn, place[:, far] - hinge)
        share = body.mass_kg / body.mass_kg.sum()
        return cls(
            body.mass_kg,
            rotation,
            rate,
            place - np.einsum("n,mni->mi", share, place)[:, None],
            velocity - np.einsum("n,mni->mi", share, velocity)[:, None],
        )

    def shift_momentum(self, body: int, of: int) -> FloatArray:
        """(m, 3, 3) momentum by a shift of a body's center of mass in the axes of body `of`.

        Of a shift d it is m (R d x v + r x (w x R d)) = m (w r^T - r.w 1 - [v]) R d, where [v] a = v x a.
        """
        com, velocity = self.com_m[:, body], self.velocity_m_s[:, body]
        rate = self.rate_rad_s[:, of]
        # By the double cross product r x (w x d) = w (r.d) - d (r.w); both factors are (m, 3).
        across = rate[:, :, None] * com[:, None, :]
        across -= np.einsum("mi,mi->m", rate, com)[:, None, None] * np.eye(3)
        # Rows v x e_j: the transpose of [v], which is -[v].
        across += np.cross(velocity[:, None], np.eye(3))
        return np.asarray(self.mass_kg[body] * across @ self.rotation[:, of])


def momentum_slopes(offsets: Offsets, vector: FloatArray, moving: MovingBodies) -> FloatArray:
    """(m, 3, p) of the momentum, base axes, in the p offsets' units, taken at `vector` (p,).

    `moving` is the robot with those offsets.
    """
    slopes = np.empty((len(moving.rate_rad_s), 3, len(offsets)))
    # Parameters of one kind and body share what does not depend on them: one product for all.
    for (kind, of), columns in _by_what(offsets.parameters).items():
        parameters = [offsets.parameters[column] for column in columns]
        units = np.array([parameter.si for parameter in parameters])
        slopes[:, :, columns] = units * _slopes(kind, of, parameters, offsets, vector, moving)
    return slopes


def _by_what(parameters: Sequence[Parameter]) -> dict[tuple[Kind, int], list[int]]:
    """Group the parameters' columns by kind and by body or joint."""
    columns: dict[tuple[Kind, int], list[int]] = {}
    for column, parameter in enumerate(parameters):
        columns.setdefault((parameter.kind, parameter.of), []).append(column)
    return columns


def _slopes(
    kind: Kind,
    of: int,
    parameters: Sequence[Parameter],
    offsets: Offsets,
    vector: FloatArray,
    moving: MovingBodies,
) -> FloatArray:
    """(m, 3, k) in SI, of k parameters of one kind and one body or joint."""
    # By the mass's logarithm: the slope is the body's own share m r x v.
    if kind == "mass":
        momentum = moving.mass_kg[of] * np.cross(moving.com_m[:, of], moving.velocity_m_s[:, of])
        return np.asarray(momentum[..., None])
    if kind == "inertia":
        turn = moving.rotation[:, of]
        # In the body's own axes, where a change of its tensor is constant.
        own_rate = np.einsum("mij,mi->mj", turn, moving.rate_rad_s[:, of])
        changes = np.stack([offsets.inertia_slope(parameter, vector) for parameter in parameters], axis=-1)
        return turn @ np.tensordot(own_rate, changes, ((1,), (1,)))
    if kind == "com":
        by_point = moving.shift_momentum(of, of)
    else:
        # The point is fixed in both bodies of the hinge: moving it shifts all beyond by R_i d - R_o d.
        step = next(step for step in offsets.body.steps if step.joint == of)
        beyond = offsets.body.moved_by(of)
        shifts = [
            moving.shift_momentum(far, step.parent) - moving.shift_momentum(far, step.child) for far in beyond
        ]
        by_point = np.sum(shifts, axis=0)
    return by_point @ np.stack([parameter.shape for parameter in parameters], axis=-1)
