"""The Python module host/tfsat_host/protocol/."""

from __future__ import annotations

from .spec import SCALARS, BlockLayout, Field, Spec, Struct

_NOTE = "Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit."


def generate(spec: Spec) -> dict[str, str]:
    """Module name to source text."""
    return {
        "limits": _limits(spec),
        "enums": _enums(spec),
        "remedies": _remedies(spec),
        "messages": _messages(spec),
        "log_layout": _log_layout(spec),
        "imus": _imus(spec),
    }


def _head(title: str) -> list[str]:
    return [f'"""{title}', "", _NOTE, '"""', "", "from __future__ import annotations"]


def _limits(spec: Spec) -> str:
    lines = [
        *_head("Numbers that host and boards agree on."),
        "",
        f"PROTOCOL_HASH = bytes.fromhex({spec.hash.hex()!r})".replace("'", '"'),
        f"FIRMWARE_VERSION = {spec.firmware_version!r}",
        f"MAX_PAYLOAD_BYTES = {spec.link['max_payload_bytes']}",
        f"REPLY_BIT = {spec.link['reply_bit']:#04x}",
    ]
    for limit in spec.limits:
        lines += [f"{limit.name.upper()} = {limit.value}", f'"""{limit.doc}"""']
    return "\n".join(lines) + "\n"


def _enums(spec: Spec) -> str:
    lines = [*_head("Enumerations of the protocol."), "", "from enum import IntEnum"]
    for enum in spec.enums.values():
        lines += ["", "", f"class {enum.name}(IntEnum):", f'    """{enum.doc}"""', ""]
        for value in enum.values:
            lines += [f"    {value.name.upper()} = {value.value}", f'    """{value.doc}"""']
    return "\n".join(lines) + "\n"


def _remedies(spec: Spec) -> str:
    lines = [
        *_head("What each error code of a board means for the drop, and what to do."),
        "",
        "from .enums import ErrorCode",
        "",
        "REMEDIES: dict[ErrorCode, tuple[str, str, str]] = {",
    ]
    for value in spec.enums["ErrorCode"].values:
        lines += [
            f"    ErrorCode.{value.name.upper()}: (",
            f'        "{value.doc}",',
            f'        "{value.meaning}",',
            f'        "{value.remedy}",',
            "    ),",
        ]
    lines += ["}", '"""Error code: (what happened, what it means, what to do)."""']
    return "\n".join(lines) + "\n"


def _imus(spec: Spec) -> str:
    lines = [
        *_head("Parts that may be IMUs: register-compatible with the MPU-6050."),
        "",
        "from dataclasses import dataclass",
        "",
        "",
        "@dataclass(frozen=True, slots=True)",
        "class ImuPart:",
        '    """One kind of IMU. The comments below name the data sheets.',
        "",
        "    Attributes:",
        "        name: Type.",
        "        who_am_i: Register 0x75.",
        "        temperature_lsb_per_c: Counts a deg C of the die.",
        "        temperature_offset_c: At zero counts.",
        "        gyro_delay_us: (7,) of the gyros' low-pass, by DLPF_CFG.",
        "        accel_delay_us: (7,) the same of the accelerometers.",
        '    """',
        "",
        "    name: str",
        "    who_am_i: int",
        "    temperature_lsb_per_c: float",
        "    temperature_offset_c: float",
        "    gyro_delay_us: tuple[int, ...]",
        "    accel_delay_us: tuple[int, ...]",
        "",
        "",
        "IMU_PARTS = {",
    ]
    for imu in spec.imus:
        figures = (imu.temperature_lsb_per_c, imu.temperature_offset_c)
        delays = (tuple(imu.gyro_delay_us), tuple(imu.accel_delay_us))
        lines += [
            f"    # {imu.doc}",
            f"    {imu.who_am_i:#x}: ImuPart(",
            *(f"        {value}," for value in (f'"{imu.name}"', f"{imu.who_am_i:#x}", *figures, *delays)),
            "    ),",
        ]
    lines += ["}", '"""By register 0x75, WHO_AM_I; the MPU-6050 first."""']
    return "\n".join(lines) + "\n"


def _python_type(field: Field) -> str:
    if field.kind == "f32":
        single = "float"
    elif field.kind in SCALARS:
        single = "int"
    else:
        single = field.kind
    if field.count is None:
        return single
    return "bytes" if field.kind == "u8" else f"tuple[{single}, ...]"


def _layout(field: Field) -> str:
    letter = SCALARS[field.kind][1] if field.kind in SCALARS else ""
    kind = f'"{letter}"' if letter else field.kind
    return f'("{field.name}", {kind}, {field.count})'


def _record(spec: Spec, struct: Struct) -> list[str]:
    lines = [
        "",
        "",
        f"class {struct.name}({'Record' if struct.type_id is None else 'Payload'}):",
    ]
    doc = " ".join(struct.doc.split())
    if struct.fields:
        lines += [f'    """{doc}', "", "    Attributes:"]
        lines += [f"        {field.name}: {field.doc}" for field in struct.fields]
        lines += ['    """', ""]
    else:
        lines += [f'    """{doc}"""', ""]
    if struct.type_id is not None:
        lines.append(f"    TYPE: ClassVar[int] = 0x{struct.type_id:02X}")
    lines.append(f"    SIZE: ClassVar[int] = {spec.size_of(struct)}")
    slots = "".join(f'"{field.name}", ' for field in struct.fields).rstrip()
    lines.append(f"    __slots__ = ({slots})")
    if struct.fields:
        lines.append("    LAYOUT: ClassVar[Layout] = (")
        lines += [f"        {_layout(field)}," for field in struct.fields]
        lines += ["    )", ""]
        lines += [f"    {field.name}: {_python_type(field)}" for field in struct.fields]
    else:
        lines.append("    LAYOUT: ClassVar[Layout] = ()")
    return lines


def _messages(spec: Spec) -> str:
    used = ", ".join(sorted({f.kind for s in _all_structs(spec) for f in s.fields if f.kind in spec.enums}))
    lines = [
        *_head("Payloads of the link's frames and records of the log."),
        "",
        "from typing import ClassVar",
        "",
        f"from .enums import {used}",
        "from .record import Layout, Payload, Record",
    ]
    for struct in _all_structs(spec):
        lines += _record(spec, struct)
    return "\n".join(lines) + "\n"


def _all_structs(spec: Spec) -> list[Struct]:
    return [*spec.structs.values(), *(payload for message in spec.messages for payload in message.payloads)]


def _log_layout(spec: Spec) -> str:
    layout = BlockLayout.of(spec)
    lines = [
        *_head("The log's blocks as numpy dtype descriptors (numpy itself is not imported here)."),
        "",
        "from typing import Any",
        "",
        f"HEADER_BYTES = {layout.header_bytes}",
        f"SAMPLE_BYTES = {layout.sample_bytes}",
        f"EVENT_BYTES = {layout.event_bytes}",
        f"EVENTS_OFFSET = {layout.events_offset}",
        f"CRC_OFFSET = {layout.crc_offset}",
    ]
    for name, struct in spec.structs.items():
        lines += ["", f"{_constant(name)}: list[tuple[Any, ...]] = ["]
        lines += [f"    {_dtype(spec, field)}," for field in struct.fields]
        lines.append("]")
    reserved = layout.crc_offset - layout.events_offset - spec.limit("events_per_block") * layout.event_bytes
    lines += ["", "DATA_BLOCK_DTYPE: list[tuple[Any, ...]] = [", "    *BLOCK_HEADER_DTYPE,"]
    lines.append(f'    ("samples", SAMPLE_DTYPE, ({spec.limit("samples_per_block")},)),')
    lines.append(f'    ("events", EVENT_DTYPE, ({spec.limit("events_per_block")},)),')
    if reserved:
        lines.append(f'    ("reserved", "V{reserved}"),')
    lines += ['    ("crc", "<u4"),', "]"]
    return "\n".join(lines) + "\n"


def _constant(name: str) -> str:
    return (
        "".join(f"_{letter}" if letter.isupper() else letter for letter in name).strip("_").upper() + "_DTYPE"
    )


def _dtype(spec: Spec, field: Field) -> str:
    if field.kind in SCALARS:
        kind = f'"{SCALARS[field.kind][2]}"'
    elif field.kind in spec.enums:
        kind = '"u1"'
    else:
        kind = _constant(field.kind)
    shape = "" if field.count is None else f", ({field.count},)"
    return f'("{field.name}", {kind}{shape})'
