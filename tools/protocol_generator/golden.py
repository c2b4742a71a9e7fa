"""Golden vectors: what every payload and one block of each kind must look like, byte by byte.

Values are drawn from a fixed formula, so that each byte of a payload differs from its neighbours and
every field's byte order shows.
"""

from __future__ import annotations

import binascii
import json
import struct
import zlib
from typing import Any

from .spec import SCALARS, BlockLayout, Field, Spec, Struct, camel

Values = dict[str, Any]


def _scalar(kind: str, state: int) -> int | float:
    size = SCALARS[kind][0]
    raw = (state * 0x9E3779B97F4A7C15 + 0x0123456789ABCDEF) % (1 << 64)
    if kind == "f32":
        return (raw % 4096) / 16.0
    value = raw >> (64 - 8 * size)
    return value - (1 << (8 * size)) if kind.startswith("i") and value >> (8 * size - 1) else value


def _draw(spec: Spec, item: Struct, state: list[int]) -> Values:
    def draw_value(field: Field) -> Any:
        state[0] += 1
        if field.kind in SCALARS:
            return _scalar(field.kind, state[0])
        if field.kind in spec.enums:
            values = spec.enums[field.kind].values
            return values[state[0] % len(values)].value
        return _draw(spec, spec.structs[field.kind], state)

    return {
        f.name: draw_value(f) if f.count is None else [draw_value(f) for _ in range(f.count)]
        for f in item.fields
    }


def _pack(spec: Spec, item: Struct, values: Values) -> bytes:
    out = b""
    for field in item.fields:
        for value in [values[field.name]] if field.count is None else values[field.name]:
            if field.kind in SCALARS:
                out += struct.pack("<" + SCALARS[field.kind][1], value)
            elif field.kind in spec.enums:
                out += struct.pack("<B", value)
            else:
                out += _pack(spec, spec.structs[field.kind], value)
    return out


def _cobs(data: bytes) -> bytes:
    out = b""
    for run in _runs(data):
        out += bytes([len(run) + 1]) + run
    return out


def _runs(data: bytes) -> list[bytes]:
    runs = []
    for part in data.split(b"\0"):
        while len(part) >= 254:
            runs.append(part[:254])
            part = part[254:]
        runs.append(part)
    return runs


def _frame(type_id: int, sequence: int, payload: bytes) -> bytes:
    body = bytes([type_id, sequence]) + payload
    return _cobs(body + struct.pack("<H", binascii.crc_hqx(body, 0xFFFF))) + b"\0"


def _vectors(spec: Spec) -> list[tuple[Struct, int, Values, bytes]]:
    state = [0]
    payloads = [payload for message in spec.messages for payload in message.payloads]
    cases = [(payload, index % 256, _draw(spec, payload, state)) for index, payload in enumerate(payloads)]
    return [(payload, sequence, values, _pack(spec, payload, values)) for payload, sequence, values in cases]


def _block(spec: Spec, kind: str, body: bytes, counts: tuple[int, int]) -> tuple[Values, bytes]:
    layout = BlockLayout.of(spec)
    numbers = {value.name: value.value for value in spec.enums["BlockKind"].values}
    head: Values = {
        "magic": spec.limit("block_magic"),
        "version": spec.limit("block_version"),
        "kind": numbers[kind],
        "sample_count": counts[0],
        "event_count": counts[1],
        "session": 0x5EED5EED,
        "block_number": 7,
        "first_sample": 36,
        "samples_dropped": 2,
        "time_us": 4_295_000_123,
    }
    text = (_pack(spec, spec.structs["BlockHeader"], head) + body).ljust(layout.crc_offset, b"\0")
    return head, text + struct.pack("<I", zlib.crc32(text))


def _blocks(spec: Spec) -> list[dict[str, Any]]:
    state = [1000]
    blocks: list[dict[str, Any]] = []
    for kind, name in (("header", "LogHeader"), ("footer", "LogFooter")):
        values = _draw(spec, spec.structs[name], state)
        head, data = _block(spec, kind, _pack(spec, spec.structs[name], values), (0, 0))
        blocks.append({"kind": kind, "head": head, "body": values, "bytes": data.hex()})
    samples = [_draw(spec, spec.structs["Sample"], state) for _ in range(spec.limit("samples_per_block"))]
    events = [_draw(spec, spec.structs["Event"], state) for _ in range(spec.limit("events_per_block"))]
    body = b"".join(_pack(spec, spec.structs["Sample"], sample) for sample in samples)
    body += b"".join(_pack(spec, spec.structs["Event"], event) for event in events)
    head, data = _block(spec, "data", body, (len(samples), len(events)))
    blocks.append({"kind": "data", "head": head, "samples": samples, "events": events, "bytes": data.hex()})
    return blocks


def generate_json(spec: Spec) -> str:
    """Write the vectors for the host's tests, as JSON."""
    frames = [
        {
            "payload_name": payload.name,
            "type": payload.type_id,
            "sequence": sequence,
            "values": values,
            "payload": data.hex(),
            "frame": _frame(payload.type_id or 0, sequence, data).hex(),
        }
        for payload, sequence, values, data in _vectors(spec)
    ]
    document: dict[str, Any] = {
        "note": "Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.",
        "protocol_hash": spec.hash.hex(),
        "frames": frames,
        "blocks": _blocks(spec),
    }
    return json.dumps(document, indent=1) + "\n"


_CPP_HEAD = """\
// Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.
//
// Include messages.h and frame.h of a sketch first.
#pragma once

namespace tfsat {
namespace golden {

struct Vector {
  const char* name;
  uint8_t type;
  uint8_t sequence;
  size_t (*build)(uint8_t* payload);
  bool (*matches)(const uint8_t* payload, size_t size);
  const uint8_t* payload;
  size_t payload_size;
  const uint8_t* frame;
  size_t frame_size;
};
"""


def generate_cpp(spec: Spec) -> str:
    """Write the vectors for the firmware's tests: each payload built field by field, and its bytes."""
    parts = [_CPP_HEAD]
    rows = []
    for payload, sequence, values, data in _vectors(spec):
        name = payload.name
        frame = _frame(payload.type_id or 0, sequence, data)
        assign = _assignments(spec, payload, values, "message")
        reads = [line.replace(" = ", " == ").rstrip(";") for line in assign]
        compare = " && ".join(reads) if reads else "true"
        declare = f"  protocol::{name} message;\n" if payload.fields else ""
        encode = "  message.encode(payload);\n" if payload.fields else "  (void)payload;\n"
        decode = (
            "  if (!message.decode(payload, size)) return false;\n"
            if payload.fields
            else "  (void)payload;\n"
        )
        length = "" if payload.fields else "  if (size != 0) return false;\n"
        parts.append(
            f"\ninline size_t build_{name}(uint8_t* payload) {{\n{declare}"
            + "".join(f"  {line}\n" for line in assign)
            + f"{encode}  return protocol::{name}::kSize;\n}}\n"
            + f"\ninline bool matches_{name}(const uint8_t* payload, size_t size) {{\n{declare}{decode}{length}"
            + f"  return {compare};\n}}\n"
            + f"\nstatic const uint8_t kPayload{name}[] = {{{_bytes(data) or '0'}}};\n"
            + f"static const uint8_t kFrame{name}[] = {{{_bytes(frame)}}};\n"
        )
        rows.append(
            f'    {{"{name}", protocol::{name}::kType, {sequence}, build_{name}, matches_{name}, '
            f"kPayload{name}, {len(data)}, kFrame{name}, {len(frame)}}},\n"
        )
    parts.append("\nstatic const Vector kVectors[] = {\n" + "".join(rows) + "};\n")
    parts.append("\n}  // namespace golden\n}  // namespace tfsat\n")
    return "".join(parts)


def _bytes(data: bytes) -> str:
    return ", ".join(f"0x{byte:02X}" for byte in data)


def _assignments(spec: Spec, item: Struct, values: Values, prefix: str) -> list[str]:
    lines: list[str] = []
    for field in item.fields:
        many = field.count is not None
        for index, value in enumerate(values[field.name] if many else [values[field.name]]):
            target = f"{prefix}.{field.name}[{index}]" if many else f"{prefix}.{field.name}"
            if field.kind in spec.structs:
                lines += _assignments(spec, spec.structs[field.kind], value, target)
            else:
                lines.append(f"{target} = {_literal(spec, field, value)};")
    return lines


def _literal(spec: Spec, field: Field, value: Any) -> str:
    if field.kind in spec.enums:
        name = next(v.name for v in spec.enums[field.kind].values if v.value == value)
        return f"protocol::{field.kind}::k{camel(name)}"
    if field.kind == "f32":
        return f"{value}f"
    if field.kind == "u64":
        return f"{value}ull"
    return f"{value}u" if field.kind.startswith("u") else str(value)
