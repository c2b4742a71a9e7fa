"""The evaluation's topics, and their messages by time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.body_frames import WORLD, frame_name
from tfsat_host.evaluation.evaluation import Evaluation
from tfsat_host.evaluation.model_fit.momentum import inertial_momentum
from tfsat_host.evaluation.model_fit.prediction import Sides
from tfsat_host.report.contents.attitudes import euler_angles
from tfsat_host.report.contents.charts.momentum import PER_KG_M2_S, averages_of, bodies_of
from tfsat_host.report.contents.poses import body_poses
from tfsat_host.report.recording.schemas import message_classes
from tfsat_host.sdlog.export_mcap import Channel, Messages, Stamp

FloatArray = NDArray[np.float64]

FILED, CORRECTED = "model_filed", "model_corrected"
MODELS = {"before": FILED, "after": CORRECTED}
"""The topics of the model as its file has it, and of the corrected one."""


class Topics:
    """Makes the channels of one evaluation.

    Args:
        found: The evaluation.
        stamp: Writes times of the logger's clock into messages.
    """

    def __init__(self, found: Evaluation, stamp: Stamp) -> None:
        self._found = found
        self._stamp = stamp
        self._classes = message_classes()

    def channels(self) -> list[Channel]:
        """All of them."""
        return [
            *self._frames(),
            *self._angles(),
            *self._rates(),
            *self._joints(),
            *self._momenta(),
            *self._errors(),
        ]

    def t_us(self, t_s: FloatArray) -> list[int]:
        """The logger's clock of times after the release: whole microseconds, as they were recorded."""
        return [int(value) for value in np.rint(t_s * 1e6).astype(np.int64) + self._found.log.origin_us]

    def _frames(self) -> list[Channel]:
        from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform

        moved = body_poses(self._found)
        made = []
        for place, prefix, poses in (
            ("evaluated", "", moved.measured),
            (FILED, f"{FILED}/", moved.predicted),
        ):
            for body, name in enumerate(self._found.model.body_names):
                child = f"{prefix}{frame_name(name)}"
                message = FrameTransform(parent_frame_id=WORLD, child_frame_id=child)
                topic = f"/{place}/tf/{frame_name(name)}"
                made.append(self._channel(topic, message, moved.t_s, poses[:, body], _set_pose))
        return made

    def _angles(self) -> list[Channel]:
        angles, model = euler_angles(self._found), self._classes["ModelAngles"]()
        measured = np.rad2deg(np.hstack([angles.measured_rad, angles.std_rad]))
        return [
            self._channel(
                "/evaluated/body_1/euler", self._classes["EulerAngles"](), angles.t_s, measured, _set_angles
            ),
            *(
                self._channel(
                    f"/{place}/body_1/euler", model, angles.t_s, np.rad2deg(values), _set_model_angles
                )
                for place, values in ((FILED, angles.before_rad), (CORRECTED, angles.after_rad))
            ),
        ]

    def _rates(self) -> list[Channel]:
        message = self._classes["BodyRate"]()
        return [
            self._channel(
                f"/evaluated/body_{index}/rate", message, body.t_s, np.rad2deg(body.rate_rad_s), _set_rate
            )
            for index, body in enumerate(self._found.motion.bodies, 1)
        ]

    def _joints(self) -> list[Channel]:
        motion = self._found.motion
        made = []
        for joint in motion.joints:
            rate = motion.fused.joint_rate_rad_s[:, joint.joint - 1]
            rows = np.rad2deg(np.column_stack([joint.angle_rad, joint.std_rad(), rate]))
            topic = f"/evaluated/joint_{joint.joint}"
            made.append(self._channel(topic, self._classes["EvaluatedJoint"](), motion.t_s, rows, _set_joint))
        return made

    def _momenta(self) -> list[Channel]:
        message, flown = self._classes["Momentum"](), self._found.explained.driven.flown
        every = [
            self._channel(
                f"/{MODELS[kind]}/momentum",
                message,
                flown.t_s,
                PER_KG_M2_S * inertial_momentum(body, flown),
                _set_momentum,
            )
            for kind, body in bodies_of(self._found)
        ]
        return every + [
            self._channel(
                f"/{MODELS[kind]}/momentum_averaged",
                message,
                one.t_s,
                PER_KG_M2_S * one.values,
                _set_momentum,
            )
            for kind, one in averages_of(self._found)
        ]

    def _errors(self) -> list[Channel]:
        sides: tuple[tuple[str, Sides], ...] = (
            (FILED, self._found.explained.before),
            (CORRECTED, self._found.explained.after),
        )
        return [
            self._channel(
                f"/{place}/body_1/attitude_error",
                self._classes["EulerAngles"](),
                side.error.t_s,
                np.rad2deg(np.hstack([side.error.euler_zyx_rad, side.error.std_rad])),
                _set_angles,
            )
            for place, side in sides
        ]

    def _channel(self, topic: str, message: Any, t_s: FloatArray, rows: FloatArray, write: Any) -> Channel:
        """Rows that hold no number are no message: Protobuf would show 0."""
        known = np.isfinite(rows).all(axis=1)

        def messages() -> Messages:
            for t_us, row in zip(self.t_us(t_s[known]), rows[known].tolist(), strict=True):
                self._stamp(message, t_us)
                write(message, row)
                yield t_us, message.SerializeToString()

        return Channel(topic, type(message), messages)


def _set_pose(message: Any, row: Sequence[float]) -> None:
    place, turn = message.translation, message.rotation
    place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w = row


def _set_angles(message: Any, row: Sequence[float]) -> None:
    message.z_deg, message.y_deg, message.x_deg, message.z_deg_std, message.y_deg_std, message.x_deg_std = row


def _set_model_angles(message: Any, row: Sequence[float]) -> None:
    message.z_deg, message.y_deg, message.x_deg = row


def _set_rate(message: Any, row: Sequence[float]) -> None:
    message.rate_deg_s.x, message.rate_deg_s.y, message.rate_deg_s.z = row


def _set_joint(message: Any, row: Sequence[float]) -> None:
    message.angle_deg, message.angle_deg_std, message.rate_deg_s = row


def _set_momentum(message: Any, row: Sequence[float]) -> None:
    vector = message.momentum_g_m2_s
    vector.x, vector.y, vector.z = row
