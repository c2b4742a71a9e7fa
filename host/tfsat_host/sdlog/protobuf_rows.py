"""Protobuf messages as the rows of one array: all of a topic have the same length, so numpy encodes thousands at once.

Every field is written, also where it is zero, and the two numbers of a timestamp always take five bytes: a varint may
end with zeros that carry nothing (https://protobuf.dev/programming-guides/encoding/#varints).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Final, Self

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import IntArray

_VARINT, _DOUBLE, _BYTES = 0, 1, 2
"""Wire types."""
_COMPONENTS: Final = {"vector": 3, "quaternion": 4}
_VARINT_BYTES = 5
FRAME_TRANSFORM: Final = "parent_frame_id:text child_frame_id:text translation:vector rotation:quaternion"
"""Fields of `foxglove.FrameTransform` after its timestamp, in the order of their numbers."""


@dataclass(frozen=True)
class Kind:
    """One kind of message.

    Attributes:
        name: With its package.
        schema: Its file of descriptors and those that it depends on, encoded.
        fields: The fields after the timestamp, `name:type` each, in the order of their numbers.
    """

    name: str
    schema: bytes
    fields: str


@cache
def foxglove_kind(name: str, fields: str = "") -> Kind:
    """Return a kind of Foxglove's own messages."""
    from foxglove import messages

    return Kind(f"foxglove.{name}", getattr(messages, name).get_schema().data, fields)


def kinds_of(messages: Mapping[str, str]) -> dict[str, Kind]:
    """Messages of the package `tfsat`, by name; each begins with a timestamp.

    Built from descriptors, so that no generated code must be kept in step. `messages` has the other fields of
    each, `name:type`, in the order of their numbers.
    """
    from google.protobuf import descriptor_pb2

    inside = {"timestamp": ".google.protobuf.Timestamp", "vector": ".foxglove.Vector3"}
    known = descriptor_pb2.FileDescriptorSet.FromString(foxglove_kind("FrameTransform").schema)
    # What our fields are made of; a descriptor set must hold all that its files depend on.
    needed = [file for file in known.file if file.name.endswith(("/timestamp.proto", "/Vector3.proto"))]
    file = descriptor_pb2.FileDescriptorProto(name="tfsat/messages.proto", package="tfsat", syntax="proto3")
    file.dependency.extend(entry.name for entry in needed)
    for name, declared in messages.items():
        message = file.message_type.add(name=name)
        # Number the fields by position, the timestamp first: the numbers are the wire format.
        for number, (field_name, kind) in enumerate([("timestamp", "timestamp"), *_split(declared)], 1):
            message.field.add(
                name=field_name,
                number=number,
                label=descriptor_pb2.FieldDescriptorProto.LABEL_OPTIONAL,
                type=f"TYPE_{'MESSAGE' if kind in inside else kind.upper()}",
                type_name=inside.get(kind),
            )
    schema = descriptor_pb2.FileDescriptorSet(file=[*needed, file]).SerializeToString(deterministic=True)
    return {name: Kind(f"tfsat.{name}", schema, declared) for name, declared in messages.items()}


def _split(declared: str) -> list[tuple[str, str]]:
    return [(name, kind) for name, _, kind in (entry.partition(":") for entry in declared.split())]


@dataclass(frozen=True, eq=False)
class RowEncoder:
    """Encodes messages of one kind.

    Attributes:
        template: (length,) uint8, a message whose times and numbers are zero.
        places: Where each number or truth value begins, and whether it is a truth value, in the order of the fields.
    """

    template: NDArray[np.uint8]
    places: tuple[tuple[int, bool], ...]

    @classmethod
    def of(cls, kind: Kind, fixed: Mapping[str, str]) -> Self:
        """Build the encoder of a kind; `fixed` are the texts of its fields."""
        message = bytearray(_timestamp_template())
        places: list[tuple[int, bool]] = []
        for number, (name, field_kind) in enumerate(_split(kind.fields), 2):
            if field_kind == "text":
                text = fixed[name].encode()
                message += bytes((number << 3 | _BYTES, *_varint(len(text)))) + text
            elif field_kind == "bool":
                places.append((len(message) + 1, True))
                message += bytes((number << 3 | _VARINT, 0))
            else:
                count = _COMPONENTS.get(field_kind, 0)
                # A vector is a message of its own: its length, then its components.
                message += bytes((number << 3 | _BYTES, 9 * count)) if count else b""
                for component in range(1, count + 1) if count else (number,):
                    places.append((len(message) + 1, False))
                    message += bytes((component << 3 | _DOUBLE, *(0,) * 8))
        return cls(np.frombuffer(bytes(message), np.uint8), tuple(places))

    def encode(self, t_us: IntArray, columns: Sequence[NDArray[Any]]) -> list[bytes]:
        """Encode n messages with times (n,) and a column (n,) for each number or truth value."""
        rows = np.tile(self.template, (len(t_us), 1))
        seconds, micro = np.divmod(t_us, 1_000_000)
        _put_varint(rows[:, 3 : 3 + _VARINT_BYTES], seconds)
        _put_varint(rows[:, 9 : 9 + _VARINT_BYTES], micro * 1000)
        for (begin, is_flag), column in zip(self.places, columns, strict=True):
            if is_flag:
                rows[:, begin] = column
            else:
                rows[:, begin : begin + 8] = column.astype("<f8").reshape(-1, 1).view(np.uint8)
        data, length = rows.tobytes(), rows.shape[1]
        return [data[begin : begin + length] for begin in range(0, len(data), length)]


def _timestamp_template() -> bytes:
    """Return field 1, a timestamp of zero: seconds and nanoseconds of `_VARINT_BYTES` each."""
    zero = bytes(_VARINT_BYTES)
    inner = bytes((1 << 3 | _VARINT,)) + zero + bytes((2 << 3 | _VARINT,)) + zero
    return bytes((1 << 3 | _BYTES, len(inner))) + inner


def _varint(number: int) -> Iterator[int]:
    while number > 0x7F:
        yield number & 0x7F | 0x80
        number >>= 7
    yield number


def _put_varint(place: NDArray[np.uint8], numbers: IntArray) -> None:
    """Write numbers (n,) from 0 below 2^35 into (n, 5) bytes, seven bits each, the lowest first."""
    for index in range(_VARINT_BYTES):
        more = 0x80 if index + 1 < _VARINT_BYTES else 0
        place[:, index] = numbers >> 7 * index & 0x7F | more


def encode_event(t_us: int, kind: Kind, values: Sequence[Any]) -> bytes:
    """Encode one message with numbers and texts of any length, such as an event."""
    message = message_class(kind)()
    message.timestamp.seconds, micro = divmod(t_us, 1_000_000)
    message.timestamp.nanos = micro * 1000
    for (name, _), value in zip(_split(kind.fields), values, strict=True):
        setattr(message, name, value)
    return bytes(message.SerializeToString())


@cache
def message_class(kind: Kind) -> Any:
    """Return protobuf's own class of these messages."""
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

    # A pool of its own: the process's may know a file of that name with other contents.
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(kind.schema).file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(kind.name))


def encode_line(t_us: int, level: str, text: str, name: str) -> bytes:
    """Encode a `foxglove.Log`: `Info` or `Warning`, the text, who says it."""
    from foxglove import messages

    line = messages.Log(
        timestamp=timestamp(t_us), level=getattr(messages.LogLevel, level), message=text, name=name
    )
    return bytes(line.encode())


def timestamp(t_us: int) -> Any:
    """Return Foxglove's timestamp of a time in µs."""
    from foxglove import messages

    seconds, micro = divmod(t_us, 1_000_000)
    return messages.Timestamp(seconds, micro * 1000)
