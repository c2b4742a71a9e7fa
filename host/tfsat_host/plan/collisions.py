"""Whether bodies of a robot strike one another on their way: the boxes of its file, by the separating axis theorem.

Two convex boxes are apart if and only if the projections on one of fifteen axes are: the faces' normals of both, and
the cross products of their edges (S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, SIGGRAPH 1996). The greatest of the
gaps between projections is a lower bound of the distance.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics import Multibody, poses
from tfsat_host.robot import RobotModel

# Neighbours touch at their hinge, and boxes are good to some tenths.
CONTACT_MM = 0.5
_PARALLEL = 1e-9


class Gap(NamedTuple):
    """The least gap between two bodies.

    Attributes:
        bodies: Their names.
        gap_mm: Lower bound of their distance; negative: so deep do they overlap.
        instant: Index of the pose.
    """

    bodies: tuple[str, str]
    gap_mm: float
    instant: int


def least_gap(robot: RobotModel, angles_rad: FloatArray) -> Gap:
    """Return the least gap between any two bodies over poses with joint angles (m, n - 1).

    Every body must have a shape.
    """
    rotation, translation = poses(Multibody.of(robot), angles_rad)
    # Each body's boxes of eight corners, global at zero angles: middle and half sizes (k, 3).
    corners = [
        (origin + shape).reshape(-1, 8, 3)
        for origin, shape in zip(robot.origin_m, robot.shape_m, strict=True)
    ]
    middle = [0.5 * (body.max(axis=1) + body.min(axis=1)) for body in corners]
    half = [0.5 * np.ptp(body, axis=1) for body in corners]
    gaps = []
    for i, k in itertools.combinations(range(robot.n_bodies), 2):
        turns = rotation[:, i], rotation[:, k]
        axes = _separating_axes(*turns)
        for a, b in itertools.product(range(len(middle[i])), range(len(middle[k]))):
            first = turns[0] @ middle[i][a] + translation[:, i]
            second = turns[1] @ middle[k][b] + translation[:, k]
            distance = np.abs(np.einsum("mxj,mj->mx", axes, second - first))
            spans = (
                np.abs(axes @ turn) @ size for turn, size in zip(turns, (half[i][a], half[k][b]), strict=True)
            )
            gap_mm = 1e3 * (distance - sum(spans)).max(axis=1)
            instant = int(gap_mm.argmin())
            gaps.append(Gap((robot.body_names[i], robot.body_names[k]), float(gap_mm[instant]), instant))
    return min(gaps, key=lambda gap: gap.gap_mm)


def _separating_axes(first: FloatArray, second: FloatArray) -> FloatArray:
    """(m, 15, 3) unit vectors for boxes with orientations (m, 3, 3); a cross product of parallel edges is a face's."""
    faces = first.swapaxes(1, 2), second.swapaxes(1, 2)
    edges = np.cross(faces[0][:, :, None], faces[1][:, None]).reshape(-1, 9, 3)
    length = np.linalg.norm(edges, axis=2, keepdims=True)
    edges = np.where(length > _PARALLEL, edges / np.maximum(length, _PARALLEL), faces[0][:, :1])
    return np.concatenate([*faces, edges], axis=1)
