"""MCAP: the recording for Foxglove, PlotJuggler and Rerun, with the bodies' frames.

Messages are Protobuf with Foxglove's schemas, because that is what all three read today without a plug-in:
Foxglove by its schemas' names, Rerun by its importer for the same ones (and by reflection for the rest), and
PlotJuggler by the descriptors in the file, of which it plots every number. JSON is unknown to Rerun, ROS
messages would call for ROS's definitions. Each body has a topic of its own with `foxglove.FrameTransform`
instead of one `FrameTransforms` for all: PlotJuggler names the entries of a list by their position, and
a body left out of one message would move the others to a wrong curve.

Foxglove's own library writes the file. The messages of a topic have one length, so that thousands of them are encoded
as the rows of one array (`protobuf_rows.py`).

Times are Unix time if the logger knew it, else its clock since power-up (then viewers show 1970).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tfsat_host.arrays import BoolArray, FloatArray, IntArray
from tfsat_host.protocol.limits import ANGLE_SENSOR_COUNT, IMU_COUNT
from tfsat_host.quantity import record

from .droplog import CountColumn, DropLog, physical_columns
from .log_errors import check_extra
from .log_summary import METADATA, warnings
from .protobuf_rows import (
    FRAME_TRANSFORM,
    Kind,
    RowEncoder,
    encode_event,
    encode_line,
    foxglove_kind,
    kinds_of,
)

MCAP_MARKER = b"made by tfsat-host decode"
"""The profile in the file's first record: how the command knows a file of its own."""
METADATA_NAME = "tfsat"
"""The metadata record that describes the recording: values are text, or JSON."""
QUICK_LOOK = "uncalibrated quick look: to see what happened, not to measure with"
_WINDOW_US = 8_000_000
"""So much of the recording is encoded, sorted and written at a time."""
_HARMLESS = {"switch_edge", "stroke", "release", "landing", "sensor_recovered", "card_back", "rewritten"}
"""Events of a drop as it should be; all others are warnings."""

Encode = Callable[[slice], list[bytes]]
"""Given which of a topic's messages, by number: each encoded."""

_MESSAGES = {
    "Imu": "rate_deg_s:vector specific_force_m_s2:vector temperature_c:double clipped:bool",
    "AngleSensors": "joint1_sensor1_deg:double joint1_sensor2_deg:double joint2_sensor1_deg:double "
    "joint2_sensor2_deg:double joint3_sensor1_deg:double joint3_sensor2_deg:double",
    "JointAngle": "angle_deg:double",
    "ReleaseSwitches": "switch1_open:bool switch2_open:bool",
    "Event": "t_us:uint64 t_s:double event:string index:uint32 arg:uint32 value:int32",
}
"""Fields are numbered in this order: append, never insert, so that older files keep their meaning."""


@dataclass(frozen=True, eq=False)
class Channel:
    """One topic.

    Attributes:
        topic: Its name.
        kind: Of its messages.
        t_us: (n,) int64, the logger's clock at each message, increasing.
        encode: Encodes messages.
        metadata: What a reader should know of the topic.
    """

    topic: str
    kind: Kind
    t_us: IntArray
    encode: Encode
    metadata: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Channels:
    """Makes channels whose messages carry the recording's times.

    Attributes:
        offset_us: Of Unix time against the logger's clock; 0 if it is unknown.
    """

    offset_us: int

    def of_rows(
        self, topic: str, kind: Kind, t_us: IntArray, rows: FloatArray, quality: str = "", **fixed: str
    ) -> Channel:
        """Build a channel with one message per row of numbers (n, k), those of the kind's fields in order.

        Args:
            topic: Its name.
            kind: Of the messages.
            t_us: (n,) the logger's clock.
            rows: (n, k).
            quality: What a reader should know of the numbers.
            fixed: Texts that are the same in all messages.
        """
        encoder = RowEncoder.of(kind, fixed)

        def encode(chosen: slice) -> list[bytes]:
            return encoder.encode(t_us[chosen] + self.offset_us, list(rows[chosen].T))

        return Channel(topic, kind, t_us, encode, {"quality": quality} if quality else {})

    def of_samples(
        self,
        topic: str,
        kind: Kind,
        log: DropLog,
        valid: BoolArray,
        columns: Sequence[CountColumn | BoolArray],
    ) -> Channel:
        """Build a channel with one message for each sample that is `valid`; what a sensor did not give is NaN."""
        encoder, samples = RowEncoder.of(kind, {}), np.flatnonzero(valid)
        t_us = log.t_us[samples]

        def encode(chosen: slice) -> list[bytes]:
            rows = samples[chosen]
            values = [
                np.where(column.valid[rows], column.values(rows), np.nan)
                if isinstance(column, CountColumn)
                else column[rows]
                for column in columns
            ]
            return encoder.encode(t_us[chosen] + self.offset_us, values)

        return Channel(topic, kind, t_us, encode)

    def of_messages(self, topic: str, kind: Kind, messages: Iterable[tuple[int, bytes]]) -> Channel:
        """Build a channel of a few messages that are encoded already, by time."""
        listed = list(messages)
        t_us = np.array([at_us for at_us, _ in listed], dtype=np.int64)
        return Channel(topic, kind, t_us, lambda chosen: [data for _, data in listed[chosen]])

    def of_lines(self, topic: str, lines: Iterable[tuple[int, str, str]], name: str) -> Channel:
        """Build a channel of lines of text: time, `Info` or `Warning`, text; `name` says who says it."""
        encoded = (
            (at_us, encode_line(at_us + self.offset_us, level, text, name)) for at_us, level, text in lines
        )
        return self.of_messages(topic, foxglove_kind("Log"), encoded)


@dataclass(frozen=True, eq=False)
class FrameTrack:
    """One frame in another, at m moments.

    Attributes:
        parent: Name of the frame that it is given in.
        child: Its own name.
        t_us: (m,) int64, the logger's clock, increasing.
        translation_m: (m, 3) the child's origin in the parent.
        quaternion_xyzw: (m, 4) unit quaternions that turn the child's axes into the parent's.
    """

    parent: str
    child: str
    t_us: IntArray
    translation_m: FloatArray
    quaternion_xyzw: FloatArray


@dataclass(frozen=True, eq=False)
class JointTrack:
    """One joint's angle: `t_us` (m,) int64, the logger's clock; `angle_rad` (m,)."""

    name: str
    t_us: IntArray
    angle_rad: FloatArray


@dataclass(frozen=True, eq=False)
class BodyFrames:
    """A tree of frames.

    Attributes:
        tracks: One a body, parents before children; none where a body's place is unknown.
        joints: One a joint that could be read.
        notes: Sentences: what this rests on, what is missing and why.
    """

    tracks: tuple[FrameTrack, ...]
    joints: tuple[JointTrack, ...]
    notes: tuple[str, ...]


def write_mcap(
    log: DropLog,
    path: Path,
    frames: BodyFrames,
    also: Callable[[Channels], Sequence[Channel]] | None = None,
    marker: bytes = MCAP_MARKER,
) -> None:
    """Write all messages by time, and the recording's metadata; invalid readings are left out.

    Args:
        log: What was recorded.
        path: Where to.
        frames: From `tfsat_host.evaluation.quick.body_frames`.
        also: More channels, such as those of an evaluation.
        marker: Of the command that makes the file.

    Raises:
        MissingExtraError: the extra `mcap` is not installed.
    """
    check_extra("mcap")
    import foxglove

    offset_us = log.unix_offset_us or 0
    make = Channels(offset_us)
    channels = [*_channels(log, frames, make), *(also(make) if also else ())]
    # A context of its own: other channels of this process are not to get into the file.
    context = foxglove.Context()
    # One thread: the same log gives the same file.
    options = foxglove.mcap.MCAPWriteOptions(profile=marker.decode(), compression_threads=0)
    with (
        path.open("wb") as file,
        foxglove.open_mcap(file, context=context, writer_options=options) as writer,
    ):
        _write_messages(channels, context, offset_us)
        writer.write_metadata(METADATA_NAME, _texts(log, frames, offset_us))


def _write_messages(channels: Sequence[Channel], context: Any, offset_us: int) -> None:
    """Write all messages by time, some seconds of the recording at a time."""

    # A sensor without a single reading has no topic.
    filled = [channel for channel in channels if len(channel.t_us)]
    topics = [_open_topic(channel, context) for channel in filled]
    first_us = min(int(channel.t_us[0]) for channel in filled)
    last_us = max(int(channel.t_us[-1]) for channel in filled)
    for begin_us in range(first_us, last_us + 1, _WINDOW_US):
        times, data, writes = [np.zeros(0, np.int64)], [], []
        for channel, topic in zip(filled, topics, strict=True):
            span = slice(*np.searchsorted(channel.t_us, (begin_us, begin_us + _WINDOW_US)).tolist())
            times.append(channel.t_us[span])
            data += channel.encode(span)
            writes += [topic.base.log] * (span.stop - span.start)
        t_us = np.concatenate(times)
        # Stable: what is of the same time stays in the order of the channels.
        order = np.argsort(t_us, kind="stable")
        times_ns = ((t_us[order] + offset_us) * 1000).tolist()
        for index, time_ns in zip(order.tolist(), times_ns, strict=True):
            writes[index](data[index], time_ns)


def _open_topic(channel: Channel, context: Any) -> Any:
    import foxglove

    schema = foxglove.Schema(name=channel.kind.name, encoding="protobuf", data=channel.kind.schema)
    return foxglove.Channel(
        channel.topic, schema=schema, message_encoding="protobuf", context=context, metadata=channel.metadata
    )


def _texts(log: DropLog, frames: BodyFrames, offset_us: int) -> dict[str, str]:
    """Return the metadata as text; values that are not strings are written as JSON."""
    facts = record(METADATA, log) | {
        "clock": "unix" if offset_us else "since power-up",
        "quick_look": list(frames.notes),
    }
    return {name: value if isinstance(value, str) else json.dumps(value) for name, value in facts.items()}


def _channels(log: DropLog, frames: BodyFrames, make: Channels) -> Iterator[Channel]:
    """Yield the channels of all topics of a recording.

    A reading that was not valid gives no message, or NaN beside one that was: Protobuf would show it as 0.
    """
    kinds, columns = kinds_of(_MESSAGES), physical_columns(log)
    event = kinds["Event"]
    yield make.of_lines("/log", _log_lines(log, frames), "tfsat")
    rows = ((row[0], encode_event(row[0] + make.offset_us, event, row)) for row in log.event_rows())
    yield make.of_messages("/events", event, rows)
    yield make.of_samples(
        "/release_switches", kinds["ReleaseSwitches"], log, _switch_samples(log), list(log.switch_open.T)
    )
    for body in range(IMU_COUNT):
        own = [column for column in columns if column.name.startswith(f"imu{body + 1}_")]
        of_body: list[CountColumn | BoolArray] = [*own, log.clipped[:, body]]
        yield make.of_samples(f"/body_{body + 1}/imu", kinds["Imu"], log, own[0].valid, of_body)
    # All in one message: a recording of ten minutes has 840,000 fewer.
    answered = np.any(log.angle_valid, axis=1)
    yield make.of_samples(
        "/angle_sensors", kinds["AngleSensors"], log, answered, columns[-ANGLE_SENSOR_COUNT:]
    )
    # Quick-look topics have a prefix of their own: they rest on no calibration.
    for track in frames.joints:
        angles_deg = np.rad2deg(track.angle_rad)[:, None]
        yield make.of_rows(
            f"/quick_look/{track.name}", kinds["JointAngle"], track.t_us, angles_deg, QUICK_LOOK
        )
    transform = foxglove_kind("FrameTransform", FRAME_TRANSFORM)
    for frame in frames.tracks:
        poses = np.hstack((frame.translation_m, frame.quaternion_xyzw))
        named = {"parent_frame_id": frame.parent, "child_frame_id": frame.child}
        yield make.of_rows(f"/quick_look/tf/{frame.child}", transform, frame.t_us, poses, QUICK_LOOK, **named)


_SWITCHES_EVERY_S = 0.1


def _switch_samples(log: DropLog) -> BoolArray:
    """(n,) the samples on both sides of each change of a switch, and some in between: they hold for seconds."""
    chosen = np.zeros(len(log), np.bool_)
    chosen[:: max(1, round(_SWITCHES_EVERY_S * log.header.rate_hz))] = chosen[-1:] = True
    changed = (log.switch_open[1:] != log.switch_open[:-1]).any(axis=1)
    chosen[1:] |= changed
    chosen[:-1] |= changed
    return chosen


def _log_lines(log: DropLog, frames: BodyFrames) -> list[tuple[int, str, str]]:
    """First what to know of the recording, then every event in words."""
    start_us = int(log.t_us[0])
    lines = [(start_us, "Warning", text.strip()) for text in (*warnings(log), *frames.notes)]
    for event in log.events:
        level = "Info" if event.name in _HARMLESS else "Warning"
        words = f"{event.name} index={event.index} arg={event.arg} value={event.value}"
        lines.append((event.t_us, level, words))
    if log.release_us is not None:
        lines.append((log.release_us, "Info", f"t = 0: {log.t_s_origin}"))
    return sorted(lines, key=lambda line: line[0])
