"""Where each body is, seen from the base, at given joint angles: products of exponentials."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.components import batch_first, matmul, matvec, rotation_about
from tfsat_host.dynamics.multibody import Columns, Multibody


class BodyPlacement(NamedTuple):
    """Components first: a body's point x (global at zero angles) lies at `rotation` x + `translation`."""

    rotation: FloatArray  # (3, 3, ...)
    translation: FloatArray  # (3, ...)

    def at(self, point: FloatArray) -> FloatArray:
        """Compute the position of the body's point `point` (3, ...)."""
        return matvec(self.rotation, point) + self.translation


def poses(body: Multibody, angles_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Poses of all bodies in the base frame.

    Args:
        body: The robot, or a batch of robots.
        angles_rad: (..., n - 1) joint angles.

    Returns:
        Rotations (..., n, 3, 3) and translations (..., n, 3): the point of body i that lies at x, global, at
        zero angles lies at `rotation[i] @ x + translation[i]` in the base frame.
    """
    shape, (angles,) = body.broadcast(angles_rad)
    placed = place(body, body.columns(len(shape)), angles)
    rotation = np.stack([np.broadcast_to(p.rotation, (3, 3, *shape)) for p in placed])
    translation = np.stack([np.broadcast_to(p.translation, (3, *shape)) for p in placed])
    return batch_first(rotation, 3), batch_first(translation, 2)


def place(body: Multibody, columns: Columns, angles: FloatArray) -> list[BodyPlacement]:
    """Poses of all bodies, components first; `angles`: (n - 1, ...)."""
    ones = (1,) * (angles.ndim - 1)
    base = BodyPlacement(np.eye(3).reshape(3, 3, *ones), np.zeros((3, *ones)))
    placed = [base] * body.n_bodies
    # Outwards: a parent is placed before its children.
    for step in body.steps:
        parent, axis, point = placed[step.parent], columns.axis[step.joint], columns.point[step.joint]
        turn = rotation_about(axis, step.sign * angles[step.joint])
        # A turn about a line through `point`, carried along by the parent.
        placed[step.child] = BodyPlacement(
            matmul(parent.rotation, turn), parent.at(point - matvec(turn, point))
        )
    return placed
