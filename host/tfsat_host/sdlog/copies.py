"""Blocks of a recording that carry the same number: which one is taken.

The logger writes the last seconds before a landing a second time behind the recording, and a card image
may hold a whole recording twice, so most are copies. They are compared some at a time.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.limits import BLOCK_BYTES

from .blocks import PIECE, joined, look
from .errors import changed_while_read
from .source import CHUNK_BLOCKS, LogSource

_NUMBERS_AT_A_TIME = 16384
_BEST = np.dtype(
    [
        ("number", "<i8"),
        ("position", "<i8"),
        ("sample_count", "<i2"),
        ("crc", "<u4"),
        ("found", "<i8"),
        ("same", "<i8"),
    ]
)
"""The best block of a number so far, how many have that number, and how many like it."""


def take_each_number_once(source: LogSource, pieces: NDArray[np.void]) -> tuple[NDArray[np.void], int, int]:
    """Of blocks with one number take the one with the most samples, then the first of the file.

    Args:
        source: The file.
        pieces: As they stand in it.

    Returns:
        The blocks by number, (k,) of PIECE; how many others are equal to one of them; how many are different.

    Raises:
        LogError: the file cannot be read, or is not what it was.
    """
    if (pieces["number"][1:] < pieces["number"][:-1]).any():
        pieces = pieces[np.lexsort((pieces["position"], pieces["number"]))]
    cuts, contested = _contested(pieces)
    if not len(cuts):
        return joined(pieces), 0, 0
    parts = _cut(pieces, cuts)
    del pieces
    stretch = np.searchsorted(cuts, parts["number"], side="right")
    compete = contested[stretch]
    settled = [parts[~compete]]
    parts, stretch = parts[compete], stretch[compete]
    duplicate = conflicting = 0
    for rivals in _batches(parts, stretch):
        best, again, different = _settle(source, rivals)
        settled.append(best)
        duplicate += again
        conflicting += different
    taken = np.concatenate(settled)
    return joined(taken[np.argsort(taken["number"], kind="stable")]), duplicate, conflicting


def _contested(pieces: NDArray[np.void]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Numbers at which to cut, and whether numbers from each cut on occur twice.

    Contested stretches are cut again where they are longer than can be compared at a time. The second
    array has one item more: what holds before the first cut.
    """
    pieces = _two_of_each(pieces)
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


def _two_of_each(pieces: NDArray[np.void]) -> NDArray[np.void]:
    """Without the third and further pieces of the same numbers: two contest them as well."""
    again = (pieces["number"][1:] == pieces["number"][:-1]) & (pieces["count"][1:] == pieces["count"][:-1])
    return pieces[~np.concatenate(([False, False], again[1:] & again[:-1]))[: len(pieces)]]


def _cut(pieces: NDArray[np.void], cuts: NDArray[np.int64]) -> NDArray[np.void]:
    """The same blocks in pieces that no cut divides."""
    first = np.searchsorted(cuts, pieces["number"], side="right")
    inside = np.searchsorted(cuts, pieces["number"] + pieces["count"], side="left") - first
    divided = np.flatnonzero(inside > 0)
    whole, first, inside = pieces[divided], first[divided], inside[divided]
    parts = np.repeat(whole, inside + 1)
    which = np.arange(len(parts)) - np.repeat(np.cumsum(inside + 1) - inside - 1, inside + 1)
    cut = np.repeat(first, inside + 1) + which
    padded = np.append(cuts, 0)
    low = np.where(which > 0, padded[cut - 1], parts["number"])
    high = np.where(which < np.repeat(inside, inside + 1), padded[cut], parts["number"] + parts["count"])
    parts["position"] += low - parts["number"]
    parts["number"] = low
    parts["count"] = high - low
    cut_up = np.concatenate((pieces, parts[which > 0]))
    cut_up[divided] = parts[which == 0]
    return cut_up


def _batches(parts: NDArray[np.void], stretch: NDArray[np.int64]) -> Iterator[NDArray[np.void]]:
    """All parts of a stretch between two cuts together, several short stretches at a time."""
    if (stretch[1:] < stretch[:-1]).any():
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
    """The blocks to take, and how many are equal to one of them or different.

    The file may hold one number any number of times: of each, only the best block so far is kept.
    """
    best = _one_each(rivals)
    for positions, numbers in _in_file_order(rivals):
        counts, crcs = _read(source, positions, numbers)
        at = np.searchsorted(best["number"], numbers)
        order = np.lexsort((positions, -counts, at))
        first = order[np.flatnonzero(np.diff(at[order], prepend=-1))]
        better = first[counts[first] > best["sample_count"][at[first]]]
        better_at = at[better]
        best["position"][better_at] = positions[better]
        best["sample_count"][better_at] = counts[better]
        best["crc"][better_at] = crcs[better]
        # No block before was equal to one with more samples.
        best["same"][better_at] = 0
        np.add.at(best["found"], at, 1)
        np.add.at(best["same"], at[crcs == best["crc"][at]], 1)
    taken = np.empty(len(best), PIECE)
    taken["position"], taken["number"] = best["position"], best["number"]
    taken["count"], taken["session"] = 1, rivals["session"][0]
    same = int(best["same"].sum())
    return joined(taken), same - len(best), int(best["found"].sum()) - same


def _one_each(parts: NDArray[np.void]) -> NDArray[np.void]:
    """A place for the best block of each number, by number; (n,) of _BEST, none found yet."""
    parts = _two_of_each(parts)
    parts = parts[np.argsort(parts["number"], kind="stable")]
    low = parts["number"]
    reach = np.maximum.accumulate(low + parts["count"])
    apart = np.flatnonzero(np.concatenate(([True], low[1:] > reach[:-1])))
    high = reach[np.append(apart[1:], len(parts)) - 1]
    numbers = [np.arange(a, b) for a, b in zip(low[apart].tolist(), high.tolist(), strict=True)]
    best = np.zeros(int((high - low[apart]).sum()), _BEST)
    best["number"] = np.concatenate(numbers)
    best["sample_count"] = -1
    return best


def _in_file_order(parts: NDArray[np.void]) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Positions and numbers of all blocks of the parts, by position, CHUNK_BLOCKS at a time."""
    order = np.argsort(parts["position"])
    upto = np.cumsum(parts["count"][order])
    for first in range(0, int(upto[-1]), CHUNK_BLOCKS):
        ranks = np.arange(first, min(first + CHUNK_BLOCKS, int(upto[-1])))
        at = np.searchsorted(upto, ranks, side="right")
        which = order[at]
        inside = ranks - upto[at] + parts["count"][which]
        yield parts["position"][which] + inside, parts["number"][which] + inside


def _read(
    source: LogSource, positions: NDArray[np.int64], numbers: NDArray[np.int64]
) -> tuple[NDArray[np.int16], NDArray[np.uint32]]:
    """What decides between blocks: how many samples each has, and its CRC. Neighbours are read together."""
    data = memoryview(bytearray(len(positions) * BLOCK_BYTES))
    cuts = [0, *(np.flatnonzero(np.diff(positions) != 1) + 1).tolist(), len(positions)]
    for begin, end in pairwise(cuts):
        target = data[begin * BLOCK_BYTES : end * BLOCK_BYTES]
        source.read_into(target, int(positions[begin]) * BLOCK_BYTES)
    looked = look(data)
    if not looked.usable.all() or not np.array_equal(looked.heads["block_number"], numbers):
        raise changed_while_read(source.path)
    crcs = np.frombuffer(data, "<u4")[BLOCK_BYTES // 4 - 1 :: BLOCK_BYTES // 4]
    return looked.heads["sample_count"].astype(np.int16), crcs
