"""Where the blocks of recordings stand in a file, as pieces: a recording of hours is a handful of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from . import errors

MOST_PIECES = 1 << 19
"""A log with more of them is refused: it would take more memory than is promised, and no card holds one."""

PIECE = np.dtype([("position", "<i8"), ("number", "<i8"), ("count", "<i8"), ("session", "<u4")])
"""`count` blocks of one session that follow each other both in the file, from block `position` on, and by number."""


class PieceList:
    """Grows in the order of the file."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._done: list[NDArray[np.void]] = []
        self._length = 0

    def append(self, new: NDArray[np.void]) -> None:
        """Append pieces that stand behind all before.

        Raises:
            LogError: there are more than MOST_PIECES.
        """
        if self._done and len(new) and _continues(self._done[-1][-1:], new[:1])[0]:
            self._done[-1]["count"][-1] += new["count"][0]
            new = new[1:]
        if len(new):
            self._done.append(new.copy())
            self._length += len(new)
        if self._length > MOST_PIECES:
            raise errors.too_many_pieces(self._path, MOST_PIECES)

    def all(self) -> NDArray[np.void]:
        """The pieces so far, (k,) of PIECE."""
        if len(self._done) != 1:
            self._done = [np.concatenate([np.empty(0, PIECE), *self._done])]
        return self._done[0]


def as_pieces(positions: NDArray[np.int64], heads: NDArray[np.void]) -> NDArray[np.void]:
    """Blocks, by rising position, as the fewest pieces."""
    blocks = np.empty(len(positions), PIECE)
    blocks["position"], blocks["number"] = positions, heads["block_number"]
    blocks["session"], blocks["count"] = heads["session"], 1
    return joined(blocks)


def joined(pieces: NDArray[np.void]) -> NDArray[np.void]:
    """The same blocks in the same order as fewer pieces, where one continues the piece before it."""
    if len(pieces) < 2:
        return pieces
    first = np.flatnonzero(np.concatenate(([True], ~_continues(pieces[:-1], pieces[1:]))))
    fewer = pieces[first]
    fewer["count"] = np.add.reduceat(pieces["count"], first)
    return fewer


def _continues(before: NDArray[np.void], after: NDArray[np.void]) -> NDArray[np.bool_]:
    follows: NDArray[np.bool_] = (
        (before["session"] == after["session"])
        & (before["position"] + before["count"] == after["position"])
        & (before["number"] + before["count"] == after["number"])
    )
    return follows
