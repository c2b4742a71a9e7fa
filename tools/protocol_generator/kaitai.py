"""protocol/tfsat_log.ksy: the log's grammar for Kaitai Struct, an independent decoder."""

from __future__ import annotations

from .spec import BlockLayout, Field, Spec, Struct

_SCALARS = {"u8": "u1", "u16": "u2", "u32": "u4", "u64": "u8", "i16": "s2", "i32": "s4", "f32": "f4"}


def generate(spec: Spec) -> str:
    """Write the grammar's text."""
    layout = BlockLayout.of(spec)
    lines = [
        "# Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.",
        "meta:",
        "  id: tfsat_log",
        "  title: tfsat drop log",
        "  endian: le",
        "  license: MIT",
        "doc: |",
        f"  A row of {layout.block_bytes}-byte blocks. Kaitai does not check the CRC: see `crc` of each block",
        "  (CRC-32/ISO-HDLC over the bytes before it). A block that was never written is all zero.",
        "seq:",
        "  - id: blocks",
        "    type: block",
        f"    size: {layout.block_bytes}",
        "    repeat: eos",
        "types:",
        "  block:",
        "    seq:",
        "      - id: head",
        "        type: block_header",
        "      - id: body",
        f"        size: {layout.crc_offset - layout.header_bytes}",
        "        type:",
        "          switch-on: head.kind",
        "          cases:",
        "            'block_kind::header': log_header",
        "            'block_kind::data': data",
        "            'block_kind::footer': log_footer",
        "      - id: crc",
        "        type: u4",
        "  data:",
        "    seq:",
        "      - id: sample_slots",
        "        type: sample",
        "        repeat: expr",
        f"        repeat-expr: {spec.limit('samples_per_block')}",
        "      - id: event_slots",
        "        type: event",
        "        repeat: expr",
        f"        repeat-expr: {spec.limit('events_per_block')}",
    ]
    for struct in spec.structs.values():
        lines += _type(spec, struct)
    lines.append("enums:")
    for name, enum in spec.enums.items():
        if any(field.kind == name for struct in spec.structs.values() for field in struct.fields):
            lines.append(f"  {_snake(name)}:")
            for value in enum.values:
                lines += [
                    f"    {value.value}:",
                    f"      id: {value.name}",
                    f"      doc: {_quote(value.doc)}",
                ]
    return "\n".join(lines) + "\n"


def _type(spec: Spec, struct: Struct) -> list[str]:
    lines = [f"  {_snake(struct.name)}:", f"    doc: {_quote(struct.doc)}", "    seq:"]
    for field in struct.fields:
        lines += [f"      - id: {field.name}", *_field(spec, field), f"        doc: {_quote(field.doc)}"]
    return lines


def _field(spec: Spec, field: Field) -> list[str]:
    if field.kind in spec.enums:
        lines = ["        type: u1", f"        enum: {_snake(field.kind)}"]
    else:
        lines = [f"        type: {_SCALARS.get(field.kind, _snake(field.kind))}"]
    if field.count is not None:
        lines += ["        repeat: expr", f"        repeat-expr: {field.count}"]
    return lines


def _snake(name: str) -> str:
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name).strip("_")


def _quote(text: str) -> str:
    return "'" + text.replace("'", "''") + "'"
