"""Blocks of a recording that carry the same number: which one is taken.

The logger writes the last seconds before a landing a second time behind the recording, and a card image may hold a
whole recording twice, so most are copies. They are read and compared some at a time.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import BoolArray, IntArray, RecordArray
from tfsat_host.protocol.limits import BLOCK_BYTES

from .blocks import PIECE, look, merge_pieces
from .log_errors import changed_while_read
from .source import CHUNK_BLOCKS, LogSource

_WINDOW = 16384
"""Block numbers that are compared at a time."""
_BEST = np.dtype(
    [("position", "<i8"), ("sample_count", "<i2"), ("crc", "<u4"), ("found", "<i8"), ("same", "<i8")]
)
"""The best block of a number so far, how many have that number, and how many of them are equal to it."""


def take_each_number_once(source: LogSource, pieces: RecordArray) -> tuple[RecordArray, int, int]:
    """Take one block per number of a session: the one with the most samples, then the first of the file.

    Returns:
        The blocks by number, (k,) of PIECE; how many others are equal to one of them; how many are different.

    Raises:
        LogError: the file cannot be read, or is not what it was.
    """
    # By number, then by position: pieces that share numbers become neighbours.
    pieces = pieces[np.lexsort((pieces["position"], pieces["number"]))]
    # Pieces whose numbers no other has are taken unread; only rivals cost time.
    contested = _find_contested(pieces)
    chosen_pieces, pieces = [pieces[~contested]], pieces[contested]
    duplicate = conflicting = 0
    # Windows bound the memory; cut to a window, a rival piece may turn out to be alone there.
    for window in _windows(pieces):
        contested = _find_contested(window)
        chosen_pieces.append(window[~contested])
        if contested.any():
            best, equal, different = _best_of_each_number(source, window[contested])
            chosen_pieces.append(best)
            duplicate += equal
            conflicting += different
    all_taken = np.concatenate(chosen_pieces)
    return merge_pieces(all_taken[np.argsort(all_taken["number"])]), duplicate, conflicting


def _find_contested(pieces: RecordArray) -> BoolArray:
    """Mark the pieces, in the order of their first numbers, that share a number with another."""
    first = pieces["number"]
    end = first + pieces["count"]
    shares = np.zeros(len(pieces), np.bool_)
    # Begins before the furthest end so far, a running maximum: one long piece may span many.
    shares[1:] |= first[1:] < np.maximum.accumulate(end)[:-1]
    # Ends after the next begins: in sorted order the next piece is the nearest rival.
    shares[:-1] |= first[1:] < end[:-1]
    return shares


def _windows(pieces: RecordArray) -> Iterator[RecordArray]:
    """Yield the same blocks in windows of _WINDOW consecutive numbers, cutting pieces that reach further."""
    next_piece, cut = 0, pieces[:0]
    while next_piece < len(pieces) or len(cut):
        # Each window begins at the lowest number left, so that missing ranges cost none.
        end = int(cut["number"][0] if len(cut) else pieces["number"][next_piece]) + _WINDOW
        upto = int(np.searchsorted(pieces["number"], end))
        window = np.concatenate((cut, pieces[next_piece:upto]))
        # Cut what reaches past the window and carry it on, its position advanced by as many blocks.
        beyond = window["number"] + window["count"] - end
        cut = window[beyond > 0]
        window["count"] -= np.maximum(beyond, 0)
        cut["position"] += end - cut["number"]
        cut["count"], cut["number"] = beyond[beyond > 0], end
        next_piece = upto
        yield window


def _best_of_each_number(source: LogSource, rivals: RecordArray) -> tuple[RecordArray, int, int]:
    """Return the best block of each number in a window, and how many others are equal to it or different.

    The file may hold one number any number of times: of each, only the best block so far is kept.
    """
    lowest = int(rivals["number"].min())
    best = np.zeros(_WINDOW, _BEST)
    # Below any real count, so that the first block found of each number becomes the best.
    best["sample_count"] = -1
    for positions, numbers in _in_file_order(rivals):
        counts, crcs = _read(source, positions, numbers)
        which = numbers - lowest
        # Most samples first within each number, then first in the file; np.diff finds each number's head.
        order = np.lexsort((positions, -counts, which))
        first = order[np.flatnonzero(np.diff(which[order], prepend=-1))]
        # Strictly more samples: among equals, the one met first, earlier in the file, stays.
        better = first[counts[first] > best["sample_count"][which[first]]]
        improved = which[better]
        best["position"][improved] = positions[better]
        best["sample_count"][improved], best["crc"][improved] = counts[better], crcs[better]
        # No block before was equal to one with more samples.
        best["same"][improved] = 0
        # Count per number what was found and what agrees with the best so far by its CRC.
        best["found"] += np.bincount(which, minlength=_WINDOW)
        best["same"] += np.bincount(which[crcs == best["crc"][which]], minlength=_WINDOW)
    present = np.flatnonzero(best["found"])
    best = best[present]
    chosen_pieces = np.empty(len(best), PIECE)
    chosen_pieces["position"], chosen_pieces["number"] = best["position"], lowest + present
    chosen_pieces["count"], chosen_pieces["session"] = 1, rivals["session"][0]
    # Each best block is among its own equals: leave it out of the duplicates.
    same = int(best["same"].sum())
    return merge_pieces(chosen_pieces), same - len(best), int(best["found"].sum()) - same


def _in_file_order(pieces: RecordArray) -> Iterator[tuple[IntArray, IntArray]]:
    """Positions and numbers of all blocks of the pieces, by position, CHUNK_BLOCKS at a time."""
    # Enumerate blocks by rank; the cumulative counts give each rank's piece by bisection.
    order = np.argsort(pieces["position"])
    upto = np.cumsum(pieces["count"][order])
    for first in range(0, int(upto[-1]), CHUNK_BLOCKS):
        ranks = np.arange(first, min(first + CHUNK_BLOCKS, int(upto[-1])))
        at = np.searchsorted(upto, ranks, side="right")
        which = order[at]
        inside = ranks - upto[at] + pieces["count"][which]
        yield pieces["position"][which] + inside, pieces["number"][which] + inside


def _read(
    source: LogSource, positions: IntArray, numbers: IntArray
) -> tuple[NDArray[np.int16], NDArray[np.uint32]]:
    """Read the sample count and CRC of each block, which decide between copies.

    Adjacent blocks are read together.
    """
    data = memoryview(bytearray(len(positions) * BLOCK_BYTES))
    cuts = [0, *(np.flatnonzero(np.diff(positions) != 1) + 1).tolist(), len(positions)]
    for begin, end in pairwise(cuts):
        target = data[begin * BLOCK_BYTES : end * BLOCK_BYTES]
        source.read_into(target, int(positions[begin]) * BLOCK_BYTES)
    looked = look(data)
    # All of them were usable in the first pass: anything else now means that the file has changed.
    if not looked.usable.all() or not np.array_equal(looked.heads["block_number"], numbers):
        raise changed_while_read(source.path)
    crcs = np.frombuffer(data, "<u4")[BLOCK_BYTES // 4 - 1 :: BLOCK_BYTES // 4]
    return looked.heads["sample_count"].astype(np.int16), crcs
