"""MCAP: the recording for Foxglove, PlotJuggler and Rerun, with the bodies' frames.

Messages are Protobuf with Foxglove's schemas, because that is what all three read today without a plug-in:
Foxglove by its schemas' names, Rerun by its importer for the same ones (and by reflection for the rest), and
PlotJuggler by the descriptors in the file, of which it plots every number. JSON is unknown to Rerun, ROS
messages would call for ROS's definitions. Each body has a topic of its own with `foxglove.FrameTransform`
instead of one `FrameTransforms` for all: PlotJuggler names the entries of a list by their position, and
a body left out of one message would move the others to a wrong curve.

Times are Unix time if the logger knew it, else its clock since power-up (then viewers show 1970).
"""

from __future__ import annotations

import heapq
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import BoolArray, FloatArray, IntArray
from tfsat_host.protocol.limits import IMU_COUNT
from tfsat_host.quantity import record

from .droplog import SENSORS_PER_JOINT, CountColumn, DropLog, physical_columns
from .log_errors import check_extra
from .log_summary import METADATA, warnings

MCAP_MARKER = b"made by tfsat-host decode"
"""The library's name in the file's first record: how the command knows a file of its own."""
METADATA_NAME = "tfsat"
"""The metadata record that describes the recording: values are text, or JSON."""
QUICK_LOOK = "uncalibrated quick look: to see what happened, not to measure with"
_CHUNK_ROWS = 8192
_HARMLESS = {"switch_edge", "stroke", "release", "landing", "sensor_recovered", "card_back", "rewritten"}
"""Events of a drop as it should be; all others are warnings."""

_PACKAGE = "tfsat"

Stamp = Callable[[Any, int], None]
"""Writes a time of the logger's clock into a message's timestamp."""
Messages = Iterator[tuple[int, bytes]]
"""Time of the logger's clock in µs and an encoded message, by time."""
Rows = Iterator[tuple[int, Sequence[Any]]]
"""Time of the logger's clock in µs and the values of a message, all of them each time, by time."""

_MESSAGES = {
    "Imu": "rate_deg_s:vector specific_force_m_s2:vector temperature_c:double clipped:bool",
    "AngleSensor": "angle_deg:double",
    "JointAngle": "angle_deg:double",
    "ReleaseSwitches": "switch1_open:bool switch2_open:bool",
    "Event": "t_us:uint64 t_s:double event:string index:uint32 arg:uint32 value:int32",
}
"""Fields are numbered in this order: append, never insert, so that older files keep their meaning."""


@dataclass(frozen=True)
class Kind:
    """One kind of message.

    Attributes:
        of: Its Protobuf class.
        places: Where the values of a row go, in order: a field, or one of a message inside, such as `rate_deg_s.x`.
    """

    of: Any
    places: tuple[str, ...]


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

    @classmethod
    def of(
        cls, stamp: Stamp, topic: str, kind: Kind, rows: Callable[[], Rows], quality: str = "", **fixed: str
    ) -> Channel:
        """Build a channel with one message per row.

        Args:
            stamp: Writes a message's time.
            topic: The channel's name.
            kind: Kind of the messages.
            rows: Gives the rows.
            quality: What a reader should know of the numbers.
            fixed: Fields that are the same in all messages.
        """

        def messages() -> Messages:
            # Fill one message again and again; only the fields of `places` change between samples.
            message = kind.of(**fixed)
            # Resolve nested fields once, `vector.x` to (submessage, `x`), outside the loop over samples.
            paths = [place.rpartition(".") for place in kind.places]
            targets = [(getattr(message, part) if part else message, name) for part, _, name in paths]
            for t_us, row in rows():
                stamp(message, t_us)
                for (target, name), value in zip(targets, row, strict=True):
                    setattr(target, name, value)
                yield t_us, message.SerializeToString()

        return cls(topic, kind.of, messages, {"quality": quality} if quality else {})


def frame_transforms() -> Kind:
    """Return the message kind for one frame in another: translation and quaternion."""
    from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform

    return Kind(FrameTransform, (*places_in("translation"), *places_in("rotation", "xyzw")))


def log_lines() -> Kind:
    """Return the message kind for a line of text: level, text, who says it."""
    from foxglove_schemas_protobuf.Log_pb2 import Log

    return Kind(Log, ("level", "message", "name"))


def places_in(vector: str, axes: str = "xyz") -> tuple[str, ...]:
    """Return the field paths of a vector's components."""
    return tuple(f"{vector}.{axis}" for axis in axes)


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
    also: Callable[[Stamp], Sequence[Channel]] | None = None,
    marker: bytes = MCAP_MARKER,
) -> None:
    """Write all messages by time, and the recording's metadata; invalid readings are left out.

    Args:
        log: What was recorded.
        path: Where to.
        frames: From `tfsat_host.evaluation.quick.body_frames`.
        also: More channels, such as those of an evaluation, given what stamps their messages.
        marker: Of the command that makes the file.

    Raises:
        MissingExtraError: the extra `mcap` is not installed.
    """
    check_extra("mcap")
    from mcap.writer import Writer
    from mcap_protobuf.schema import register_schema

    offset_us = log.unix_offset_us or 0
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(library=marker.decode())
        schemas: dict[Any, int] = {}
        streams = []
        stamp = partial(_stamp, offset_us=offset_us)
        for channel in (*_channels(log, frames, stamp), *(also(stamp) if also else ())):
            kind = channel.message_class
            # Topics of one kind share a schema record.
            if kind not in schemas:
                schemas[kind] = register_schema(writer, kind)
            number = writer.register_channel(channel.topic, "protobuf", schemas[kind], channel.metadata)
            streams.append(_number_messages(number, channel.messages()))
        # Each stream is sorted by time already: merging holds one message a channel, not the recording.
        for t_us, number, data in heapq.merge(*streams, key=lambda message: message[0]):
            time_ns = (t_us + offset_us) * 1000
            writer.add_message(number, log_time=time_ns, publish_time=time_ns, data=data)
        writer.add_metadata(METADATA_NAME, _texts(log, frames, offset_us))
        writer.finish()  # type: ignore[no-untyped-call]


def _number_messages(number: int, messages: Iterator[tuple[int, bytes]]) -> Iterator[tuple[int, int, bytes]]:
    """Yield the messages of one channel together with the channel's number."""
    for t_us, data in messages:
        yield t_us, number, data


def _stamp(message: Any, t_us: int, offset_us: int) -> None:
    seconds, micro = divmod(t_us + offset_us, 1_000_000)
    message.timestamp.seconds = seconds
    message.timestamp.nanos = micro * 1000


def _texts(log: DropLog, frames: BodyFrames, offset_us: int) -> dict[str, str]:
    """Return the metadata as text; values that are not strings are written as JSON."""
    facts = record(METADATA, log) | {
        "clock": "unix" if offset_us else "since power-up",
        "quick_look": list(frames.notes),
    }
    return {name: value if isinstance(value, str) else json.dumps(value) for name, value in facts.items()}


def _channels(log: DropLog, frames: BodyFrames, stamp: Stamp) -> Iterator[Channel]:
    """Yield the channels of all topics of a recording.

    A reading that was not valid gives no message: Protobuf would show it as 0.
    """
    kinds, lines = kinds_of("tfsat/drop_log.proto", _MESSAGES), log_lines()
    columns, channel = physical_columns(log), partial(Channel.of, stamp)
    yield channel("/log", lines, partial(_log_lines, log, frames, lines.of))
    yield channel("/events", kinds["Event"], lambda: ((row[0], row) for row in log.event_rows()))
    # Switches have no validity bit: every sample has a message.
    rows = partial(_samples, log, np.ones(len(log), np.bool_), partial(_values, [], list(log.switch_open.T)))
    yield channel("/release_switches", kinds["ReleaseSwitches"], rows)
    for body in range(IMU_COUNT):
        own = [column for column in columns if column.name.startswith(f"imu{body + 1}_")]
        rows = partial(_samples, log, own[0].valid, partial(_values, own, [log.clipped[:, body]]))
        yield channel(f"/body_{body + 1}/imu", kinds["Imu"], rows)
    for index, column in enumerate(column for column in columns if column.name.startswith("joint")):
        joint, sensor = divmod(index, SENSORS_PER_JOINT)
        rows = partial(_samples, log, column.valid, partial(_values, [column], []))
        yield channel(f"/joint_{joint + 1}/sensor_{sensor + 1}", kinds["AngleSensor"], rows)
    # Quick-look topics have a prefix of their own: they rest on no calibration.
    for track in frames.joints:
        rows = partial(_track_rows, track.t_us, np.rad2deg(track.angle_rad)[:, None])
        yield channel(f"/quick_look/{track.name}", kinds["JointAngle"], rows, QUICK_LOOK)
    for frame in frames.tracks:
        rows = partial(_track_rows, frame.t_us, np.hstack((frame.translation_m, frame.quaternion_xyzw)))
        named = {"parent_frame_id": frame.parent, "child_frame_id": frame.child}
        yield channel(f"/quick_look/tf/{frame.child}", frame_transforms(), rows, QUICK_LOOK, **named)


def _samples(
    log: DropLog, valid: BoolArray, values: Callable[[NDArray[np.intp]], Iterable[NDArray[Any]]]
) -> Rows:
    """Yield a sensor's values at the samples at which it answered, some thousand samples at a time."""
    for start in range(0, len(log), _CHUNK_ROWS):
        # By chunks: `tolist` makes plain Python numbers for Protobuf, and memory stays bounded.
        rows = start + np.flatnonzero(valid[start : start + _CHUNK_ROWS])
        columns = (column.tolist() for column in values(rows))
        yield from zip(log.t_us[rows].tolist(), zip(*columns, strict=True), strict=True)


def _values(columns: list[CountColumn], flags: list[BoolArray], rows: NDArray[np.intp]) -> list[NDArray[Any]]:
    return [*(column.values(rows) for column in columns), *(flag[rows] for flag in flags)]


def _track_rows(t_us: IntArray, numbers: FloatArray) -> Rows:
    yield from zip(t_us.tolist(), numbers.tolist(), strict=True)


def _log_lines(log: DropLog, frames: BodyFrames, kind: Any) -> Rows:
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
        yield t_us, (level, text, "tfsat")


def kinds_of(file_name: str, messages: Mapping[str, str]) -> dict[str, Kind]:
    """Messages of the package `tfsat`, by name; each begins with a timestamp.

    Built from descriptors, so that no generated code must be kept in step.

    Args:
        file_name: The descriptors' own; each has its own set of messages.
        messages: The other fields of each, `name:type`, in the order of their numbers.
    """
    from foxglove_schemas_protobuf import Vector3_pb2
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory, timestamp_pb2

    # Fields that are messages of other packages; all the rest are scalars.
    inside = {"timestamp": ".google.protobuf.Timestamp", "vector": ".foxglove.Vector3"}
    file = descriptor_pb2.FileDescriptorProto(name=file_name, package=_PACKAGE, syntax="proto3")
    file.dependency.extend([timestamp_pb2.DESCRIPTOR.name, Vector3_pb2.DESCRIPTOR.name])
    places: dict[str, tuple[str, ...]] = {}
    for name, declared in messages.items():
        message = file.message_type.add(name=name)
        fields = [declaration.split(":") for declaration in declared.split()]
        # Number the fields by position, the timestamp first: the numbers are the wire format.
        for number, (field_name, kind) in enumerate([("timestamp", "timestamp"), *fields], 1):
            message.field.add(
                name=field_name,
                number=number,
                label=descriptor_pb2.FieldDescriptorProto.LABEL_OPTIONAL,
                type=f"TYPE_{'MESSAGE' if kind in inside else kind.upper()}",
                type_name=inside.get(kind),
            )
        place_groups = (
            places_in(member_name) if kind == "vector" else (member_name,) for member_name, kind in fields
        )
        places[name] = tuple(chain.from_iterable(place_groups))
    # The pool refuses another descriptor under a known file name, hence a name for each set of messages.
    pool = descriptor_pool.Default()
    pool.AddSerializedFile(file.SerializeToString())
    find = pool.FindMessageTypeByName
    return {
        name: Kind(message_factory.GetMessageClass(find(f"{_PACKAGE}.{name}")), places[name])
        for name in messages
    }
