"""Samples, events and ends out of a recording's blocks, some thousand blocks at a time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import BoolArray, IntArray, RecordArray
from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.limits import (
    ANGLE_SENSOR_COUNT,
    BLOCK_BYTES,
    IMU_COUNT,
    SAMPLES_PER_BLOCK,
    SWITCH_COUNT,
)
from tfsat_host.protocol.log_layout import (
    CRC_OFFSET,
    DATA_BLOCK_DTYPE,
    EVENT_DTYPE,
    HEADER_BYTES,
    SAMPLE_DTYPE,
)
from tfsat_host.protocol.messages import LogFooter, Sample
from tfsat_host.protocol.record import ProtocolError

from .header import HeaderChoice
from .ledger import Ledger

_BLOCK, _EVENT, _SAMPLE = np.dtype(DATA_BLOCK_DTYPE), np.dtype(EVENT_DTYPE), np.dtype(SAMPLE_DTYPE)
# Heads, samples and fields are all of even size, so blocks are gathered as rows of 16-bit words.
_BLOCK_WORDS, _SAMPLE_WORDS, _FIRST_WORD = BLOCK_BYTES // 2, Sample.SIZE // 2, HEADER_BYTES // 2
_BODY_WORDS = slice(_FIRST_WORD, _FIRST_WORD + SAMPLES_PER_BLOCK * _SAMPLE_WORDS)
_DATA, _HEADER = int(BlockKind.DATA), int(BlockKind.HEADER)
_SLOTS = np.arange(SAMPLES_PER_BLOCK)


_FIELDS: Mapping[str, Any] = _SAMPLE.fields or {}


def _words_of(name: str) -> slice:
    kind, offset = _FIELDS[name]
    return slice(offset // 2, (offset + kind.itemsize) // 2)


_TIME, _FLAGS, _IMU, _ANGLE = map(_words_of, ("time_offset_us", "flags", "imu", "angle"))
_IMU_WORDS = (_IMU.stop - _IMU.start) // IMU_COUNT
_FLAG_BITS = 16 * (_FLAGS.stop - _FLAGS.start)
# Bits of a sample's flags in their order (protocol, Sample): where each sensor's group ends.
_FLAG_ENDS = np.cumsum([IMU_COUNT, ANGLE_SENSOR_COUNT, SWITCH_COUNT, IMU_COUNT])


@dataclass
class Footers:
    """Takes a recording's footers by number; the last one counts.

    Attributes:
        last: None if there is none, or none that can be understood.
        last_number: Its block number.
        differ: There are several and they differ.
        not_understood: Footers with a right CRC and impossible contents.
    """

    last: LogFooter | None = None
    last_number: int = -1
    differ: bool = False
    not_understood: int = 0

    def add(self, number: int, payload: bytes) -> None:
        """Take a footer block's number and its payload, which begins with a LogFooter."""
        try:
            footer = LogFooter.decode(payload[: LogFooter.SIZE])
        except ProtocolError:
            # The CRC was right and the contents are impossible: a doubt, no reason to refuse the file.
            self.not_understood += 1
            return
        # Blocks come by number: the last footer closes the recording, an earlier different one is a doubt.
        self.differ = self.differ or self.last not in (None, footer)
        self.last, self.last_number = footer, number


class BlockDecoder:
    """Takes the blocks of a recording by number, a chunk of them at a time.

    Args:
        most_blocks: How many can come. Room for them is reserved; memory is used as they come.

    Attributes:
        headers: Of all header blocks.
        footers: Likewise.
        ledger: What the blocks' numbers show.
    """

    def __init__(self, most_blocks: int) -> None:
        # Allocate for the most that can come: np.empty reserves addresses, pages are used as rows arrive.
        room = most_blocks * SAMPLES_PER_BLOCK
        self.headers, self.footers, self.ledger = HeaderChoice(), Footers(), Ledger()
        self._words = np.empty((room, _SAMPLE_WORDS), np.uint16)
        self._index = np.empty(room, np.int64)
        self._t_us = np.empty(room, np.int64)
        self._bits = np.empty((room, _FLAG_BITS), np.bool_)
        self._rows = 0
        self._events: list[RecordArray] = []

    def take(self, data: memoryview, heads: RecordArray, selection: BoolArray) -> None:
        """Append blocks.

        `data` are k whole blocks, `heads` (k,) their heads; `selection` (k,) the ones to take, at least one:
        usable, their numbers rising and above all before.
        """
        is_data = heads["kind"] == _DATA
        everything = selection.all()
        # Spare the copy of the heads in the usual case that every block of the chunk is taken.
        self.ledger.add(heads if everything else heads.take(np.flatnonzero(selection)))
        # Headers and footers are rare and decoded one by one; data blocks go through as arrays.
        self._take_others(data, heads, np.flatnonzero(selection & ~is_data))
        rows = np.flatnonzero(is_data if everything else selection & is_data)
        if not len(rows):
            return
        heads = heads.take(rows)
        self._take_samples(data, heads, rows)
        if heads["event_count"].any():
            # (k, slots) events, masked by each block's own count: one flat array in the order of the log.
            slots = np.frombuffer(data, _BLOCK)["events"][rows]
            self._events.append(slots[np.arange(slots.shape[1]) < heads["event_count"][:, None]])

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return all samples decoded, as columns by the names of `DropLog`."""
        rows = slice(0, self._rows)
        words = self._words[rows]
        # (n, 16) flag bits by sensor; the four groups fill all bits, so the fifth piece is empty.
        imu_valid, angle_valid, switch_open, clipped, _ = np.split(self._bits[rows], _FLAG_ENDS, axis=1)
        return {
            "sample_index": self._index[rows],
            "t_us": self._t_us[rows],
            # The same words reinterpreted as signed, (n, 4, 7): accelerometer, temperature, gyro.
            "imu_counts": words[:, _IMU].view(np.int16).reshape(-1, IMU_COUNT, _IMU_WORDS),
            "angle_counts": words[:, _ANGLE],
            "imu_valid": imu_valid,
            "angle_valid": angle_valid,
            "switch_open": switch_open,
            "clipped": clipped,
        }

    def events(self) -> RecordArray:
        """(e,) records of EVENT_DTYPE, in the order of the log."""
        return np.concatenate([np.empty(0, _EVENT), *self._events])

    def _take_others(self, data: memoryview, heads: RecordArray, rows: IntArray) -> None:
        for row, head in zip(rows.tolist(), heads.take(rows).tolist(), strict=True):
            _, _, kind, _, _, _, number, _, _, time_us = head
            payload = bytes(data[row * BLOCK_BYTES + HEADER_BYTES : row * BLOCK_BYTES + CRC_OFFSET])
            if kind == _HEADER:
                self.headers.add(number, time_us, payload)
            else:
                self.footers.add(number, payload)

    def _take_samples(self, data: memoryview, heads: RecordArray, rows: IntArray) -> None:
        blocks = np.frombuffer(data, "<u2").reshape(-1, _BLOCK_WORDS)[:, _BODY_WORDS]
        counts = heads["sample_count"]
        # (k, 6) bool: a block that waited for PARTIAL_BLOCK_MS was written as far as it was filled.
        occupied_slots = counts[:, None] > _SLOTS
        begin, end = self._rows, self._rows + int(counts.sum())
        self._rows = end
        words = self._words[begin:end]
        full = occupied_slots.all()
        if full:
            # Full blocks have no empty slots to drop: copy each run of neighbours whole.
            bodies = words.reshape(len(rows), -1)
            starts = [0, *(np.flatnonzero(np.diff(rows) != 1) + 1).tolist(), len(rows)]
            for start, stop in pairwise(starts):  # a run of neighbours at a time
                bodies[start:stop] = blocks[rows[start] : rows[stop - 1] + 1]
        else:
            # Somewhere slots are empty: gather all of them, then keep the occupied ones in order.
            words[:] = blocks[rows].reshape(-1, _SAMPLE_WORDS)[occupied_slots.ravel()]
        # Sample times are 32-bit offsets from the 64-bit time of their block.
        base_us = np.repeat(heads["time_us"].astype(np.int64), counts)
        np.add(base_us, words[:, _TIME].view("<u4")[:, 0], out=self._t_us[begin:end])
        # (k, 6) numbers that count on from each block's first sample.
        index = heads["first_sample"].astype(np.int64)[:, None] + _SLOTS
        self._index[begin:end] = index.ravel() if full else index[occupied_slots]
        # Bits by the protocol reference, Sample: imu_valid, angle_valid, switch_open, clipped.
        flags = np.ascontiguousarray(words[:, _FLAGS], "<u2").view(np.uint8)
        self._bits[begin:end] = np.unpackbits(flags, bitorder="little").view(np.bool_).reshape(-1, _FLAG_BITS)
