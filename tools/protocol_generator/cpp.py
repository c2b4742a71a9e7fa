"""The C++ header that both sketches share (C++11, no heap, no library)."""

from __future__ import annotations

from .schema import schema_text
from .spec import SCALARS, BlockLayout, Enum, Field, Imu, Spec, Struct, camel

_HEAD = """\
// Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.
#ifndef TFSAT_PROTOCOL_MESSAGES_H
#define TFSAT_PROTOCOL_MESSAGES_H

#include <stddef.h>
#include <stdint.h>

#include "wire.h"

namespace tfsat {
namespace protocol {
"""

_TAIL = """
}  // namespace protocol
}  // namespace tfsat

#endif
"""


def generate(spec: Spec) -> str:
    """The header's text."""
    parts = [_HEAD, _constants(spec)]
    parts += [_enum(enum) for enum in spec.enums.values()]
    parts += [_struct(spec, struct) for struct in spec.structs.values()]
    parts += [_struct(spec, payload) for message in spec.messages for payload in message.payloads]
    return "".join(parts) + _TAIL


def _constants(spec: Spec) -> str:
    layout = BlockLayout.of(spec)
    hash_bytes = ", ".join(f"0x{byte:02X}" for byte in spec.hash)
    version = ", ".join(str(part) for part in spec.firmware_version)
    lines = [
        f"\nconstexpr uint8_t kProtocolHash[8] = {{{hash_bytes}}};",
        f"constexpr uint8_t kFirmwareVersion[3] = {{{version}}};",
        f"constexpr size_t kMaxPayloadBytes = {spec.link['max_payload_bytes']};",
        f"constexpr uint8_t kReplyBit = 0x{spec.link['reply_bit']:02X};",
        "",
    ]
    for limit in spec.limits:
        kind = "uint32_t" if limit.value >= 0 else "int32_t"
        lines += [f"// {limit.doc}", f"constexpr {kind} k{camel(limit.name)} = {limit.value};"]
    lines += [
        "",
        "// Where things stand in a block.",
        f"constexpr size_t kSamplesOffset = {layout.header_bytes};",
        f"constexpr size_t kEventsOffset = {layout.events_offset};",
        f"constexpr size_t kBlockCrcOffset = {layout.crc_offset};",
        "",
        "// Parts that may be IMUs.",
        "struct ImuPart {",
        "  uint8_t who_am_i;",
        "  float temperature_lsb_per_c;",
        "  float temperature_offset_c;",
        "  bool has_accel_filter;  // ACCEL_CONFIG_2",
        "};",
        "constexpr ImuPart kImuParts[] = {",
        *(f"    {_imu(imu)},  // {imu.name}" for imu in spec.imus),
        "};",
        "",
        "// LogHeader::schema.",
        "constexpr char kLogSchema[] =",
        *(f'    "{line}"' for line in _pieces(schema_text(spec), 90)),
    ]
    lines[-1] += ";"
    return "\n".join(lines) + "\n"


def _imu(imu: Imu) -> str:
    filtered = "true" if imu.has_accel_filter else "false"
    return f"{{0x{imu.who_am_i:02X}, {imu.temperature_lsb_per_c}f, {imu.temperature_offset_c}f, {filtered}}}"


def _pieces(text: str, length: int) -> list[str]:
    return [text[start : start + length] for start in range(0, len(text), length)]


def _enum(enum: Enum) -> str:
    lines = [f"\n// {enum.doc}", f"enum class {enum.name} : uint8_t {{"]
    lines += [f"  k{camel(value.name)} = {value.value},  // {value.doc}" for value in enum.values]
    return "\n".join([*lines, "};"]) + "\n"


def _struct(spec: Spec, struct: Struct) -> str:
    lines = [f"\n// {' '.join(struct.doc.split())}", f"struct {struct.name} {{"]
    if struct.type_id is not None:
        lines.append(f"  static constexpr uint8_t kType = 0x{struct.type_id:02X};")
    lines.append(f"  static constexpr size_t kSize = {spec.size_of(struct)};")
    if not struct.fields:
        return "\n".join([*lines, "};"]) + "\n"
    lines.append("")
    for field in struct.fields:
        suffix = "" if field.count is None else f"[{field.count}]"
        lines.append(f"  {_type(field)} {field.name}{suffix};  // {field.doc}")
    lines += ["", "  void write(Writer& out) const {"]
    lines += [f"    {line}" for field in struct.fields for line in _write(spec, field)]
    lines += ["  }", "", "  void read(Reader& in) {"]
    lines += [f"    {line}" for field in struct.fields for line in _read(spec, field)]
    lines += [
        "  }",
        "",
        "  // `out` must hold kSize bytes.",
        "  void encode(uint8_t* out) const {",
        "#ifdef TFSAT_WIRE_FORM_IN_MEMORY",
        f'    static_assert(sizeof({struct.name}) == kSize, "no padding");',
        "    memcpy(out, this, kSize);",
        "#else",
        "    Writer writer(out);",
        "    write(writer);",
        "#endif",
        "  }",
        "",
        "  // False, and nothing read, when the length is not kSize.",
        "  bool decode(const uint8_t* in, size_t size) {",
        "    if (size != kSize) return false;",
        "#ifdef TFSAT_WIRE_FORM_IN_MEMORY",
        "    memcpy(this, in, kSize);",
        "#else",
        "    Reader reader(in);",
        "    read(reader);",
        "#endif",
        "    return true;",
        "  }",
    ]
    return "\n".join([*lines, "};"]) + "\n"


def _type(field: Field) -> str:
    return SCALARS[field.kind][3] if field.kind in SCALARS else field.kind


def _loop(field: Field, statement: str) -> list[str]:
    if field.count is None:
        return [statement.replace("@", field.name)]
    item = f"{field.name}[i]"
    return [f"for (size_t i = 0; i < {field.count}; ++i) {statement.replace('@', item)}"]


def _write(spec: Spec, field: Field) -> list[str]:
    if field.kind in SCALARS:
        return _loop(field, f"out.{field.kind}(@);")
    if field.kind in spec.enums:
        return _loop(field, "out.u8(static_cast<uint8_t>(@));")
    return _loop(field, "@.write(out);")


def _read(spec: Spec, field: Field) -> list[str]:
    if field.kind in SCALARS:
        return _loop(field, f"@ = in.{field.kind}();")
    if field.kind in spec.enums:
        return _loop(field, f"@ = static_cast<{field.kind}>(in.u8());")
    return _loop(field, "@.read(in);")
