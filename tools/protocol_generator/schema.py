"""The layout of a log in one line of ASCII, which stands in every header block."""

from __future__ import annotations

from .spec import BlockLayout, Spec, SpecError


def schema_text(spec: Spec) -> str:
    """Sample, IMU reading and event with types and units, and where they stand in a block.

    Raises:
        SpecError: it does not fit its field in LogHeader.
    """
    layout = BlockLayout.of(spec)
    text = (
        f"tfsat log, little endian, {layout.block_bytes} B blocks: head {layout.header_bytes}, "
        f"{spec.limit('samples_per_block')} Sample, {spec.limit('events_per_block')} Event, "
        f"CRC-32 at {layout.crc_offset}. "
    )
    text += "Read at + imu_offset_us, angle_offset_us. "
    text += " ".join(_struct(spec, name) for name in ("Sample", "ImuReading", "Event"))
    room = next(field.count for field in spec.structs["LogHeader"].fields if field.name == "schema")
    if room is None or len(text) > room or not text.isascii():
        raise SpecError(f"LogHeader.schema holds {room} bytes, the text of the layout has {len(text)}")
    return text


def _struct(spec: Spec, name: str) -> str:
    parts = []
    for field in spec.structs[name].fields:
        kind = "u8" if field.kind in spec.enums else field.kind
        count = "" if field.count is None else f"[{field.count}]"
        unit = f" {field.unit}" if field.unit else ""
        parts.append(f"{field.name} {kind}{count}{unit}")
    return f"{name}: {', '.join(parts)}."
