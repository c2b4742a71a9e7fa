"""Where a path of strokes leads at zero angular momentum: the product of the strokes' rotations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tfsat_host.dynamics import quaternion
from tfsat_host.dynamics.components import FloatArray
from tfsat_host.dynamics.multibody import Multibody, batch_first, batch_last
from tfsat_host.dynamics.stroke import TOLERANCE_RAD, stroke_rotation


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


def rotation_vector_rad(quaternion_xyzw: FloatArray) -> FloatArray:
    """Rotation vectors (..., 3), rad, of quaternions (..., 4), the shorter way round."""
    return batch_first(quaternion.logarithm(batch_last(np.asarray(quaternion_xyzw, dtype=np.float64))))


def rotation_angle_rad(quaternion_xyzw: FloatArray) -> FloatArray:
    """Rotation angles (...), 0 to pi, of quaternions (..., 4)."""
    return quaternion.angle(batch_last(np.asarray(quaternion_xyzw, dtype=np.float64)))
