"""Reading and checking protocol/tfsat.toml."""

from __future__ import annotations

import hashlib
import json
import keyword
import re
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

SCALARS = {  # name: (bytes, struct letter, numpy code, C++ type)
    "u8": (1, "B", "u1", "uint8_t"),
    "u16": (2, "H", "<u2", "uint16_t"),
    "u32": (4, "I", "<u4", "uint32_t"),
    "u64": (8, "Q", "<u8", "uint64_t"),
    "i16": (2, "h", "<i2", "int16_t"),
    "i32": (4, "i", "<i4", "int32_t"),
    "f32": (4, "f", "<f4", "float"),
}


class SpecError(ValueError):
    """The specification contradicts itself."""


@dataclass(frozen=True)
class Field:
    """One field: `kind` is a scalar's, an enum's or a struct's name; `count` is None for a single one."""

    name: str
    kind: str
    count: int | None
    doc: str
    unit: str = ""  # of one count, where the name does not say it


@dataclass(frozen=True)
class Struct:
    """A record of fields, in wire order. `type_id` is set where it is the payload of a frame."""

    name: str
    doc: str
    fields: tuple[Field, ...]
    type_id: int | None = None


@dataclass(frozen=True)
class EnumValue:
    """One name of an enumeration; errors also have a meaning and a remedy."""

    name: str
    value: int
    doc: str
    meaning: str = ""
    remedy: str = ""


@dataclass(frozen=True)
class Enum:
    """An enumeration, one byte on the wire."""

    name: str
    doc: str
    values: tuple[EnumValue, ...]


@dataclass(frozen=True)
class Limit:
    """A number that both sides know."""

    name: str
    value: int
    doc: str


@dataclass(frozen=True)
class Imu:
    """A part that may be an IMU; delays of its low-passes by DLPF_CFG. `doc` is where the figures are from."""

    name: str
    who_am_i: int
    temperature_lsb_per_c: float
    temperature_offset_c: float
    has_accel_filter: bool
    gyro_delay_us: list[int]
    accel_delay_us: list[int]
    doc: str


@dataclass(frozen=True)
class Message:
    """A request with its reply, or a stream."""

    name: str
    id: int
    boards: tuple[str, ...]
    doc: str
    idempotent: str
    request: Struct | None
    reply: Struct | None
    stream: Struct | None

    @property
    def payloads(self) -> tuple[Struct, ...]:
        """The parts that it has."""
        return tuple(part for part in (self.request, self.reply, self.stream) if part is not None)


@dataclass(frozen=True)
class Spec:
    """The whole specification, checked."""

    hash: bytes
    firmware_version: tuple[int, int, int]
    link: dict[str, Any]
    release_doc: str
    limits: tuple[Limit, ...]
    enums: dict[str, Enum]
    structs: dict[str, Struct]
    imus: tuple[Imu, ...]
    messages: tuple[Message, ...]

    def limit(self, name: str) -> int:
        return next(limit.value for limit in self.limits if limit.name == name)

    def size_of(self, item: Struct | Field) -> int:
        """Bytes on the wire."""
        if isinstance(item, Struct):
            return sum(self.size_of(field) for field in item.fields)
        count = 1 if item.count is None else item.count
        if item.kind in SCALARS:
            return SCALARS[item.kind][0] * count
        if item.kind in self.enums:
            # An enumeration takes one byte.
            return count
        return self.size_of(self.structs[item.kind]) * count


def camel(name: str) -> str:
    """Turn a snake_case name into CamelCase."""
    return "".join(part.capitalize() for part in name.split("_"))


def load_spec(path: Path) -> Spec:
    """Read, check and return the specification. Raises SpecError."""
    raw = tomllib.loads(path.read_text(encoding="utf-8"))
    enums = {name: _enum(name, body) for name, body in raw["enum"].items()}
    # A struct may hold only those before it, so there is no circle.
    type_names = set(SCALARS) | set(enums)
    structs: dict[str, Struct] = {}
    for name, body in raw["struct"].items():
        structs[name] = Struct(name, body["doc"], _fields(body["fields"], type_names))
        type_names.add(name)
    messages = tuple(
        _message(name, body, raw["link"]["reply_bit"], type_names) for name, body in raw["message"].items()
    )
    major, minor, patch = (int(part) for part in raw["protocol"]["firmware_version"].split("."))
    spec = Spec(
        hash=_hash(raw),
        firmware_version=(major, minor, patch),
        link=raw["link"],
        release_doc=raw["release"]["doc"],
        limits=tuple(Limit(name, body["value"], body["doc"]) for name, body in raw["limits"].items()),
        enums=enums,
        structs=structs,
        imus=tuple(Imu(**body) for body in raw["imu"].values()),
        messages=messages,
    )
    _check(spec)
    return spec


def _fields(raw: list[dict[str, str]], type_names: set[str]) -> tuple[Field, ...]:
    fields = []
    for entry in raw:
        match = re.fullmatch(r"(\w+?)(?:\[(\d+)\])?", entry["type"])
        if match is None or match[1] not in type_names:
            raise SpecError(f"field {entry['name']}: unknown type {entry['type']}")
        # Fields become attributes of Python classes.
        if keyword.iskeyword(entry["name"]):
            raise SpecError(f"field {entry['name']}: a word of Python's own")
        count = int(match[2]) if match[2] else None
        fields.append(Field(entry["name"], match[1], count, entry["doc"], entry.get("unit", "")))
    return tuple(fields)


def _enum(name: str, body: dict[str, Any]) -> Enum:
    values = tuple(
        EnumValue(key, value["value"], value["doc"], value.get("meaning", ""), value.get("remedy", ""))
        for key, value in body.items()
        if key != "doc"
    )
    # On the wire only the value counts.
    if len({value.value for value in values}) != len(values):
        raise SpecError(f"enum {name}: two names share a value")
    return Enum(name, body["doc"], values)


def _message(name: str, body: dict[str, Any], reply_bit: int, type_names: set[str]) -> Message:
    def part(key: str, type_id: int) -> Struct | None:
        if key not in body:
            return None
        return Struct(camel(name) + key.capitalize(), body["doc"], _fields(body[key], type_names), type_id)

    number = body["id"]
    return Message(
        name=name,
        id=number,
        boards=tuple(body["board"]),
        doc=body["doc"],
        idempotent=body["idempotent"],
        request=part("request", number),
        reply=part("reply", number | reply_bit),
        stream=part("stream", number),
    )


def _check(spec: Spec) -> None:
    ids = [message.id for message in spec.messages]
    # The highest bit marks a reply.
    if len(set(ids)) != len(ids) or any(not 0 < number < 0x80 for number in ids):
        raise SpecError("message ids must be different and within 0x01 to 0x7F")
    for message in spec.messages:
        for payload in message.payloads:
            if spec.size_of(payload) > spec.link["max_payload_bytes"]:
                raise SpecError(f"message {message.name}: payload over link.max_payload_bytes")
    if len({imu.who_am_i for imu in spec.imus}) != len(spec.imus):
        raise SpecError("two IMUs share a who_am_i")
    layout = BlockLayout.of(spec)
    if layout.events_offset + spec.limit("events_per_block") * layout.event_bytes > layout.crc_offset:
        raise SpecError("a data block does not hold its samples and events")
    for name in ("LogHeader", "LogFooter"):
        if layout.header_bytes + spec.size_of(spec.structs[name]) > layout.crc_offset:
            raise SpecError(f"{name} does not fit a block")
    # Value 0 is no error.
    for value in spec.enums["ErrorCode"].values:
        if value.value and not (value.meaning and value.remedy):
            raise SpecError(f"error {value.name}: meaning and remedy are missing")


@dataclass(frozen=True)
class BlockLayout:
    """Where things stand in a block, in bytes."""

    block_bytes: int
    header_bytes: int
    sample_bytes: int
    event_bytes: int
    events_offset: int
    crc_offset: int

    @classmethod
    def of(cls, spec: Spec) -> BlockLayout:
        header = spec.size_of(spec.structs["BlockHeader"])
        sample = spec.size_of(spec.structs["Sample"])
        block = spec.limit("block_bytes")
        return cls(
            block_bytes=block,
            header_bytes=header,
            sample_bytes=sample,
            event_bytes=spec.size_of(spec.structs["Event"]),
            events_offset=header + spec.limit("samples_per_block") * sample,
            # The CRC-32 is the last word.
            crc_offset=block - 4,
        )


def _hash(raw: dict[str, Any]) -> bytes:
    """First 8 bytes of the SHA-256 over what decides whether two sides understand each other."""

    def bones(value: Any) -> Any:
        if isinstance(value, dict):
            # Sides that differ in words or release only still understand each other.
            prose = ("doc", "meaning", "remedy", "idempotent", "firmware_version")
            return {key: bones(item) for key, item in value.items() if key not in prose}
        if isinstance(value, list):
            return [bones(item) for item in value]
        return value

    text = json.dumps(bones(raw), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).digest()[:8]
