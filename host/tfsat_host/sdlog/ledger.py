"""Follows the numbers that a recording's blocks carry, and notes where they do not go on as they should."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.enums import BlockKind

from .blocks import HEAD

_BATCH_BLOCKS = 16384
_DATA = int(BlockKind.DATA)
_HEAD_WORDS = HEAD.itemsize // 8
BREAK = np.dtype(
    [
        ("row", "<i8"),
        ("after_sample", "<i8"),
        ("samples", "<i8"),
        ("samples_dropped", "<i8"),
        ("blocks", "<i8"),
    ]
)
"""Before sample row `row`, after sample number `after_sample`: how much is missing, and how much of it was dropped."""


@dataclass(frozen=True, eq=False)
class Account:
    """What the numbers of a recording's blocks say.

    Attributes:
        breaks: Where something is missing before a data block, (k,) of BREAK.
        overlaps: Data blocks that begin before the one before them ends.
        drops_taken_back: Data blocks that count fewer dropped samples than the one before.
        samples_end: Number after the last sample.
        samples_dropped: As the last data block counts them.
        most_samples_dropped: As any data block counts them.
        blocks_missing_at_end: Behind the last data block.
        block_count: Blocks of the recording that are there.
        last_number: Of the last block.
    """

    breaks: NDArray[np.void]
    overlaps: int
    drops_taken_back: int
    samples_end: int
    samples_dropped: int
    most_samples_dropped: int
    blocks_missing_at_end: int
    block_count: int
    last_number: int


class Ledger:
    """Takes the heads of a recording's blocks by number; what it keeps does not grow with them."""

    def __init__(self) -> None:
        self._waiting = np.empty((_BATCH_BLOCKS, _HEAD_WORDS), np.uint64)
        self._waiting_count = 0
        self._breaks: list[NDArray[np.void]] = []
        self._overlaps = self._drops_taken_back = 0
        self._blocks = self._rows = self._absent = self._absent_at_data = 0
        self._end = self._dropped = self._most_dropped = 0
        self._last_number = -1

    def add(self, heads: NDArray[np.void]) -> None:
        """Append blocks, their numbers rising."""
        words = heads.view(np.uint64).reshape(-1, _HEAD_WORDS)
        while len(words):
            fitting = words[: _BATCH_BLOCKS - self._waiting_count]
            self._waiting[self._waiting_count : self._waiting_count + len(fitting)] = fitting
            self._waiting_count += len(fitting)
            words = words[len(fitting) :]
            if self._waiting_count == _BATCH_BLOCKS:
                self._settle()

    def account(self) -> Account:
        """What is known when all blocks have been added."""
        self._settle()
        return Account(
            breaks=np.concatenate([np.empty(0, BREAK), *self._breaks]),
            overlaps=self._overlaps,
            drops_taken_back=self._drops_taken_back,
            samples_end=self._end,
            samples_dropped=self._dropped,
            most_samples_dropped=self._most_dropped,
            blocks_missing_at_end=self._absent - self._absent_at_data,
            block_count=self._blocks,
            last_number=self._last_number,
        )

    def _settle(self) -> None:
        heads = self._waiting[: self._waiting_count].view(HEAD)[:, 0]
        self._waiting_count = 0
        if not len(heads):
            return
        numbers = heads["block_number"].astype(np.int64)
        absent = numbers - np.arange(self._blocks, self._blocks + len(heads))
        is_data = heads["kind"] == _DATA
        if is_data.any():
            self._settle_data(heads.take(np.flatnonzero(is_data)), absent[is_data])
        self._blocks += len(heads)
        self._absent, self._last_number = int(absent[-1]), int(numbers[-1])

    def _settle_data(self, heads: NDArray[np.void], absent: NDArray[np.int64]) -> None:
        first, counts = heads["first_sample"].astype(np.int64), heads["sample_count"].astype(np.int64)
        dropped = heads["samples_dropped"].astype(np.int64)
        end = first + counts
        end_before = np.concatenate(([self._end], end[:-1]))
        samples = first - end_before
        blocks = np.diff(absent, prepend=self._absent_at_data)
        newly_dropped = np.diff(dropped, prepend=self._dropped)
        row = self._rows + np.cumsum(counts) - counts
        where = np.flatnonzero((blocks > 0) | (samples > 0))
        if len(where):
            breaks = np.empty(len(where), BREAK)
            breaks["row"], breaks["after_sample"] = row[where], end_before[where] - 1
            breaks["samples"], breaks["blocks"] = samples[where], blocks[where]
            breaks["samples_dropped"] = newly_dropped[where]
            self._breaks.append(breaks)
        self._overlaps += int(np.count_nonzero(samples < 0))
        self._drops_taken_back += int(np.count_nonzero(newly_dropped < 0))
        self._rows += int(counts.sum())
        self._absent_at_data = int(absent[-1])
        self._end, self._dropped = int(end[-1]), int(dropped[-1])
        self._most_dropped = max(self._most_dropped, int(dropped.max()))
