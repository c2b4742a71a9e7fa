"""What goes into the MCAP file: topics, and their messages by time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT

from .columns import CountColumn, physical_columns
from .droplog import DropLog
from .frames import BodyFrames, FrameTrack, JointTrack
from .mcap_schemas import message_classes
from .summary import warnings

QUICK_LOOK = "uncalibrated quick look: to see what happened, not to measure with"
_CHUNK_ROWS = 8192
_AXES = "xyz"
_HARMLESS = {
    "switch_edge",
    "stroke",
    "release",
    "landing",
    "sensor_recovered",
    "card_back",
    "rewritten",
}
"""Events of a drop as it should be; all others are warnings."""

Stamp = Callable[[Any, int], None]
"""Writes a time of the logger's clock into a message's timestamp."""
Messages = Iterator[tuple[int, bytes]]
"""Time of the logger's clock in µs and an encoded message, by time."""


@dataclass(frozen=True)
class Channel:
    """One topic.

    Attributes:
        topic: Its name.
        message_class: Protobuf class of its messages.
        messages: Makes them.
        metadata: What a reader should know of the topic.
    """

    topic: str
    message_class: Any
    messages: Callable[[], Messages]
    metadata: dict[str, str] = field(default_factory=dict)


def channels(log: DropLog, frames: BodyFrames, stamp: Stamp) -> list[Channel]:
    """All topics of a recording. A reading that was not valid is no message: Protobuf would show it as 0."""
    from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
    from foxglove_schemas_protobuf.Log_pb2 import Log

    classes = message_classes()
    columns = {column.name: column for column in physical_columns(log)}
    made = [
        Channel("/log", Log, lambda: _log_messages(log, frames, Log, stamp)),
        Channel("/events", classes["Event"], lambda: _events(log, classes["Event"], stamp)),
        Channel(
            "/release_switches",
            classes["ReleaseSwitches"],
            lambda: _switches(log, classes["ReleaseSwitches"], stamp),
        ),
    ]
    quality = {"quality": QUICK_LOOK}
    return [
        *made,
        *(_imu_channel(log, columns, body, classes["Imu"], stamp) for body in range(1, IMU_COUNT + 1)),
        *(
            _angle_channel(log, columns, joint, sensor, classes["AngleSensor"], stamp)
            for joint in range(1, JOINT_COUNT + 1)
            for sensor in (1, 2)
        ),
        *(_joint_channel(track, classes["JointAngle"], stamp, quality) for track in frames.joints),
        *(_frame_channel(track, FrameTransform, stamp, quality) for track in frames.tracks),
    ]


def _imu_channel(
    log: DropLog, columns: dict[str, CountColumn], body: int, kind: Any, stamp: Stamp
) -> Channel:
    rates = [columns[f"imu{body}_rate_{axis}_deg_s"] for axis in _AXES]
    forces = [columns[f"imu{body}_specific_force_{axis}_m_s2"] for axis in _AXES]
    ordered = [*rates, *forces, columns[f"imu{body}_temperature_c"]]

    def messages() -> Messages:
        message = kind()
        rate, force = message.rate_deg_s, message.specific_force_m_s2
        for rows, times in _valid_rows(log, ordered[0]):
            values = np.stack([_values(column, rows) for column in ordered], axis=1).tolist()
            clipped = log.clipped[rows, body - 1].tolist()
            for t_us, row, at_limit in zip(times, values, clipped, strict=True):
                stamp(message, t_us)
                rate.x, rate.y, rate.z, force.x, force.y, force.z, message.temperature_c = row
                message.clipped = at_limit
                yield t_us, message.SerializeToString()

    return Channel(f"/body_{body}/imu", kind, messages)


def _angle_channel(
    log: DropLog, columns: dict[str, CountColumn], joint: int, sensor: int, kind: Any, stamp: Stamp
) -> Channel:
    column = columns[f"joint{joint}_sensor{sensor}_angle_deg"]

    def messages() -> Messages:
        for rows, times in _valid_rows(log, column):
            yield from _angles(kind(), times, _values(column, rows).tolist(), stamp)

    return Channel(f"/joint_{joint}/sensor_{sensor}", kind, messages)


def _joint_channel(track: JointTrack, kind: Any, stamp: Stamp, quality: dict[str, str]) -> Channel:
    def messages() -> Messages:
        return _angles(kind(), track.t_us.tolist(), np.rad2deg(track.angle_rad).tolist(), stamp)

    return Channel(f"/quick_look/{track.name}", kind, messages, quality)


def _frame_channel(track: FrameTrack, kind: Any, stamp: Stamp, quality: dict[str, str]) -> Channel:
    def messages() -> Messages:
        message = kind(parent_frame_id=track.parent, child_frame_id=track.child)
        place, turn = message.translation, message.rotation
        numbers = np.hstack((track.translation_m, track.quaternion_xyzw)).tolist()
        for t_us, row in zip(track.t_us.tolist(), numbers, strict=True):
            stamp(message, t_us)
            place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w = row
            yield t_us, message.SerializeToString()

    return Channel(f"/quick_look/tf/{track.child}", kind, messages, quality)


def _switches(log: DropLog, kind: Any, stamp: Stamp) -> Messages:
    message = kind()
    for start in range(0, len(log), _CHUNK_ROWS):
        rows = slice(start, start + _CHUNK_ROWS)
        for t_us, is_open in zip(log.t_us[rows].tolist(), log.switch_open[rows].tolist(), strict=True):
            stamp(message, t_us)
            message.switch1_open, message.switch2_open = is_open
            yield t_us, message.SerializeToString()


def _events(log: DropLog, kind: Any, stamp: Stamp) -> Messages:
    for event in log.events:
        message = kind(
            t_us=event.t_us,
            t_s=log.seconds(event.t_us),
            event=event.name,
            index=event.index,
            arg=event.arg,
            value=event.value,
        )
        stamp(message, event.t_us)
        yield event.t_us, message.SerializeToString()


def _log_messages(log: DropLog, frames: BodyFrames, kind: Any, stamp: Stamp) -> Messages:
    """First what to know of the recording, then every event in words."""
    start_us = int(log.t_us[0])
    lines = [(start_us, kind.WARNING, text.strip()) for text in (*warnings(log), *frames.notes)]
    for event in log.events:
        level = kind.INFO if event.name in _HARMLESS else kind.WARNING
        words = f"{event.name} index={event.index} arg={event.arg} value={event.value}"
        lines.append((event.t_us, level, words))
    if log.release_us is not None:
        lines.append((log.release_us, kind.INFO, f"t = 0: {log.t_s_origin}"))
    for t_us, level, text in sorted(lines, key=lambda line: line[0]):
        message = kind(level=level, message=text, name="tfsat")
        stamp(message, t_us)
        yield t_us, message.SerializeToString()


def _angles(message: Any, times: list[int], angles_deg: list[float], stamp: Stamp) -> Messages:
    for t_us, angle in zip(times, angles_deg, strict=True):
        stamp(message, t_us)
        message.angle_deg = angle
        yield t_us, message.SerializeToString()


def _valid_rows(log: DropLog, column: CountColumn) -> Iterator[tuple[Any, list[int]]]:
    """Row numbers at which the column's sensor answered, and their times, some thousand at once."""
    for start in range(0, len(log), _CHUNK_ROWS):
        rows = start + np.flatnonzero(column.valid[start : start + _CHUNK_ROWS])
        yield rows, log.t_us[rows].tolist()


def _values(column: CountColumn, rows: Any) -> Any:
    return column.counts[rows] * np.float64(column.scale) + column.offset
