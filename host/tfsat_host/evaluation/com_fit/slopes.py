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

from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.com_fit.offsets import Offsets, Parameter


class Moving(NamedTuple):
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
    ) -> Moving:
        """From joint angles (m, n - 1), the base's rate (m, 3) and joint rates (m, n - 1)."""
        rotation, translation = poses(body, angles_rad)
        place = np.einsum("mnij,nj->mni", rotation, body.com_m) + translation
        rate = np.repeat(base_rate_rad_s[:, None], body.n_bodies, axis=1)
        velocity = np.cross(rate, place)
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

    def shifted(self, body: int, of: int, direction: FloatArray) -> FloatArray:
        """(m, 3) momentum by a shift of a body's center of mass along (3,) `direction` in the axes of body `of`."""
        by = self.rotation[:, of] @ direction
        turned = np.cross(self.com_m[:, body], np.cross(self.rate_rad_s[:, of], by))
        return np.asarray(self.mass_kg[body] * (np.cross(by, self.velocity_m_s[:, body]) + turned))


def momentum_slopes(offsets: Offsets, vector: FloatArray, moving: Moving) -> FloatArray:
    """(m, 3, p) of the momentum, base axes, in the offsets' units.

    Args:
        offsets: p numbers.
        vector: (p,) where the slopes are taken.
        moving: The robot with those offsets.
    """
    columns = [one.si * _slope(one, offsets, vector, moving) for one in offsets.parameters]
    return np.stack(columns, axis=-1)


def _slope(one: Parameter, offsets: Offsets, vector: FloatArray, moving: Moving) -> FloatArray:
    if one.kind == "mass":
        b = one.of
        return np.asarray(moving.mass_kg[b] * np.cross(moving.com_m[:, b], moving.velocity_m_s[:, b]))
    if one.kind == "com":
        return moving.shifted(one.of, one.of, one.shape)
    if one.kind == "inertia":
        turn = moving.rotation[:, one.of]
        own = turn @ offsets.inertia_slope(one, vector) @ turn.swapaxes(1, 2)
        return np.asarray(np.einsum("mij,mj->mi", own, moving.rate_rad_s[:, one.of]))
    step = next(step for step in offsets.body.steps if step.joint == one.of)
    beyond = [
        moving.shifted(far, step.parent, one.shape) - moving.shifted(far, step.child, one.shape)
        for far in offsets.body.moved_by(one.of)
    ]
    return np.asarray(np.sum(beyond, axis=0))
