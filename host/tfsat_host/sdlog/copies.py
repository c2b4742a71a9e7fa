"""Blocks of a recording that carry the same number: which one is taken.

The logger writes the last seconds before a landing a second time behind the recording, and a card image
may hold a whole recording twice, so most are copies. They are compared some at a time.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.limits import BLOCK_BYTES

from . import errors
from .blocks import look
from .pieces import PIECE, joined
from .source import CHUNK_BLOCKS, LogSource

_NUMBERS_AT_A_TIME = 16384
_CANDIDATE = np.dtype([("position", "<i8"), ("number", "<i8"), ("sample_count", "u1"), ("crc", "<u4")])


@dataclass(frozen=True, eq=False)
class Taken:
    """Each number of a recording once.

    Attributes:
        pieces: By number, (k,) of PIECE.
        duplicate: Blocks equal to one that was taken.
        conflicting: Blocks with the number of one that was taken, and different.
    """

    pieces: NDArray[np.void]
    duplicate: int
    conflicting: int


def take_each_number_once(source: LogSource, pieces: NDArray[np.void]) -> Taken:
    """Of blocks with one number take the one with the most samples, then the first of the file.

    Raises:
        LogError: the file cannot be read, or is not what it was.
    """
    pieces = pieces[np.lexsort((pieces["position"], pieces["number"]))]
    cuts, contested = _contested(pieces)
    if not len(cuts):
        return Taken(joined(pieces), 0, 0)
    parts = _cut(pieces, cuts)
    stretch = np.searchsorted(cuts, parts["number"], side="right")
    compete = contested[stretch]
    settled = [parts[~compete]]
    duplicate = conflicting = 0
    for rivals in _batches(parts[compete], stretch[compete]):
        best, again, different = _settle(source, rivals)
        settled.append(best)
        duplicate += again
        conflicting += different
    taken = np.concatenate(settled)
    return Taken(joined(taken[np.argsort(taken["number"], kind="stable")]), duplicate, conflicting)


def _contested(pieces: NDArray[np.void]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Numbers at which to cut, and whether numbers from each cut on occur twice.

    Contested stretches are cut again where they are longer than can be compared at a time. The second
    array has one item more: what holds before the first cut.
    """
    start = pieces["number"]
    end = start + pieces["count"]
    reach = np.maximum.accumulate(end)
    twice = np.flatnonzero(start[1:] < reach[:-1])
    if not len(twice):
        return np.empty(0, np.int64), np.zeros(1, np.bool_)
    low, high = start[1:][twice], np.minimum(end[1:], reach[:-1])[twice]
    apart = np.flatnonzero(np.concatenate(([True], low[1:] > np.maximum.accumulate(high)[:-1])))
    low, high = low[apart], np.maximum.reduceat(high, apart)
    inner = [
        np.arange(a + _NUMBERS_AT_A_TIME, b, _NUMBERS_AT_A_TIME)
        for a, b in zip(low.tolist(), high.tolist(), strict=True)
        if b - a > _NUMBERS_AT_A_TIME
    ]
    begins = np.concatenate([low, *inner])
    cuts, at = np.unique(np.concatenate([begins, high]), return_index=True)
    # Where one stretch ends and another begins, the beginning counts: it stands first.
    return cuts, np.concatenate(([False], at < len(begins)))


def _cut(pieces: NDArray[np.void], cuts: NDArray[np.int64]) -> NDArray[np.void]:
    """The same blocks in pieces that no cut divides."""
    start = pieces["number"]
    end = start + pieces["count"]
    first = np.searchsorted(cuts, start, side="right")
    inside = np.searchsorted(cuts, end, side="left") - first
    parts = np.repeat(pieces, inside + 1)
    which = np.arange(len(parts)) - np.repeat(np.cumsum(inside + 1) - inside - 1, inside + 1)
    cut = np.repeat(first, inside + 1) + which
    padded = np.append(cuts, 0)
    low = np.where(which > 0, padded[cut - 1], parts["number"])
    high = np.where(which < np.repeat(inside, inside + 1), padded[cut], parts["number"] + parts["count"])
    parts["position"] += low - parts["number"]
    parts["number"] = low
    parts["count"] = high - low
    return parts


def _batches(parts: NDArray[np.void], stretch: NDArray[np.int64]) -> Iterator[NDArray[np.void]]:
    """All parts of a stretch between two cuts together, several short stretches at a time."""
    order = np.argsort(stretch, kind="stable")
    parts, stretch = parts[order], stretch[order]
    upto = np.cumsum(parts["count"])
    ends = np.append(np.flatnonzero(np.diff(stretch)) + 1, len(parts))
    begin = 0
    while begin < len(parts):
        room = (upto[begin - 1] if begin else 0) + 2 * _NUMBERS_AT_A_TIME
        fitting = int(np.searchsorted(upto[ends - 1], room, side="right"))
        at_least = int(np.searchsorted(ends, begin, side="right")) + 1
        end = int(ends[max(fitting, at_least) - 1])
        yield parts[begin:end]
        begin = end


def _settle(source: LogSource, rivals: NDArray[np.void]) -> tuple[NDArray[np.void], int, int]:
    """The blocks to take, and how many are equal to one of them or different."""
    blocks = np.concatenate([_candidates(source, part) for part in rivals])
    order = np.lexsort((blocks["position"], -blocks["sample_count"].astype(np.int16), blocks["number"]))
    blocks = blocks[order]
    again = np.concatenate(([False], blocks["number"][1:] == blocks["number"][:-1]))
    best = blocks[~again]
    same = best["crc"][np.cumsum(~again) - 1] == blocks["crc"]
    blocks_taken = np.empty(len(best), PIECE)
    blocks_taken["position"], blocks_taken["number"] = best["position"], best["number"]
    blocks_taken["count"], blocks_taken["session"] = 1, rivals["session"][0]
    return (
        joined(blocks_taken),
        int(np.count_nonzero(again & same)),
        int(np.count_nonzero(again & ~same)),
    )


def _candidates(source: LogSource, part: np.void) -> NDArray[np.void]:
    """What decides between blocks, of each block of a piece; (n,) of _CANDIDATE."""
    found = np.empty(int(part["count"]), _CANDIDATE)
    found["position"] = np.arange(part["position"], part["position"] + part["count"])
    found["number"] = np.arange(part["number"], part["number"] + part["count"])
    for first in range(0, len(found), CHUNK_BLOCKS):
        rows = found[first : first + CHUNK_BLOCKS]
        data = source.read_blocks(int(rows["position"][0]), len(rows))
        looked = look(data)
        numbers_as_before = np.array_equal(looked.heads["block_number"], rows["number"])
        if not looked.usable.all() or not numbers_as_before:
            raise errors.changed_while_read(source.path)
        rows["sample_count"] = looked.heads["sample_count"]
        rows["crc"] = np.frombuffer(data, "<u4")[BLOCK_BYTES // 4 - 1 :: BLOCK_BYTES // 4]
    return found
