"""The undamaged blocks of a file, separated from everything else that it can hold, and where they are.

Their places are kept as pieces: a recording of hours is a handful of them.
"""

from __future__ import annotations

from collections import Counter
from itertools import pairwise, starmap
from pathlib import Path
from struct import Struct
from typing import NamedTuple

import numpy as np
from fastcrc.crc32 import iso_hdlc as crc32

from tfsat_host.arrays import BoolArray, IntArray, RecordArray
from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.limits import (
    BLOCK_BYTES,
    BLOCK_MAGIC,
    BLOCK_VERSION,
    EVENTS_PER_BLOCK,
    SAMPLES_PER_BLOCK,
)
from tfsat_host.protocol.log_layout import BLOCK_HEADER_DTYPE, HEADER_BYTES

from .log_errors import LogError

LATEST_TIME_US = 1 << 60
"""A logger's clock cannot show more; a block with a later time is not believed."""

MAGIC = BLOCK_MAGIC.to_bytes(4, "little")
HEAD = np.dtype(BLOCK_HEADER_DTYPE)
# As plain numbers: numpy asks an enumeration many questions before it compares.
_FIRST_KIND, _LAST_KIND = int(min(BlockKind)), int(max(BlockKind))
_OLDEST_VERSION = 2
"""Zeros behind its header stand for the sensors' offsets, which it does not have."""
_WHOLE_BLOCK = Struct(f"{BLOCK_BYTES}s")
_RESIDUE = 0x2144DF1C
"""CRC-32 of any bytes followed by their own CRC-32, little-endian (ISO-HDLC's check residue)."""


MAX_PIECES = 1 << 19
"""A log with more of them is refused: it would take more memory than is promised, and no card holds one."""

PIECE = np.dtype([("position", "<i8"), ("number", "<i8"), ("count", "<i8"), ("session", "<u4")])
"""`count` blocks of one session that follow each other both in the file, from block `position` on, and by number."""


class BlockScan(NamedTuple):
    """What some blocks that follow each other in the file are.

    Attributes:
        heads: (n,) of HEAD; meaningless where the block is not usable.
        usable: (n,) bool: ours, undamaged, of a known version and possible.
        unusable: How many others there are, by the reason as in `SetAside`.
    """

    heads: RecordArray
    usable: BoolArray
    unusable: Counter[str]


def look(data: memoryview) -> BlockScan:
    """Look at every block of `data`, which is whole blocks; each block that begins like ours has its CRC checked."""
    heads = _heads(data)
    # Each mask narrows the one before, so the differences of their counts give the reasons of rejection.
    ours = heads["magic"] == BLOCK_MAGIC
    # CRCs are the costly step: spare them where no block of the chunk has the magic number.
    sound = ours & _crc_is_right(data) if ours.any() else ours
    has_known_version = sound & (heads["version"] >= _OLDEST_VERSION) & (heads["version"] <= BLOCK_VERSION)
    usable = has_known_version & _possible(heads)
    # An intact stretch needs no reasons.
    if usable.all():
        return BlockScan(heads, usable, Counter())
    counts = [int(np.count_nonzero(mask)) for mask in (ours, sound, has_known_version, usable)]
    others = len(ours) - counts[0]
    # Blocks of zeros are room that was allocated and never filled: no sign of damage.
    zero = _count_zero(data) if others else 0
    torn, newer, malformed = (before - after for before, after in pairwise(counts))
    reasons = Counter(never_written=zero, foreign=others - zero, torn=torn, newer=newer, malformed=malformed)
    return BlockScan(heads, usable, reasons)


def is_sound(block: bytes) -> bool:
    """Return whether the block's trailing CRC matches its contents."""
    return crc32(block) == _RESIDUE


def look_at_tail(tail: bytes) -> Counter[str]:
    """Classify the bytes behind the last whole block."""
    return Counter(torn=1) if tail.startswith(MAGIC) else Counter(foreign=int(any(tail)))


def _heads(data: memoryview) -> RecordArray:
    # (n, 128) words; their first columns are not contiguous and are copied before they become records.
    words = np.frombuffer(data, "<u4").reshape(-1, BLOCK_BYTES // 4)
    return words[:, : HEADER_BYTES // 4].copy().view(HEAD)[:, 0]


def _crc_is_right(data: memoryview) -> BoolArray:
    """(n,) bool. Over a block and the CRC at its end, the CRC of every sound block is the same number."""
    count = len(data) // BLOCK_BYTES
    crcs = np.fromiter(starmap(crc32, _WHOLE_BLOCK.iter_unpack(data)), np.uint32, count)
    return np.asarray(crcs == _RESIDUE)


def _count_zero(data: memoryview) -> int:
    # Test words of 64 bits instead of bytes.
    words = np.frombuffer(data, "<u8").reshape(-1, BLOCK_BYTES // 8)
    return len(words) - int(np.count_nonzero(words.any(axis=1)))


def _possible(heads: RecordArray) -> BoolArray:
    # A right CRC proves what was written, not that it makes sense: more samples or events than slots,
    # or a time that no clock reaches, would index or date out of range.
    kinds = (heads["kind"] >= _FIRST_KIND) & (heads["kind"] <= _LAST_KIND)
    counts = (heads["sample_count"] <= SAMPLES_PER_BLOCK) & (heads["event_count"] <= EVENTS_PER_BLOCK)
    return np.asarray(kinds & counts & (heads["time_us"] < LATEST_TIME_US))


class PieceList:
    """Grows in the order of the file."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._done: list[RecordArray] = []
        self._length = 0

    def append(self, new: RecordArray) -> None:
        """Append pieces that stand behind all before.

        Raises:
            LogError: there are more than MAX_PIECES.
        """
        # Rejoin a piece that the border between two chunks has cut.
        if self._done and len(new) and _continues(self._done[-1][-1:], new[:1])[0]:
            self._done[-1]["count"][-1] += new["count"][0]
            new = new[1:]
        if len(new):
            self._done.append(new.copy())
            self._length += len(new)
        if self._length > MAX_PIECES:
            raise LogError(
                f"{self._path} holds undamaged blocks in more than {MAX_PIECES} separate pieces.",
                "Decode the recording's own file (DROP0001.BIN and up) instead of an image that mixes many.",
                "Nothing was decoded: this is no recording that a logger wrote, nor what a failing card leaves of one.",
            )

    def all(self) -> RecordArray:
        """Return the pieces so far, (k,) of PIECE."""
        # Concatenate once and keep the result: later calls cost nothing.
        if len(self._done) != 1:
            self._done = [np.concatenate([np.empty(0, PIECE), *self._done])]
        return self._done[0]


def as_pieces(positions: IntArray, heads: RecordArray) -> RecordArray:
    """Blocks, by rising position, as the fewest pieces."""
    blocks = np.empty(len(positions), PIECE)
    blocks["position"], blocks["number"] = positions, heads["block_number"]
    blocks["session"], blocks["count"] = heads["session"], 1
    return merge_pieces(blocks)


def merge_pieces(pieces: RecordArray) -> RecordArray:
    """Merge each piece that continues the one before it, which leaves the same blocks in the same order."""
    if len(pieces) < 2:
        return pieces
    # A new piece begins wherever position, number or session does not go on; sum the counts of each run.
    first = np.flatnonzero(np.concatenate(([True], ~_continues(pieces[:-1], pieces[1:]))))
    fewer = pieces[first]
    fewer["count"] = np.add.reduceat(pieces["count"], first)
    return fewer


def _continues(before: RecordArray, after: RecordArray) -> BoolArray:
    return np.asarray(
        (before["session"] == after["session"])
        & (before["position"] + before["count"] == after["position"])
        & (before["number"] + before["count"] == after["number"])
    )
