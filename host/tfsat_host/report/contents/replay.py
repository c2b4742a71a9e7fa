"""The replay in three dimensions: boxes, and where the bodies were.

Bodies stand about the robot's center of mass, which in free fall stays where it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from operator import itemgetter

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from tfsat_host.arrays import FloatArray
from tfsat_host.dynamics.multibody import Multibody
from tfsat_host.dynamics.poses import poses
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.evaluation.reference_maneuver import fly_reference
from tfsat_host.quantity import Column, Columns, fields
from tfsat_host.report.contents.attitude_charts import driven_samples
from tfsat_host.report.contents.chart import numbers, pad_rows
from tfsat_host.report.document_rounding import poses_to_keep, round_poses
from tfsat_host.robot import RobotModel
from tfsat_host.robot.absent_parts import bodies_of

_CORNERS = 8
_HALF_CUBE_M = 0.05
"""Of a body without a stated shape, about its center of mass: a CubeSat's unit."""


@dataclass(frozen=True, eq=False)
class BodyPoses:
    """All b bodies at k samples from the release on; inertial axes are those of the base at the first of them.

    Attributes:
        t_s: (k,) after the release.
        measured: (k, b, 7) origin of each body's frame from the robot's CoM, m, and its quaternion x y z w. Attitude by
            the base's gyro, angles by gyros and angle sensors, CoM by the fitted model, or the nominal one if that is
            withheld.
        predicted: (k, b, 7) the same by the nominal model, driven by the measured joint angles; NaN until
            the release has settled.
    """

    t_s: FloatArray
    measured: FloatArray
    predicted: FloatArray


def body_poses(evaluation: Evaluation) -> BodyPoses:
    """Compute the poses of the bodies during one drop, measured and predicted."""
    moved = evaluation.motion.bodies[evaluation.model.base]
    angles = evaluation.motion.angles_rad[evaluation.motion.samples.fall]
    attitude = moved.attitude.as_matrix()
    driven = driven_samples(evaluation)
    offsets, sides = evaluation.explained.driven.offsets, evaluation.explained.nominal
    # A prediction begins at the identity: turn it into the inertial axes of the measured attitude.
    predicted = attitude[driven][0] @ sides.prediction.attitude
    # The ghost is built by the nominal model, the measured robot by the fitted one.
    ghost = _place_bodies(offsets.body, evaluation.model, angles[driven], predicted)
    fitted = evaluation.explained.fit.values
    corrected = offsets.correct(fitted) if evaluation.is_given("offsets") else offsets.body
    return BodyPoses(
        moved.t_s, _place_bodies(corrected, evaluation.model, angles, attitude), pad_rows(driven, ghost)
    )


def _place_bodies(
    body: Multibody, model: RobotModel, angles_rad: FloatArray, attitude: FloatArray
) -> FloatArray:
    """(k, b, 7) of joint angles (k, joints) and attitudes (k, 3, 3) of the base."""
    rotation, translation = poses(body, angles_rad)
    # (k, b, 3) centers of mass in base axes, then (k, 3) the robot's, weighted by mass.
    com = np.einsum("kbij,bj->kbi", rotation, body.com_m) + translation
    center = np.einsum("b,kbi->ki", body.mass_kg / body.mass_kg.sum(), com)
    # Origins about the robot's CoM: in free fall that point is inertial.
    origin = np.einsum("kbij,bj->kbi", rotation, model.origin_m) + translation - center[:, None]
    turned = attitude[:, None] @ rotation
    # Scipy takes one stack of matrices: flatten (k, b), then restore it.
    quaternion = Rotation.from_matrix(turned.reshape(-1, 3, 3)).as_quat().reshape(*turned.shape[:2], 4)
    return np.concatenate([np.einsum("kij,kbj->kbi", attitude, origin), quaternion], axis=2)


@dataclass(frozen=True, eq=False)
class Replay:
    """Each body's name and boxes, and the bodies' poses, no more and no finer than a screen shows.

    `reference`: (k, b, 7) poses as of `BodyPoses` of 59/70; None: there is nothing to compare with it.
    """

    bodies: list[tuple[str, list[list[list[float]]]]]
    poses: BodyPoses
    reference: FloatArray | None


def replay_of(evaluation: Evaluation) -> Replay | None:
    """Build the replay: as measured, and by the nominal model; None if the sensors are not trusted."""
    if not evaluation.is_given():
        return None
    moved, model = body_poses(evaluation), evaluation.model
    kept = poses_to_keep(moved.t_s)
    poses = BodyPoses(
        moved.t_s[kept].round(4), round_poses(moved.measured[kept]), round_poses(moved.predicted[kept])
    )
    bodies = [(name, boxes_of(model, body)) for body, name in enumerate(model.body_names)]
    return Replay(bodies, poses, _reference_poses(evaluation, moved.t_s[kept]))


def _reference_poses(evaluation: Evaluation, t_s: FloatArray) -> FloatArray | None:
    """(k, b, 7) of 59/70 at the same times, in the inertial axes of the replay."""
    simulation = fly_reference(evaluation)
    if simulation is None:
        return None
    flight = simulation.flight
    attitude = Slerp(flight.t_s, Rotation.from_quat(flight.quaternion_xyzw))(t_s.clip(*flight.t_s[[0, -1]]))
    angles = np.column_stack([np.interp(t_s, flight.t_s, angle) for angle in flight.angles_rad.T])
    return round_poses(_place_bodies(flight.body, evaluation.model, angles, attitude.as_matrix()))


_BODY: Columns = (Column("name", of=itemgetter(0)), Column("boxes_m", of=itemgetter(1)))
_REPLAY: Columns = (
    Column("bodies", columns=_BODY),
    *fields("t_s=poses.t_s"),
    Column("measured", of=lambda replay: numbers(replay.poses.measured)),
    Column("model", of=lambda replay: numbers(replay.poses.predicted)),
)
"""For the page; a pose with a null in it is not drawn."""


def replay_columns(replay: Replay) -> Columns:
    """Return the columns of a replay for the page; those of 59/70 where it has them."""
    reference = Column("reference", of=lambda replay: numbers(replay.reference))
    return _REPLAY if replay.reference is None else (*_REPLAY, reference)


def boxes_of(model: RobotModel, body: int) -> list[list[list[float]]]:
    """Low and high corner of each box of a body, in its frame.

    A robot file states boxes, whose corners are in `shape_m` eight by eight.
    """
    corners_m, com_m = model.shape_m[body], model.com_m[body]
    if body + 1 not in bodies_of(model):
        return []
    if not len(corners_m):
        return [[(com_m - _HALF_CUBE_M).tolist(), (com_m + _HALF_CUBE_M).tolist()]]
    count, remainder = divmod(len(corners_m), _CORNERS)
    # Corners that are not eight by eight are no boxes: take the one around all of them.
    boxes = corners_m[None] if remainder else corners_m.reshape(count, _CORNERS, 3)
    return [[box.min(axis=0).tolist(), box.max(axis=0).tolist()] for box in boxes]
