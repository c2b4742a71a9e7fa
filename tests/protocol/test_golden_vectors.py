"""The golden vectors in both languages: every payload, every frame, every kind of block, byte by byte."""

from __future__ import annotations

import json
import struct
import zlib
from enum import IntEnum
from pathlib import Path
from typing import Any

import pytest

from tests.fixtures.cpp.compiling import SKETCHES, build_program, run
from tests.paths import REPOSITORY
from tfsat_host.protocol import messages
from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.framing import Frame, FrameReceiver, crc16, encode_frame
from tfsat_host.protocol.limits import BLOCK_BYTES, BLOCK_MAGIC, BLOCK_VERSION, PROTOCOL_HASH
from tfsat_host.protocol.log_layout import CRC_OFFSET, EVENTS_OFFSET, HEADER_BYTES
from tfsat_host.protocol.record import Payload, ProtocolError, Record

HERE = Path(__file__).parent
STANDARDS = ("c++11", "c++17")
GOLDEN: dict[str, Any] = json.loads((REPOSITORY / "protocol" / "golden_vectors.json").read_text())
FRAMES: list[dict[str, Any]] = GOLDEN["frames"]
BLOCKS: list[dict[str, Any]] = GOLDEN["blocks"]


def payload_class(name: str) -> type[Payload]:
    payload_type: type[Payload] = getattr(messages, name)
    return payload_type


def from_plain(record: type[Record], values: dict[str, Any]) -> Record:
    """Build a record from JSON's lists and numbers."""

    def decode_value(kind: Any, value: Any) -> Any:
        if isinstance(kind, str):
            return value
        return from_plain(kind, value) if issubclass(kind, Record) else kind(value)

    def field(kind: Any, count: int | None, value: Any) -> Any:
        if count is None:
            return decode_value(kind, value)
        items = [decode_value(kind, item) for item in value]
        return bytes(items) if kind == "B" else tuple(items)

    return record(*(field(kind, count, values[name]) for name, kind, count in record.LAYOUT))


def test_every_payload_has_a_vector() -> None:
    payloads = {name for name in dir(messages) if hasattr(getattr(messages, name), "TYPE")}
    assert payloads == {vector["payload_name"] for vector in FRAMES}
    assert GOLDEN["protocol_hash"] == PROTOCOL_HASH.hex()


@pytest.mark.parametrize("vector", FRAMES, ids=lambda vector: vector["payload_name"])
def test_payload_and_frame(vector: dict[str, Any]) -> None:
    kind = payload_class(vector["payload_name"])
    payload, frame = bytes.fromhex(vector["payload"]), bytes.fromhex(vector["frame"])
    record = from_plain(kind, vector["values"])
    assert vector["type"] == kind.TYPE
    assert len(payload) == kind.SIZE
    assert record.encode() == payload
    assert kind.decode(payload) == record
    expected = Frame(vector["type"], vector["sequence"], payload)
    assert encode_frame(expected) == frame
    assert list(FrameReceiver().feed(frame)) == [expected]


@pytest.mark.parametrize("vector", FRAMES, ids=lambda vector: vector["payload_name"])
def test_a_payload_of_another_length_is_refused(vector: dict[str, Any]) -> None:
    kind = payload_class(vector["payload_name"])
    payload = bytes.fromhex(vector["payload"])
    for wrong in [payload + b"\0"] + [payload[:-1]] * bool(payload):
        with pytest.raises(ProtocolError, match=f"{len(wrong)} bytes instead of {len(payload)}"):
            kind.decode(wrong)


def enum_fields() -> list[tuple[type[Payload], int]]:
    """Payloads with an enumeration, and where in them its byte stands."""
    fields = []
    for vector in FRAMES:
        kind, offset = payload_class(vector["payload_name"]), 0
        for _, field, count in kind.LAYOUT:
            if isinstance(field, str):
                size = struct.calcsize("<" + field)
            elif issubclass(field, IntEnum):
                fields.append((kind, offset))
                size = 1
            else:
                size = field.SIZE
            offset += size * (1 if count is None else count)
        assert offset == kind.SIZE
    return fields


@pytest.mark.parametrize(
    ("kind", "offset"), enum_fields(), ids=lambda value: getattr(value, "__name__", value)
)
def test_an_unknown_enumerator_is_a_protocol_error(kind: type[Record], offset: int) -> None:
    payload = bytearray(kind.SIZE)
    if kind is messages.HelloReply:
        payload[0] = 1
    payload[offset] = 0xEE
    with pytest.raises(ProtocolError, match=r"238 is no \w+") as caught:
        kind.decode(bytes(payload))
    assert caught.value.exit_code == 1
    assert caught.value.next_step


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block["kind"])
def test_block(block: dict[str, Any]) -> None:
    data = bytes.fromhex(block["bytes"])
    assert len(data) == BLOCK_BYTES
    head = messages.BlockHeader.decode(data[:HEADER_BYTES])
    assert head == from_plain(messages.BlockHeader, block["head"])
    assert (head.magic, head.version) == (BLOCK_MAGIC, BLOCK_VERSION)
    assert head.kind == BlockKind[block["kind"].upper()]
    parts: list[Record] = [head]
    if head.kind == BlockKind.DATA:
        parts += [from_plain(messages.Sample, sample) for sample in block["samples"]]
        assert sum(part.SIZE for part in parts) == EVENTS_OFFSET
        parts += [from_plain(messages.Event, event) for event in block["events"]]
    else:
        body = messages.LogHeader if head.kind == BlockKind.HEADER else messages.LogFooter
        parts.append(from_plain(body, block["body"]))
    offset = 0
    for part in parts:
        assert type(part).decode(data[offset : offset + part.SIZE]) == part
        offset += part.SIZE
    text = b"".join(part.encode() for part in parts).ljust(CRC_OFFSET, b"\0")
    assert data == text + struct.pack("<I", zlib.crc32(text))


def test_the_crc_is_the_one_that_the_specification_names() -> None:
    assert crc16(b"123456789") == 0x29B1  # check value of CRC-16/IBM-3740 in the RevEng catalogue


def blocks_header() -> str:
    """Return the blocks as a C++ header: the generated header has the frames only."""
    rows = ",\n".join(
        "    {{" + ", ".join(f"0x{byte:02X}" for byte in bytes.fromhex(block["bytes"])) + "}}"
        for block in BLOCKS
    )
    return (
        "#pragma once\nnamespace tfsat {\nnamespace golden {\n"
        f"struct Block {{ uint8_t bytes[{BLOCK_BYTES}]; }};\n"
        f"static const Block kBlocks[] = {{\n{rows}}};\n}}\n}}\n"
    )


@pytest.mark.parametrize(("sketch", "standard"), [*zip(SKETCHES, STANDARDS, strict=True)])
def test_the_sketches_copies_in_cpp(tmp_path: Path, sketch: str, standard: str) -> None:
    """Compile each sketch's copy by one of the two language standards, as the copies are the same text."""
    (tmp_path / "golden_blocks.h").write_text(blocks_header())
    includes = [REPOSITORY / "firmware" / sketch / "src" / "protocol", REPOSITORY / "protocol"]
    includes += [REPOSITORY / "tests" / "fixtures" / "cpp", tmp_path]
    run([build_program([HERE / "golden_vectors.cpp"], tmp_path / "program", includes, standard)])
