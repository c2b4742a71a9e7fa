"""The Python module host/tfsat_host/protocol/."""

from __future__ import annotations

from .spec import SCALARS, Field, Spec, Struct

_NOTE = "Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit."


def generate(spec: Spec) -> dict[str, str]:
    """Module name to source text."""
    return {
        "limits": _limits(spec),
        "enums": _enums(spec),
        "remedies": _remedies(spec),
        "messages": _messages(spec),
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
        "from tfsat_host.next_step import Advice, NextStep",
        "",
        "from .enums import ErrorCode",
        "",
        "REMEDIES: dict[ErrorCode, tuple[str, str, Advice]] = {",
    ]
    for value in spec.enums["ErrorCode"].values:
        lines += [
            f"    ErrorCode.{value.name.upper()}: (",
            f'        "{value.doc}",',
            f'        "{value.meaning}",',
            f"        {_advice(value.remedy)},",
            "    ),",
        ]
    lines += ["}", '"""Error code: (what happened, what it means, what to do)."""']
    return "\n".join(lines) + "\n"


def _advice(remedy: str) -> str:
    """Return a remedy as Python; its commands are in backticks, options last."""
    parts = []
    for index, text in enumerate(remedy.split("`")):
        if index % 2 == 0:
            parts += [f'"{text}"'] if text else []
            continue
        words = text.removeprefix("tfsat-host ").split()
        actions = 2 if words[0] == "log" else 1
        arguments = "".join(f'"{word}", ' for word in words[actions:]).strip()
        parts.append(f'NextStep("{" ".join(words[:actions])}"' + (f", ({arguments}))" if arguments else ")"))
    return f"Advice({', '.join(parts)})"


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


def _annotation(field: Field) -> str:
    kind = field.kind.upper() if field.kind in SCALARS else field.kind
    if field.count is None:
        return kind
    return f"Annotated[{'bytes' if field.kind == 'u8' else f'tuple[{kind}, ...]'}, {field.count}]"


def _record(struct: Struct) -> list[str]:
    doc = " ".join(struct.doc.split())
    lines = ["", "", f"class {struct.name}({'Record' if struct.type_id is None else 'Payload'}):"]
    lines += [f'    """{doc}"""', ""]
    if struct.type_id is not None:
        lines += [f"    TYPE = 0x{struct.type_id:02X}"]
    return lines + [f"    {field.name}: {_annotation(field)}  # {field.doc}" for field in struct.fields]


def _messages(spec: Spec) -> str:
    payloads = [payload for message in spec.messages for payload in message.payloads]
    structs = [*spec.structs.values(), *payloads]
    enums = sorted({field.kind for struct in structs for field in struct.fields if field.kind in spec.enums})
    numbers = ", ".join(sorted(name.upper() for name in SCALARS))
    lines = [
        *_head("Payloads of the link's frames and records of the log.")[:-2],
        "",
        "from typing import Annotated",
        "",
        "from .enums import (",
        *(f"    {name}," for name in enums),
        ")",
        f"from .record import {numbers}, Payload, Record",
    ]
    for struct in structs:
        lines += _record(struct)
    return "\n".join(lines) + "\n"
