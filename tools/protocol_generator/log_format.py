"""docs/log-format.md: prose from log_format.in.md, tables and numbers from the specification."""

from __future__ import annotations

import re
from pathlib import Path

from .schema import schema_text
from .spec import BlockLayout, Enum, Spec, SpecError, Struct

_PROSE = Path(__file__).with_name("log_format.in.md")
_WIDTH = 116


def generate(spec: Spec) -> str:
    """Write the page. Raises SpecError for a name between @ signs that nothing fills."""
    values = _numbers(spec) | {name: _fields(spec, struct) for name, struct in spec.structs.items()}
    values["EventCode"] = _values(spec.enums["EventCode"])
    values["StopReason"] = ", ".join(f"{v.value} {v.name}" for v in spec.enums["StopReason"].values) + "."
    values["ErrorCode"] = _wrap(_error_codes(spec), "\n  ")
    values["schema"] = _wrap(schema_text(spec), "\n> ")
    values["imus"] = _imu_table(spec)
    values["reader"] = _reader(spec)

    def value(match: re.Match[str]) -> str:
        if match[1] not in values:
            raise SpecError(f"{_PROSE.name}: nothing is called @{match[1]}@")
        return values[match[1]]

    return re.sub(r"@(\w+)@", value, _PROSE.read_text(encoding="utf-8"))


def _error_codes(spec: Spec) -> str:
    """List the errors that events carry: those of sensors and of the card."""
    about = ("sensor_", "bus_", "card_", "no_card")
    # By the beginning of the name: errors of requests never come as events.
    codes = [code for code in spec.enums["ErrorCode"].values if code.name.startswith(about)]
    return ", ".join(f"{code.value} {code.name}" for code in codes) + "."


def _numbers(spec: Spec) -> dict[str, str]:
    layout = BlockLayout.of(spec)
    numbers = {limit.name: limit.value for limit in spec.limits} | {
        "header_bytes": layout.header_bytes,
        "body_bytes": layout.crc_offset - layout.header_bytes,
        "events_offset": layout.events_offset,
        "crc_offset": layout.crc_offset,
        "sample_bytes": spec.size_of(spec.structs["Sample"]),
        "event_bytes": spec.size_of(spec.structs["Event"]),
        "block_magic_hex": f"{spec.limit('block_magic'):08X}",
    }
    numbers |= {f"kind_{kind.name}": kind.value for kind in spec.enums["BlockKind"].values}
    return {name: str(number) for name, number in numbers.items()}


def _fields(spec: Spec, struct: Struct) -> str:
    lines = [
        f"{' '.join(struct.doc.split())} {spec.size_of(struct)} bytes.",
        "",
        "| offset | field | type | meaning |",
        "|---|---|---|---|",
    ]
    offset = 0
    for field in struct.fields:
        kind = field.kind if field.count is None else f"{field.kind}[{field.count}]"
        unit = f" One count is 1 {field.unit}." if "/" in field.unit else ""
        lines.append(f"| {offset} | `{field.name}` | {kind} | {field.doc}{unit} |")
        offset += spec.size_of(field)
    return "\n".join(lines)


def _values(enum: Enum) -> str:
    lines = ["| code | name | meaning |", "|---|---|---|"]
    lines += [f"| {value.value} | `{value.name}` | {value.doc} |" for value in enum.values]
    return "\n".join(lines)


def _imu_table(spec: Spec) -> str:
    """Write the table of the parts that may be IMUs."""
    lines = [
        "| part | WHO_AM_I | temperature | delay of the gyros, ms | of the accelerometers, ms | source |",
        "|---|---|---|---|---|---|",
    ]
    for imu in spec.imus:
        delays = (
            ", ".join(f"{us / 1000:g}" for us in delays_us)
            for delays_us in (imu.gyro_delay_us, imu.accel_delay_us)
        )
        lines.append(
            f"| {imu.name} | 0x{imu.who_am_i:02X} | {imu.temperature_lsb_per_c:g} counts a °C, "
            f"{imu.temperature_offset_c:g} °C at 0 | {' | '.join(delays)} | {imu.doc} |"
        )
    return "\n".join(lines)


def _wrap(text: str, joint: str) -> str:
    lines = [""]
    for word in text.split(" "):
        if lines[-1] and len(lines[-1]) + len(word) >= _WIDTH:
            lines.append("")
        lines[-1] += f" {word}" if lines[-1] else word
    return joint.join(lines)


def _reader(spec: Spec) -> str:
    layout = BlockLayout.of(spec)
    return f"""\
import struct, sys, zlib

blocks = {{}}
with open(sys.argv[1], "rb") as file:
    while len(block := file.read({layout.block_bytes})) == {layout.block_bytes}:
        magic, _, kind, samples, _, session, number = struct.unpack_from("<4s4B2I", block)
        (crc,) = struct.unpack_from("<I", block, {layout.crc_offset})
        if magic == b"{spec.limit("block_magic").to_bytes(4, "little").decode()}" \
and crc == zlib.crc32(block[:{layout.crc_offset}]):
            blocks.setdefault(number, (kind, samples, block))
for kind, samples, block in (blocks[number] for number in sorted(blocks)):
    (time_us,) = struct.unpack_from("<Q", block, 24)
    for slot in range(samples if kind == {_value(spec, "BlockKind", "data")} else 0):
        offset_us, flags, *counts = struct.unpack_from("<IH28h6H", block, \
{layout.header_bytes} + slot * {layout.sample_bytes})
        print(time_us + offset_us, flags, *counts)  # body 1: accel x y z, temperature, gyro x y z; ...
"""


def _value(spec: Spec, enum: str, name: str) -> int:
    return next(value.value for value in spec.enums[enum].values if value.name == name)
