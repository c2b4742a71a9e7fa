"""Tells the undamaged blocks of a log from everything else that a file can hold."""

from __future__ import annotations

from dataclasses import dataclass, fields
from itertools import starmap
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
from tfsat_host.protocol.log_layout import BLOCK_HEADER_DTYPE, HEADER_BYTES

LATEST_TIME_US = 1 << 60
"""A logger's clock cannot show more; a block that says so is not believed."""

MAGIC = BLOCK_MAGIC.to_bytes(4, "little")
HEAD = np.dtype(BLOCK_HEADER_DTYPE)
# As plain numbers: numpy asks an enumeration many questions before it compares.
_FIRST_KIND, _LAST_KIND = int(min(BlockKind)), int(max(BlockKind))
_OLDEST_VERSION = 2
"""Zeros behind its header stand for the sensors' offsets, which it does not have."""
_WHOLE_BLOCK = Struct(f"{BLOCK_BYTES}s")
_RESIDUE = 0x2144DF1C
"""CRC-32 of any bytes followed by their own CRC-32, little-endian (ISO-HDLC's check residue)."""


@dataclass
class Unusable:
    """Blocks that are not taken, by reason.

    Attributes:
        never_written: Blocks of zeros.
        torn: Blocks that begin like ours and whose CRC is wrong; a ragged end of the file is one.
        foreign: Blocks that are not ours.
        malformed: Blocks with a right CRC and impossible contents.
        newer: Blocks with a right CRC and another layout version.
    """

    never_written: int = 0
    torn: int = 0
    foreign: int = 0
    malformed: int = 0
    newer: int = 0

    def add(self, other: Unusable) -> None:
        """Count the blocks of `other` too."""
        for field in fields(self):
            setattr(self, field.name, getattr(self, field.name) + getattr(other, field.name))


@dataclass(frozen=True, eq=False)
class Looked:
    """What some blocks that follow each other in the file are.

    Attributes:
        heads: (n,) of HEAD; meaningless where the block is not usable.
        usable: (n,) bool: ours, undamaged, of a known version and possible.
        unusable: The others, counted.
    """

    heads: NDArray[np.void]
    usable: NDArray[np.bool_]
    unusable: Unusable


def look(data: memoryview) -> Looked:
    """Look at every block of `data`, which is whole blocks; each block that begins like ours has its CRC checked."""
    heads = _heads(data)
    ours = heads["magic"] == BLOCK_MAGIC
    if not ours.any():
        zero = _count_zero(data)
        return Looked(heads, ours, Unusable(never_written=zero, foreign=len(ours) - zero))
    sound = ours & _crc_is_right(data)
    known = sound & (heads["version"] >= _OLDEST_VERSION) & (heads["version"] <= BLOCK_VERSION)
    usable = known & _possible(heads)
    if usable.all():
        return Looked(heads, usable, Unusable())
    counts = [int(np.count_nonzero(mask)) for mask in (ours, sound, known, usable)]
    others = len(ours) - counts[0]
    zero = _count_zero(data) if others else 0
    unusable = Unusable(
        never_written=zero,
        foreign=others - zero,
        torn=counts[0] - counts[1],
        newer=counts[1] - counts[2],
        malformed=counts[2] - counts[3],
    )
    return Looked(heads, usable, unusable)


def is_sound(block: bytes) -> bool:
    """Whether the CRC at the end of a block is right."""
    return crc32(block) == _RESIDUE


def look_at_tail(tail: bytes) -> Unusable:
    """What the bytes behind the last whole block are."""
    if tail.startswith(MAGIC):
        return Unusable(torn=1)
    return Unusable(foreign=int(any(tail)))


def _heads(data: memoryview) -> NDArray[np.void]:
    words = np.frombuffer(data, "<u4").reshape(-1, BLOCK_BYTES // 4)
    return words[:, : HEADER_BYTES // 4].copy().view(HEAD)[:, 0]


def _crc_is_right(data: memoryview) -> NDArray[np.bool_]:
    """(n,) bool. Over a block and the CRC at its end, the CRC of every sound block is the same number."""
    count = len(data) // BLOCK_BYTES
    whole = np.fromiter(starmap(crc32, _WHOLE_BLOCK.iter_unpack(data)), np.uint32, count)
    right: NDArray[np.bool_] = whole == _RESIDUE
    return right


def _count_zero(data: memoryview) -> int:
    words = np.frombuffer(data, "<u8").reshape(-1, BLOCK_BYTES // 8)
    return len(words) - int(np.count_nonzero(words.any(axis=1)))


def _possible(heads: NDArray[np.void]) -> NDArray[np.bool_]:
    kinds = (heads["kind"] >= _FIRST_KIND) & (heads["kind"] <= _LAST_KIND)
    counts = (heads["sample_count"] <= SAMPLES_PER_BLOCK) & (heads["event_count"] <= EVENTS_PER_BLOCK)
    possible: NDArray[np.bool_] = kinds & counts & (heads["time_us"] < LATEST_TIME_US)
    return possible
