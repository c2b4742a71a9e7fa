"""The first pass over a file: what stands where, and, where the file is in good order, its samples at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .blocks import Looked, Unusable, look, look_at_tail
from .pieces import PieceList, as_pieces
from .recordings import Census
from .records import Records, RecordsBuilder
from .source import LogSource

DECODED_AT_ONCE_BYTES = 2 << 30
"""In a larger file the recording is first looked for, so that no memory is reserved for what is not one."""

Progress = Callable[[float], object]


@dataclass(frozen=True, eq=False)
class Survey:
    """What a file holds.

    Attributes:
        pieces: All usable blocks, in the order of the file; (k,) of PIECE.
        unusable: The others, counted.
        census: What was seen of each recording.
        early_pieces: The blocks that were decoded in passing; (j,) of PIECE.
        early_records: What they hold; None if nothing was decoded in passing.
    """

    pieces: NDArray[np.void]
    unusable: Unusable
    census: Census
    early_pieces: NDArray[np.void]
    early_records: Records | None


def survey(source: LogSource, session: int | None, progress: Progress | None = None) -> Survey:
    """Look at every block of the file, and decode in passing what seems to be the recording.

    Args:
        source: The file.
        session: The recording asked for; None for the newest.
        progress: Is given the share of the file that was looked at since the call before.

    Raises:
        LogError: the file cannot be read, or is a jumble.
    """
    pieces, unusable, census = PieceList(source.path), Unusable(), Census()
    early = _EarlyDecoder(source, session) if source.size_bytes <= DECODED_AT_ONCE_BYTES else None
    reached = 0
    for first, data in source.chunks():
        looked = look(data)
        unusable.add(looked.unusable)
        where = np.flatnonzero(looked.usable)
        heads = looked.heads if len(where) == len(looked.heads) else looked.heads.take(where)
        found = as_pieces(where + first, heads)
        pieces.append(found)
        if early is not None and not early.take(first, data, looked, found):
            early = None
        census.add(data, heads, where)
        if progress is not None:
            reached, before = first + len(looked.heads), reached
            progress((reached - before) / source.block_count)
    if progress is not None and source.block_count:
        progress((source.block_count - reached) / source.block_count)
    unusable.never_written += source.blocks_in_holes
    unusable.add(look_at_tail(source.tail()))
    empty = PieceList(source.path).all()
    if early is None:
        return Survey(pieces.all(), unusable, census, empty, None)
    return Survey(pieces.all(), unusable, census, early.pieces.all(), early.builder.records())


class _EarlyDecoder:
    """Decodes the first recording of the file for as long as its blocks come in order.

    Whether that was the right recording, and all of it, is decided afterwards (`assembly`).
    """

    def __init__(self, source: LogSource, session: int | None) -> None:
        self.builder = RecordsBuilder(source.block_count)
        self.pieces = PieceList(source.path)
        self._session = session
        self._asked_for = session is not None
        self._another_began = False
        self._last_number = -1

    def take(self, first: int, data: memoryview, looked: Looked, pieces: NDArray[np.void]) -> bool:
        """Take what continues the recording; False once it is certain that the order is another.

        Args:
            first: Position of the chunk's first block.
            data: The chunk.
            looked: What it is.
            pieces: Its usable blocks.
        """
        if not len(pieces):
            return True
        if self._session is None:
            self._session = int(pieces["session"][0])
        if len(pieces) == 1 and pieces["session"][0] == self._session and not self._another_began:
            if pieces["number"][0] > self._last_number:
                self._take(data, looked.heads, looked.usable, pieces)
            return True
        own = looked.usable & (looked.heads["session"] == self._session)
        numbers = np.where(own, looked.heads["block_number"].astype(np.int64), -1)
        before = np.maximum.accumulate(np.concatenate(([self._last_number], numbers[:-1])))
        new = own & (numbers > before)
        if not self._asked_for:
            others = np.flatnonzero(looked.usable & ~own)
            begins = 0 if self._another_began else others[0] if len(others) else len(new)
            if new[begins:].any():
                return False
            self._another_began = self._another_began or len(others) > 0
        if new.any():
            where = np.flatnonzero(new)
            self._take(data, looked.heads, new, as_pieces(where + first, looked.heads.take(where)))
        return True

    def _take(
        self, data: memoryview, heads: NDArray[np.void], new: NDArray[np.bool_], pieces: NDArray[np.void]
    ) -> None:
        self.pieces.append(pieces)
        self.builder.take(data, heads, new)
        self._last_number = int(pieces["number"][-1] + pieces["count"][-1] - 1)
