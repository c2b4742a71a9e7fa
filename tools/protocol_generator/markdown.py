"""protocol/reference.md: the specification for people."""

from __future__ import annotations

from .spec import BlockLayout, Field, Spec, Struct


def generate(spec: Spec) -> str:
    """The reference's text."""
    lines = [
        "# Protocol reference",
        "",
        "Generated from `tfsat.toml` by `tools/generate_protocol.py`. Do not edit.",
        "",
        f"Protocol hash `{spec.hash.hex()}`, firmware {'.'.join(map(str, spec.firmware_version))}. "
        "All numbers are little endian.",
        "",
        "## Link",
        "",
        f"- Framing: {spec.link['framing']}.",
        f"- Frame: {spec.link['frame']}.",
        f"- CRC: {spec.link['crc']}.",
        f"- Longest payload: {spec.link['max_payload_bytes']} bytes.",
        "",
        spec.link["doc"].strip(),
        "",
        "## Release",
        "",
        spec.release_doc.strip(),
        "",
        "## Messages",
        "",
        "| id | message | boards | request | reply |",
        "|---|---|---|---|---|",
    ]
    for message in spec.messages:
        sizes = [f"{spec.size_of(part)} B" if part else "–" for part in (message.request, message.reply)]
        link = f"[{message.name}](#{message.name})"
        lines.append(
            f"| 0x{message.id:02X} | {link} | {', '.join(message.boards)} | {sizes[0]} | {sizes[1]} |"
        )
    for message in spec.messages:
        lines += ["", f"### {message.name}", "", f"{message.doc.strip()} Repeated: {message.idempotent}."]
        for title, part in (
            ("Request", message.request),
            ("Reply", message.reply),
            ("Stream", message.stream),
        ):
            if part is not None and part.fields:
                lines += ["", f"{title} (type 0x{part.type_id:02X}, {spec.size_of(part)} bytes):", ""]
                lines += _fields(spec, part)
    lines += _log(spec)
    lines += _enums(spec)
    lines += ["", "## Limits", "", "| name | value | meaning |", "|---|---|---|"]
    lines += [f"| `{limit.name}` | {limit.value} | {limit.doc} |" for limit in spec.limits]
    return "\n".join(lines) + "\n"


def _fields(spec: Spec, struct: Struct) -> list[str]:
    lines = ["| offset | field | type | meaning |", "|---|---|---|---|"]
    offset = 0
    for field in struct.fields:
        lines.append(f"| {offset} | `{field.name}` | {_type(field)} | {field.doc} |")
        offset += spec.size_of(field)
    return lines


def _type(field: Field) -> str:
    return field.kind if field.count is None else f"{field.kind}[{field.count}]"


def _log(spec: Spec) -> list[str]:
    layout = BlockLayout.of(spec)
    lines = [
        "",
        "## Log",
        "",
        f"A log is a row of blocks of {layout.block_bytes} bytes. Each block stands for itself: it begins with a "
        f"BlockHeader and ends, at offset {layout.crc_offset}, with the CRC-32/ISO-HDLC of all bytes before it.",
        "",
        "| kind | payload |",
        "|---|---|",
        f"| header | LogHeader at offset {layout.header_bytes}, zeros up to the CRC |",
        f"| data | {spec.limit('samples_per_block')} Sample slots at offset {layout.header_bytes}, "
        f"{spec.limit('events_per_block')} Event slots at offset {layout.events_offset}; unused slots are zero |",
        f"| footer | LogFooter at offset {layout.header_bytes}, zeros up to the CRC |",
    ]
    for struct in spec.structs.values():
        lines += ["", f"### {struct.name}", "", f"{struct.doc} {spec.size_of(struct)} bytes.", ""]
        lines += _fields(spec, struct)
    return lines


def _enums(spec: Spec) -> list[str]:
    lines = ["", "## Enumerations"]
    for enum in spec.enums.values():
        lines += ["", f"### {enum.name}", "", enum.doc, ""]
        if enum.name == "ErrorCode":
            lines += [
                "| value | name | what happened | what it means | what to do |",
                "|---|---|---|---|---|",
            ]
            lines += [f"| {v.value} | `{v.name}` | {v.doc} | {v.meaning} | {v.remedy} |" for v in enum.values]
        else:
            lines += ["| value | name | meaning |", "|---|---|---|"]
            lines += [f"| {v.value} | `{v.name}` | {v.doc} |" for v in enum.values]
    return lines
