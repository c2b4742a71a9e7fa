"""The messages of the MCAP file that Foxglove has no schema for, as Protobuf classes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_PACKAGE = "tfsat"
_TIMESTAMP = ".google.protobuf.Timestamp"
_VECTOR = ".foxglove.Vector3"

Fields = tuple[tuple[str, str], ...]
"""Name and type of each field; a type with a leading dot is a message."""

_MESSAGES: dict[str, Fields] = {
    "Imu": (
        ("timestamp", _TIMESTAMP),
        ("rate_deg_s", _VECTOR),
        ("specific_force_m_s2", _VECTOR),
        ("temperature_c", "double"),
        ("clipped", "bool"),
    ),
    "AngleSensor": (("timestamp", _TIMESTAMP), ("angle_deg", "double")),
    "JointAngle": (("timestamp", _TIMESTAMP), ("angle_deg", "double")),
    "ReleaseSwitches": (("timestamp", _TIMESTAMP), ("switch1_open", "bool"), ("switch2_open", "bool")),
    "Event": (
        ("timestamp", _TIMESTAMP),
        ("t_us", "uint64"),
        ("t_s", "double"),
        ("event", "string"),
        ("index", "uint32"),
        ("arg", "uint32"),
        ("value", "int32"),
    ),
}
"""Fields are numbered in this order: append, never insert, so that older files keep their meaning."""


def message_classes() -> dict[str, Any]:
    """Name, such as `Imu`, to class."""
    return classes_of("tfsat/drop_log.proto", _MESSAGES)


def classes_of(file_name: str, messages: Mapping[str, Fields]) -> dict[str, Any]:
    """Messages of the package `tfsat` as classes, by name.

    Built from descriptors, so that no generated code must be kept in step.

    Args:
        file_name: The descriptors' own; each has its own set of messages.
        messages: Fields of each by its name, in the order of their numbers.
    """
    from foxglove_schemas_protobuf import Vector3_pb2
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory, timestamp_pb2

    file = descriptor_pb2.FileDescriptorProto(name=file_name, package=_PACKAGE, syntax="proto3")
    file.dependency.extend([timestamp_pb2.DESCRIPTOR.name, Vector3_pb2.DESCRIPTOR.name])
    for name, fields in messages.items():
        message = file.message_type.add(name=name)
        for number, (field, kind) in enumerate(fields, 1):
            added = message.field.add(
                name=field, number=number, label=descriptor_pb2.FieldDescriptorProto.LABEL_OPTIONAL
            )
            if kind.startswith("."):
                added.type, added.type_name = descriptor_pb2.FieldDescriptorProto.TYPE_MESSAGE, kind
            else:
                added.type = descriptor_pb2.FieldDescriptorProto.Type.Value(f"TYPE_{kind.upper()}")
    pool = descriptor_pool.Default()
    pool.AddSerializedFile(file.SerializeToString())
    return {
        name: message_factory.GetMessageClass(pool.FindMessageTypeByName(f"{_PACKAGE}.{name}"))
        for name in messages
    }
