"""Takes samples and events out of a recording's blocks, many blocks at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.limits import BLOCK_BYTES, SAMPLES_PER_BLOCK
from tfsat_host.protocol.log_layout import (
    BLOCK_HEADER_DTYPE,
    DATA_BLOCK_DTYPE,
    EVENT_DTYPE,
    HEADER_BYTES,
    SAMPLE_BYTES,
)

from . import errors
from .source import CHUNK_BLOCKS, LogSource

_BLOCK = np.dtype(DATA_BLOCK_DTYPE)
_HEAD = np.dtype([("head", np.dtype(BLOCK_HEADER_DTYPE)), ("rest", f"V{BLOCK_BYTES - HEADER_BYTES}")])
_WORD_BYTES = 2
_SAMPLE_WORDS = SAMPLE_BYTES // _WORD_BYTES
_FIRST_WORD = HEADER_BYTES // _WORD_BYTES
_BODY_WORDS = slice(_FIRST_WORD, _FIRST_WORD + SAMPLES_PER_BLOCK * _SAMPLE_WORDS)
_TIME, _FLAGS, _IMU, _ANGLE = slice(0, 2), 2, slice(3, 31), slice(31, 37)


@dataclass(frozen=True, eq=False)
class Records:
    """Raw columns of a recording; n samples, b data blocks.

    Attributes:
        index: (n,) int64, number of the sample in the recording, lost ones counted.
        t_us: (n,) int64, the logger's clock, µs since power-up.
        flags: (n,) uint16, validity, switches and clipping (protocol reference, Sample).
        imu: (n, 4, 7) int16, each IMU's accel x y z, temperature, gyro x y z, counts; a view.
        angle: (n, 6) uint16, angle sensors, counts; a view of the same memory.
        events: (e,) records of EVENT_DTYPE, as they stand in the log.
        block_first_sample: (b,) int64.
        block_samples_dropped: (b,) int64.
    """

    index: NDArray[np.int64]
    t_us: NDArray[np.int64]
    flags: NDArray[np.uint16]
    imu: NDArray[np.int16]
    angle: NDArray[np.uint16]
    events: NDArray[np.void]
    block_first_sample: NDArray[np.int64]
    block_samples_dropped: NDArray[np.int64]


def read_records(source: LogSource, entries: NDArray[np.void]) -> Records:
    """Read the data blocks of `entries`, in their order. Raises LogError when the file cannot be read."""
    n = int(entries["sample_count"].sum(dtype=np.int64))
    words = np.empty((n, _SAMPLE_WORDS), np.uint16)
    index = np.empty(n, np.int64)
    t_us = np.empty(n, np.int64)
    heads = np.empty(len(entries), np.dtype(BLOCK_HEADER_DTYPE))
    events = []
    block = row = 0
    for data in _ordered_chunks(source, entries):
        blocks = np.frombuffer(data, _BLOCK)
        if not np.array_equal(blocks["crc"], entries["crc"][block : block + len(blocks)]):
            raise errors.changed_while_read(source.path)
        heads[block : block + len(blocks)] = np.frombuffer(data, _HEAD)["head"]
        block += len(blocks)
        slots, slot_index, base_us = _used_slots(data, blocks)
        rows = slice(row, row + len(slots))
        words[rows] = slots
        index[rows] = slot_index
        np.add(base_us, slots[:, _TIME].view("<u4")[:, 0], out=t_us[rows])
        row = rows.stop
        if blocks["event_count"].any():
            events.append(_used_events(blocks))
    return Records(
        index=index,
        t_us=t_us,
        flags=words[:, _FLAGS].copy(),
        imu=words[:, _IMU].view(np.int16).reshape(n, 4, 7),
        angle=words[:, _ANGLE],
        events=np.concatenate(events) if events else np.empty(0, np.dtype(EVENT_DTYPE)),
        block_first_sample=heads["first_sample"].astype(np.int64),
        block_samples_dropped=heads["samples_dropped"].astype(np.int64),
    )


def _ordered_chunks(source: LogSource, entries: NDArray[np.void]) -> Iterator[memoryview]:
    """Yield the blocks of `entries` in their order, up to CHUNK_BLOCKS at a time; the buffer is reused."""
    buffer = memoryview(bytearray(min(CHUNK_BLOCKS, len(entries)) * BLOCK_BYTES))
    for first in range(0, len(entries), CHUNK_BLOCKS):
        positions = entries["position"][first : first + CHUNK_BLOCKS].astype(np.int64)
        breaks = np.flatnonzero(np.diff(positions) != 1) + 1
        starts = [0, *breaks.tolist(), len(positions)]
        for start, stop in pairwise(starts):
            target = buffer[start * BLOCK_BYTES : stop * BLOCK_BYTES]
            source.read_into(target, int(positions[start]) * BLOCK_BYTES)
        yield buffer[: len(positions) * BLOCK_BYTES]


def _used_slots(
    data: memoryview, blocks: NDArray[np.void]
) -> tuple[NDArray[np.uint16], NDArray[np.int64], NDArray[np.int64]]:
    """The used sample slots of a chunk: (m, 37) words, (m,) sample index, (m,) time of the block, µs."""
    words = np.frombuffer(data, "<u2").reshape(len(blocks), BLOCK_BYTES // _WORD_BYTES)
    slots = words[:, _BODY_WORDS].reshape(-1, _SAMPLE_WORDS)
    slot_number = np.arange(SAMPLES_PER_BLOCK)
    index = (blocks["first_sample"].astype(np.int64)[:, None] + slot_number).ravel()
    base_us = np.repeat(blocks["time_us"].astype(np.int64), SAMPLES_PER_BLOCK)
    if (blocks["sample_count"] == SAMPLES_PER_BLOCK).all():
        return slots, index, base_us
    used = (slot_number < blocks["sample_count"][:, None]).ravel()
    return slots[used], index[used], base_us[used]


def _used_events(blocks: NDArray[np.void]) -> NDArray[np.void]:
    slots = blocks["events"]
    used = np.arange(slots.shape[1]) < blocks["event_count"][:, None]
    events: NDArray[np.void] = slots[used]
    return events
