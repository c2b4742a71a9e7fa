"""The bodies' boxes on their frames, so that a viewer shows more than axes; and the verdict and events in words."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.body_frames import frame_name
from tfsat_host.report.contents.events import events_of
from tfsat_host.report.contents.replay import boxes_of
from tfsat_host.report.contents.reported import Reported
from tfsat_host.report.recording.channels import FILED, Topics
from tfsat_host.sdlog.export_mcap import Channel, Messages, Stamp

FloatArray = NDArray[np.float64]

BODY_COLORS = ((0.90, 0.62, 0.0), (0.34, 0.71, 0.91), (0.0, 0.62, 0.45), (0.80, 0.47, 0.65))
"""Okabe and Ito's, as on the page."""
_GHOST_ALPHA = 0.25


def scene_channel(drop: Reported, topics: Topics, stamp: Stamp) -> Channel:
    """One message at the release: boxes that move with the frames."""
    from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

    found = drop.evaluation

    def messages() -> Messages:
        release_us = topics.t_us(np.zeros(1))[0]
        update = SceneUpdate()
        for prefix, alpha in (("", 1.0), (f"{FILED}/", _GHOST_ALPHA)):
            for body, name in enumerate(found.model.body_names):
                frame = f"{prefix}{frame_name(name)}"
                entity = update.entities.add(frame_id=frame, id=frame, frame_locked=True)
                stamp(entity, release_us)
                for low, high in boxes_of(found.model, body):
                    _add_box(
                        entity, np.array(low), np.array(high), (*BODY_COLORS[body % len(BODY_COLORS)], alpha)
                    )
        yield release_us, update.SerializeToString()

    return Channel("/evaluated/scene", SceneUpdate, messages)


def _add_box(entity: Any, low: FloatArray, high: FloatArray, color: tuple[float, ...]) -> None:
    cube = entity.cubes.add()
    middle, size = 0.5 * (low + high), high - low
    cube.pose.position.x, cube.pose.position.y, cube.pose.position.z = middle.tolist()
    cube.pose.orientation.w = 1.0
    cube.size.x, cube.size.y, cube.size.z = size.tolist()
    cube.color.r, cube.color.g, cube.color.b, cube.color.a = color


def words_channel(drop: Reported, topics: Topics, stamp: Stamp) -> Channel:
    """The verdict at the release, then what happened as it was found."""
    from foxglove_schemas_protobuf.Log_pb2 import Log

    verdict = drop.verdict
    level = Log.INFO if verdict.level == "good" else Log.WARNING
    lines = [(0.0, level, text) for text in (f"{verdict.level}: {verdict.sentence}", *verdict.reasons)]
    for event in events_of(drop.evaluation):
        kind = Log.WARNING if event["kind"] == "gap" else Log.INFO
        lines.append((event["t_s"], kind, event["label"]))
        if event["until_s"] is not None:
            lines.append((event["until_s"], kind, f"{event['label']}: ends"))

    def messages() -> Messages:
        for t_s, severity, text in sorted(lines, key=lambda line: line[0]):
            t_us = topics.t_us(np.array([t_s]))[0]
            message = Log(level=severity, message=text, name="tfsat evaluation")
            stamp(message, t_us)
            yield t_us, message.SerializeToString()

    return Channel("/evaluated/log", Log, messages)
