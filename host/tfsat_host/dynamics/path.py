"""Where a path of strokes leads at zero angular momentum: the product of the strokes' rotations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.components import FloatArray
from tfsat_host.dynamics.multibody import Multibody, batch_first, batch_last
from tfsat_host.dynamics.stroke import STEPS, stroke_rotation


def path_rotation(
    body: Multibody,
    joints: Sequence[int],
    deltas_rad: FloatArray,
    *,
    start_rad: FloatArray | None = None,
    steps: int = STEPS,
) -> FloatArray:
    """Rotation of the base by strokes one after another, at zero angular momentum.

    Args:
        body: The robot, or a batch of robots.
        joints: (k,) index of the joint of each stroke.
        deltas_rad: (..., k) by how much each moves.
        start_rad: (..., n - 1) joint angles at the start; zero if None.
        steps: Steps of order 6 into which each stroke is divided.

    Returns:
        Quaternions (..., 4), scalar last: from base axes at the end to base axes at the start. After a closed
        loop, which leads every joint back, the rotation is the same for every body.
    """
    deltas = np.asarray(deltas_rad, dtype=np.float64)
    start = np.zeros(body.n_joints) if start_rad is None else np.asarray(start_rad, dtype=np.float64)
    angles = np.array(
        np.broadcast_to(start, np.broadcast_shapes(start.shape[:-1], deltas.shape[:-1]) + start.shape[-1:])
    )
    rotation = quaternion.identity((1,) * max(len(body.batch_shape), angles.ndim - 1))
    for stroke, joint in enumerate(joints):
        turned = stroke_rotation(body, joint, angles, deltas[..., stroke], steps=steps)
        rotation = quaternion.product(rotation, batch_last(turned))
        angles[..., joint] += deltas[..., stroke]
    return batch_first(rotation)


def rotation_vector_rad(quaternion_xyzw: FloatArray) -> FloatArray:
    """Rotation vectors (..., 3), rad, of quaternions (..., 4), the shorter way round."""
    return batch_first(quaternion.logarithm(batch_last(np.asarray(quaternion_xyzw, dtype=np.float64))))


def rotation_angle_rad(quaternion_xyzw: FloatArray) -> FloatArray:
    """Rotation angles (...), 0 to pi, of quaternions (..., 4)."""
    return quaternion.angle(batch_last(np.asarray(quaternion_xyzw, dtype=np.float64)))
