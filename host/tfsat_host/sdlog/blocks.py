"""Finds the undamaged blocks of a file, wherever they stand."""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct

import numpy as np
from fastcrc.crc32 import iso_hdlc as crc32
from numpy.typing import NDArray

from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.limits import (
    BLOCK_BYTES,
    BLOCK_MAGIC,
    BLOCK_VERSION,
    EVENTS_PER_BLOCK,
    SAMPLES_PER_BLOCK,
)
from tfsat_host.protocol.log_layout import BLOCK_HEADER_DTYPE, CRC_OFFSET, HEADER_BYTES

from .source import LogSource

LATEST_TIME_US = 1 << 62
"""A logger's clock cannot show more; a block that says so is not believed."""

_MAGIC = BLOCK_MAGIC.to_bytes(4, "little")
_BODY_AND_CRC = Struct(f"<{CRC_OFFSET}sI")
_BLOCK = np.dtype(
    [("head", np.dtype(BLOCK_HEADER_DTYPE)), ("body", f"V{CRC_OFFSET - HEADER_BYTES}"), ("crc", "<u4")]
)
_ENTRY = np.dtype(
    [
        ("position", "<u8"),
        ("session", "<u4"),
        ("number", "<u4"),
        ("crc", "<u4"),
        ("kind", "u1"),
        ("sample_count", "u1"),
        ("event_count", "u1"),
    ]
)


@dataclass(frozen=True, eq=False)
class BlockIndex:
    """What a scan found.

    Attributes:
        entries: One record a block that can be used, in file order: `position` (blocks from the start
            of the file), `session`, `number`, `crc`, `kind`, `sample_count`, `event_count`.
        never_written: Blocks of zeros.
        torn: Blocks that begin like ours and whose CRC is wrong; a ragged end of the file is one.
        foreign: Blocks that are not ours.
        malformed: Blocks with a right CRC and impossible contents.
        newer: Blocks with a right CRC and another layout version.
    """

    entries: NDArray[np.void]
    never_written: int
    torn: int
    foreign: int
    malformed: int
    newer: int


def scan(source: LogSource) -> BlockIndex:
    """Look at every block of the file. Raises LogError when the file cannot be read."""
    found: list[NDArray[np.void]] = []
    never_written = torn = foreign = malformed = newer = 0
    for first, data in source.chunks():
        blocks = np.frombuffer(data, _BLOCK)
        head = np.ascontiguousarray(blocks["head"])
        ours = head["magic"] == BLOCK_MAGIC
        sound = ours & _crc_matches(data, ours)
        known = sound & (head["version"] == BLOCK_VERSION)
        usable = known & _possible(head)
        if not ours.all():
            zero = int(np.count_nonzero(_is_zero(data)))
            never_written += zero
            foreign += int(np.count_nonzero(~ours)) - zero
        torn += int(np.count_nonzero(ours & ~sound))
        newer += int(np.count_nonzero(sound & ~known))
        malformed += int(np.count_nonzero(known & ~usable))
        found.append(_entries(head, blocks["crc"], usable, first))
    tail = source.tail()
    if tail.startswith(_MAGIC):
        torn += 1
    elif any(tail):
        foreign += 1
    entries = np.concatenate(found) if found else np.empty(0, _ENTRY)
    return BlockIndex(entries, never_written, torn, foreign, malformed, newer)


def _crc_matches(data: memoryview, ours: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which of the blocks marked in `ours` have a right CRC; bool, one a block."""
    if ours.all():
        checks = (crc32(body) == crc for body, crc in _BODY_AND_CRC.iter_unpack(data))
        return np.fromiter(checks, np.bool_, len(ours))
    matches = np.zeros(len(ours), np.bool_)
    for index in np.flatnonzero(ours).tolist():
        body, crc = _BODY_AND_CRC.unpack_from(data, index * BLOCK_BYTES)
        matches[index] = crc32(body) == crc
    return matches


def _is_zero(data: memoryview) -> NDArray[np.bool_]:
    words = np.frombuffer(data, "<u8").reshape(-1, BLOCK_BYTES // 8)
    zero: NDArray[np.bool_] = words.max(axis=1) == 0
    return zero


def _possible(head: NDArray[np.void]) -> NDArray[np.bool_]:
    kinds = (head["kind"] >= min(BlockKind)) & (head["kind"] <= max(BlockKind))
    counts = (head["sample_count"] <= SAMPLES_PER_BLOCK) & (head["event_count"] <= EVENTS_PER_BLOCK)
    possible: NDArray[np.bool_] = kinds & counts & (head["time_us"] < LATEST_TIME_US)
    return possible


def _entries(
    head: NDArray[np.void], crc: NDArray[np.uint32], usable: NDArray[np.bool_], first: int
) -> NDArray[np.void]:
    where = np.flatnonzero(usable)
    if len(where) != len(usable):
        head, crc = head[where], crc[where]
    entries = np.empty(len(where), _ENTRY)
    entries["position"] = where + first
    entries["number"] = head["block_number"]
    entries["crc"] = crc
    for name in ("session", "kind", "sample_count", "event_count"):
        entries[name] = head[name]
    return entries
