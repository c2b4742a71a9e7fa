"""The replay in three dimensions: boxes, and where they were."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.report.contents.chart import numbers
from tfsat_host.report.contents.poses import body_poses
from tfsat_host.report.document import Replay, ReplayBody
from tfsat_host.robot import RobotModel

FloatArray = NDArray[np.float64]

_CORNERS = 8
_HALF_CUBE_M = 0.05
"""Of a body without a stated shape, about its center of mass: a CubeSat's unit."""


def replay_of(found: Evaluation) -> Replay:
    """Measured beside the model as its file has it."""
    model, moved = found.model, body_poses(found)
    return Replay(
        bodies=[
            ReplayBody(name=name, boxes_m=boxes_of(model, body)) for body, name in enumerate(model.body_names)
        ],
        t_s=moved.t_s.tolist(),
        measured=_listed(moved.measured),
        model=_listed(moved.predicted),
    )


def boxes_of(model: RobotModel, body: int) -> list[list[list[float]]]:
    """Low and high corner of each box of a body, in its frame.

    A robot file states boxes, whose corners stand in `shape_m` eight by eight.
    """
    corners_m, com_m = model.shape_m[body], model.com_m[body]
    if not len(corners_m):
        return [[(com_m - _HALF_CUBE_M).tolist(), (com_m + _HALF_CUBE_M).tolist()]]
    count, left = divmod(len(corners_m), _CORNERS)
    boxes = corners_m[None] if left else corners_m.reshape(count, _CORNERS, 3)
    return [[box.min(axis=0).tolist(), box.max(axis=0).tolist()] for box in boxes]


def _listed(poses: FloatArray) -> list[list[list[float | None]]]:
    return [[numbers(pose) for pose in bodies] for bodies in poses]
