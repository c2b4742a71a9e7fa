"""The evaluated drop for Foxglove, PlotJuggler and Rerun: the recording and what it was found to say, as MCAP."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host.arrays import FloatArray, IntArray
from tfsat_host.evaluation.body_frames import WORLD, frame_name
from tfsat_host.evaluation.com_fit.momentum_residual import inertial_momentum
from tfsat_host.evaluation.evaluated_drop import Evaluation
from tfsat_host.report.contents.attitude_charts import euler_angles
from tfsat_host.report.contents.charts import PER_KG_M2_S, averages_of, models_of
from tfsat_host.report.contents.document_builder import ReportedDrop
from tfsat_host.report.contents.event_marks import events_of
from tfsat_host.report.contents.replay import body_poses, boxes_of
from tfsat_host.sdlog.export_mcap import BodyFrames, Channel, Channels, write_mcap
from tfsat_host.sdlog.protobuf_rows import FRAME_TRANSFORM, foxglove_kind, kinds_of, timestamp

MARKER = b"made by tfsat-host report"
"""Stands in the file's first record: how the command knows its own."""
NOTE = "Bodies and joints are as they were evaluated; positions are about the center of mass, which falls freely."
FILED, CORRECTED = "model_filed", "model_corrected"
MODELS = {"before": FILED, "after": CORRECTED}
"""The topics of the model as its file has it, and of the corrected one."""
BODY_COLORS = ((0.90, 0.62, 0.0), (0.34, 0.71, 0.91), (0.0, 0.62, 0.45), (0.80, 0.47, 0.65))
"""Okabe and Ito's, as on the page."""
_GHOST_ALPHA = 0.25

_MESSAGES = {
    "EulerAngles": "z_deg:double y_deg:double x_deg:double z_deg_std:double y_deg_std:double x_deg_std:double",
    "ModelAngles": "z_deg:double y_deg:double x_deg:double",
    "BodyRate": "rate_deg_s:vector",
    "EvaluatedJoint": "angle_deg:double angle_deg_std:double rate_deg_s:double",
    "Momentum": "momentum_g_m2_s:vector",
}
"""Fields are numbered in this order: append, never insert, so that older files keep their meaning."""


def write_evaluated_mcap(drop: ReportedDrop, path: Path) -> None:
    """Write the recording as `decode` does, with the quick look replaced by what the evaluation gives.

    Raises:
        MissingExtraError: the extra `mcap` is not installed.
    """

    def channels(make: Channels) -> list[Channel]:
        # What a failed check withholds is not written; the words say which check that is.
        evaluation, words = drop.evaluation, _words(drop, make)
        if not evaluation.is_given():
            return [words]
        topics = [*_evaluation_channels(evaluation, make), _scene(evaluation, make), words]
        fitted = f"/{CORRECTED}/"
        return [
            topic for topic in topics if evaluation.is_given("offsets") or not topic.topic.startswith(fitted)
        ]

    write_mcap(drop.evaluation.log, path, BodyFrames((), (), (NOTE,)), channels, MARKER)


def _evaluation_channels(evaluation: Evaluation, make: Channels) -> Iterator[Channel]:
    """Frames, attitudes, rates, joints, momenta and errors over time."""
    motion, explained = evaluation.motion, evaluation.explained
    kinds = {**kinds_of(_MESSAGES), "Frame": foxglove_kind("FrameTransform", FRAME_TRANSFORM)}

    def topic(name: str, kind: str, t_s: FloatArray, rows: FloatArray, **fixed: str) -> Channel:
        # Rows that are not finite are left out as a whole: Protobuf would show 0.
        finite = np.isfinite(rows).all(axis=1)
        return make.of_rows(name, kinds[kind], _t_us(evaluation, t_s[finite]), rows[finite], **fixed)

    moved, angles, kinematics = body_poses(evaluation), euler_angles(evaluation), explained.driven.flown
    # Two trees of frames under one world: the robot as it was measured, and the model as filed.
    for place, prefix, poses in (("evaluated", "", moved.measured), (FILED, f"{FILED}/", moved.predicted)):
        for body, frame in enumerate(map(frame_name, evaluation.model.body_names)):
            named = {"parent_frame_id": WORLD, "child_frame_id": f"{prefix}{frame}"}
            yield topic(f"/{place}/tf/{frame}", "Frame", moved.t_s, poses[:, body], **named)
    measured = np.rad2deg(np.hstack([angles.measured_rad, angles.std_rad]))
    yield topic("/evaluated/body_1/euler", "EulerAngles", angles.t_s, measured)
    for place, values in ((FILED, angles.before_rad), (CORRECTED, angles.after_rad)):
        yield topic(f"/{place}/body_1/euler", "ModelAngles", angles.t_s, np.rad2deg(values))
    for number, turned in enumerate(motion.bodies, 1):
        yield topic(f"/evaluated/body_{number}/rate", "BodyRate", turned.t_s, np.rad2deg(turned.rate_rad_s))
    for joint in motion.joints:
        rate = motion.fused.joint_rate_rad_s[:, joint.joint - 1]
        rows = np.rad2deg(np.column_stack([joint.angle_rad, joint.std_rad(), rate]))
        yield topic(f"/evaluated/joint_{joint.joint}", "EvaluatedJoint", motion.t_s, rows)
    for kind, model in models_of(evaluation):
        momentum = PER_KG_M2_S * inertial_momentum(model, kinematics)
        yield topic(f"/{MODELS[kind]}/momentum", "Momentum", kinematics.t_s, momentum)
    for kind, average in averages_of(evaluation):
        yield topic(
            f"/{MODELS[kind]}/momentum_averaged", "Momentum", average.t_s, PER_KG_M2_S * average.values
        )
    for place, side in ((FILED, explained.nominal), (CORRECTED, explained.fitted)):
        rows = np.rad2deg(np.hstack([side.error.euler_zyx_rad, side.error.std_rad]))
        yield topic(f"/{place}/body_1/attitude_error", "EulerAngles", side.error.t_s, rows)


def _t_us(evaluation: Evaluation, t_s: FloatArray) -> IntArray:
    """Convert times after the release to the logger's clock in whole microseconds, as they were recorded."""
    return np.asarray(np.rint(t_s * 1e6).astype(np.int64) + evaluation.log.origin_us)


def _scene(evaluation: Evaluation, make: Channels) -> Channel:
    """Build the channel with one scene message at the release: boxes on the bodies' frames.

    With them, a viewer shows more than axes.
    """
    from foxglove import messages

    release_us = int(_t_us(evaluation, np.zeros(1))[0])
    entities = []
    for prefix, alpha in (("", 1.0), (f"{FILED}/", _GHOST_ALPHA)):
        for body, name in enumerate(evaluation.model.body_names):
            frame = f"{prefix}{frame_name(name)}"
            color = messages.Color(
                **dict(zip("rgba", (*BODY_COLORS[body % len(BODY_COLORS)], alpha), strict=True))
            )
            cubes = [
                _box(np.array(low), np.array(high), color) for low, high in boxes_of(evaluation.model, body)
            ]
            # Locked to its frame, the box moves with it: one message draws the whole drop.
            entities.append(
                messages.SceneEntity(
                    timestamp=timestamp(release_us + make.offset_us),
                    frame_id=frame,
                    id=frame,
                    frame_locked=True,
                    cubes=cubes,
                )
            )
    update = messages.SceneUpdate(entities=entities)
    return make.of_messages("/evaluated/scene", foxglove_kind("SceneUpdate"), [(release_us, update.encode())])


def _box(low: FloatArray, high: FloatArray, color: Any) -> Any:
    from foxglove import messages

    def vector(numbers: FloatArray) -> Any:
        return messages.Vector3(**dict(zip("xyz", numbers.tolist(), strict=True)))

    pose = messages.Pose(
        position=vector(0.5 * (low + high)), orientation=messages.Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)
    )
    return messages.CubePrimitive(pose=pose, size=vector(high - low), color=color)


def _words(drop: ReportedDrop, make: Channels) -> Channel:
    """Build the log channel: the verdict at the release, then the events in order of time."""
    verdict = drop.verdict
    level = "Info" if verdict.level == "good" else "Warning"
    lines = [(0.0, level, text) for text in (f"{verdict.level}: {verdict.sentence}", *verdict.reasons)]
    for event in events_of(drop.evaluation):
        severity = "Warning" if event.kind == "gap" else "Info"
        lines.append((event.t_s, severity, event.label))
        if event.until_s is not None:
            lines.append((event.until_s, severity, f"{event.label}: ends"))
    # A stable sort: the verdict stays above the release, which is at the same time.
    lines.sort(key=lambda line: line[0])
    t_us = _t_us(drop.evaluation, np.array([t_s for t_s, _, _ in lines])).tolist()
    timed = ((at_us, severity, text) for at_us, (_, severity, text) in zip(t_us, lines, strict=True))
    return make.of_lines("/evaluated/log", timed, "tfsat evaluation")
