"""Takes samples and events out of a recording's blocks, some thousand blocks at a time."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

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
    SAMPLE_BYTES,
)

from .footers import Footers
from .header import HeaderChoice
from .ledger import Account, Ledger

_BLOCK = np.dtype(DATA_BLOCK_DTYPE)
_EVENT = np.dtype(EVENT_DTYPE)
_WORD_BYTES = 2
_BLOCK_WORDS = BLOCK_BYTES // _WORD_BYTES
_SAMPLE_WORDS = SAMPLE_BYTES // _WORD_BYTES
_FIRST_WORD = HEADER_BYTES // _WORD_BYTES
_BODY_WORDS = slice(_FIRST_WORD, _FIRST_WORD + SAMPLES_PER_BLOCK * _SAMPLE_WORDS)
_TIME, _FLAGS, _IMU, _ANGLE = slice(0, 2), 2, slice(3, 31), slice(31, 37)
_FLAG_BITS = 16
_FLAG_ENDS = np.cumsum([IMU_COUNT, ANGLE_SENSOR_COUNT, SWITCH_COUNT])
_DATA, _HEADER = int(BlockKind.DATA), int(BlockKind.HEADER)
_SLOTS = np.arange(SAMPLES_PER_BLOCK)


@dataclass(frozen=True, eq=False)
class Records:
    """Raw columns of a recording of n samples, and what its blocks say besides.

    Attributes:
        index: (n,) int64, number of the sample in the recording, lost ones counted.
        t_us: (n,) int64, the logger's clock, µs since power-up.
        imu: (n, 4, 7) int16, each IMU's accel x y z, temperature, gyro x y z, counts; a view.
        angle: (n, 6) uint16, angle sensors, counts; a view of the same memory.
        imu_valid: (n, 4) bool; this and the three below are views of one memory.
        angle_valid: (n, 6) bool.
        switch_open: (n, 2) bool.
        clipped: (n, 4) bool.
        events: (e,) records of EVENT_DTYPE, as they stand in the log.
        headers: Of all header blocks.
        footers: Likewise.
        account: What the blocks' numbers say.
    """

    index: NDArray[np.int64]
    t_us: NDArray[np.int64]
    imu: NDArray[np.int16]
    angle: NDArray[np.uint16]
    imu_valid: NDArray[np.bool_]
    angle_valid: NDArray[np.bool_]
    switch_open: NDArray[np.bool_]
    clipped: NDArray[np.bool_]
    events: NDArray[np.void]
    headers: HeaderChoice
    footers: Footers
    account: Account


class RecordsBuilder:
    """Takes the blocks of a recording by number, a chunk of them at a time.

    Args:
        most_blocks: How many can come. Room for them is reserved; memory is used as they come.
    """

    def __init__(self, most_blocks: int) -> None:
        room = most_blocks * SAMPLES_PER_BLOCK
        self._words = np.empty((room, _SAMPLE_WORDS), np.uint16)
        self._index = np.empty(room, np.int64)
        self._t_us = np.empty(room, np.int64)
        self._bits = np.empty((room, _FLAG_BITS), np.bool_)
        self._rows = 0
        self._events: list[NDArray[np.void]] = []
        self._headers, self._footers, self._ledger = HeaderChoice(), Footers(), Ledger()

    def take(self, data: memoryview, heads: NDArray[np.void], taken: NDArray[np.bool_]) -> None:
        """Append blocks.

        Args:
            data: (k blocks) whole blocks.
            heads: (k,) their heads.
            taken: (k,) bool, the ones to take; usable, their numbers rising and above all before.
        """
        kinds = heads["kind"]
        is_data = kinds == _DATA
        everything = taken.all()
        self._ledger.add(heads if everything else heads.take(np.flatnonzero(taken)))
        self._take_others(data, heads, np.flatnonzero(taken & ~is_data))
        rows = np.flatnonzero(is_data if everything else taken & is_data)
        if not len(rows):
            return
        heads = heads.take(rows)
        if (heads["sample_count"] == SAMPLES_PER_BLOCK).all():
            self._take_full(data, heads, rows)
        else:
            self._take_partial(data, heads, rows)
        if heads["event_count"].any():
            slots = np.frombuffer(data, _BLOCK)["events"][rows]
            self._events.append(slots[np.arange(slots.shape[1]) < heads["event_count"][:, None]])

    def records(self) -> Records:
        """All that came."""
        rows = slice(0, self._rows)
        words = self._words[rows]
        imu_valid, angle_valid, switch_open, clipped = np.split(self._bits[rows], _FLAG_ENDS, axis=1)
        return Records(
            index=self._index[rows],
            t_us=self._t_us[rows],
            imu=words[:, _IMU].view(np.int16).reshape(-1, IMU_COUNT, 7),
            angle=words[:, _ANGLE],
            imu_valid=imu_valid,
            angle_valid=angle_valid,
            switch_open=switch_open,
            clipped=clipped,
            events=np.concatenate([np.empty(0, _EVENT), *self._events]),
            headers=self._headers,
            footers=self._footers,
            account=self._ledger.account(),
        )

    def _take_others(self, data: memoryview, heads: NDArray[np.void], rows: NDArray[np.int64]) -> None:
        for row, head in zip(rows.tolist(), heads.take(rows).tolist(), strict=True):
            _, _, kind, _, _, _, number, _, _, time_us = head
            payload = bytes(data[row * BLOCK_BYTES + HEADER_BYTES : row * BLOCK_BYTES + CRC_OFFSET])
            if kind == _HEADER:
                self._headers.add(number, time_us, payload)
            else:
                self._footers.add(number, payload)

    def _take_full(self, data: memoryview, heads: NDArray[np.void], rows: NDArray[np.int64]) -> None:
        """Blocks without an empty slot, copied a run of neighbours at a time."""
        blocks = np.frombuffer(data, "<u2").reshape(-1, _BLOCK_WORDS)[:, _BODY_WORDS]
        count = len(rows)
        begin, end = self._rows, self._rows + count * SAMPLES_PER_BLOCK
        self._rows = end
        bodies = self._words[begin:end].reshape(count, -1)
        starts = [0, *(np.flatnonzero(np.diff(rows) != 1) + 1).tolist(), count]
        for start, stop in pairwise(starts):
            bodies[start:stop] = blocks[rows[start] : rows[stop - 1] + 1]
        offset_us = self._words[begin:end, _TIME].view("<u4").reshape(count, SAMPLES_PER_BLOCK)
        base_us = heads["time_us"].astype(np.int64)[:, None]
        np.add(base_us, offset_us, out=self._t_us[begin:end].reshape(count, -1))
        first = heads["first_sample"].astype(np.int64)[:, None]
        np.add(first, _SLOTS, out=self._index[begin:end].reshape(count, -1))
        self._unpack_flags(begin, end)

    def _take_partial(self, data: memoryview, heads: NDArray[np.void], rows: NDArray[np.int64]) -> None:
        """Blocks of which some have empty slots."""
        blocks = np.frombuffer(data, "<u2").reshape(-1, _BLOCK_WORDS)[rows, _BODY_WORDS]
        used = (heads["sample_count"][:, None] > _SLOTS).ravel()
        slots = blocks.reshape(-1, _SAMPLE_WORDS)[used]
        begin, end = self._rows, self._rows + len(slots)
        self._rows = end
        self._words[begin:end] = slots
        base_us = np.repeat(heads["time_us"].astype(np.int64), heads["sample_count"])
        self._t_us[begin:end] = base_us + slots[:, _TIME].view("<u4")[:, 0]
        first = heads["first_sample"].astype(np.int64)[:, None]
        self._index[begin:end] = (first + _SLOTS).ravel()[used]
        self._unpack_flags(begin, end)

    def _unpack_flags(self, begin: int, end: int) -> None:
        """Bits 0-3 imu_valid, 4-9 angle_valid, 10-11 switch_open, 12-15 clipped (protocol reference, Sample)."""
        flags = np.ascontiguousarray(self._words[begin:end, _FLAGS], "<u2").view(np.uint8)
        bits = np.unpackbits(flags, bitorder="little").view(np.bool_)
        self._bits[begin:end] = bits.reshape(-1, _FLAG_BITS)
