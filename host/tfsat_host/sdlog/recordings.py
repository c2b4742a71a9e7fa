"""The recordings that a file holds, and which of them is the newest."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.log_layout import HEADER_BYTES

from .header import WALL_CLOCK

ChosenBy = Literal["only one", "asked for", "time of day", "place"]
MOST_COUNTED = 4096
"""Recordings that are looked at one by one; in a file with more the place decides."""
_WALL_CLOCK = slice(HEADER_BYTES + WALL_CLOCK.start, HEADER_BYTES + WALL_CLOCK.stop)
_HEADER, _FOOTER = int(BlockKind.HEADER), int(BlockKind.FOOTER)


@dataclass(frozen=True)
class Recording:
    """One recording of a file, by a first look.

    Attributes:
        session: Its random id.
        started_unix_us: Time of day of its first block that is there; None if no header tells it.
        samples: In its blocks, second copies counted too.
        blocks: Likewise.
        is_unbroken: Every block from number 0 to the last one is there.
        has_end: A footer is there.
    """

    session: int
    started_unix_us: int | None
    samples: int
    blocks: int
    is_unbroken: bool
    has_end: bool


@dataclass
class _Tally:
    first_number: int
    first_time_us: int
    unix_offset_us: int | None = None
    samples: int = 0
    blocks: int = 0
    has_end: bool = False


class Census:
    """Counts the blocks of each recording as they are read."""

    def __init__(self) -> None:
        self._tallies: dict[int, _Tally] = {}

    def add(self, data: memoryview, heads: NDArray[np.void], where: NDArray[np.int64]) -> None:
        """Count usable blocks: `heads` are (k,) theirs, `where` (k,) their places in `data`."""
        sessions = heads["session"]
        if not len(sessions):
            return
        if (sessions == sessions[0]).all():
            self._add(data, heads, where)
            return
        for session in np.unique(sessions):
            own = np.flatnonzero(sessions == session)
            self._add(data, heads.take(own), where[own])

    def recordings(self, sessions: Iterable[int], unbroken: frozenset[int]) -> tuple[Recording, ...]:
        """What was counted, in the order of `sessions`."""
        return tuple(
            Recording(
                session=session,
                started_unix_us=_started(tally),
                samples=tally.samples,
                blocks=tally.blocks,
                is_unbroken=session in unbroken,
                has_end=tally.has_end,
            )
            for session in sessions
            if (tally := self._tallies.get(session)) is not None
        )

    def _add(self, data: memoryview, heads: NDArray[np.void], where: NDArray[np.int64]) -> None:
        session = int(heads["session"][0])
        first = heads[np.argmin(heads["block_number"])]
        tally = self._tallies.get(session)
        if tally is None:
            if len(self._tallies) == MOST_COUNTED:
                return
            tally = self._tallies[session] = _Tally(int(first["block_number"]), int(first["time_us"]))
        if first["block_number"] < tally.first_number:
            tally.first_number, tally.first_time_us = int(first["block_number"]), int(first["time_us"])
        tally.blocks += len(heads)
        tally.samples += int(heads["sample_count"].sum())
        tally.has_end = tally.has_end or bool((heads["kind"] == _FOOTER).any())
        if tally.unix_offset_us is None:
            for row in np.flatnonzero(heads["kind"] == _HEADER).tolist():
                block = data[int(where[row]) * BLOCK_BYTES :][:BLOCK_BYTES]
                unix_us = int.from_bytes(block[_WALL_CLOCK], "little")
                if unix_us:
                    tally.unix_offset_us = unix_us - int(heads["time_us"][row])
                    break


def _started(tally: _Tally) -> int | None:
    return None if tally.unix_offset_us is None else tally.unix_offset_us + tally.first_time_us


def newest(recordings: Sequence[Recording], counted_all: bool) -> tuple[int, ChosenBy]:
    """The session to decode, and what decided.

    The time of day does where every unbroken recording has one. Otherwise the place: a recording is
    written from the start of its file, over what an older one left there.

    Args:
        recordings: By their place in the file; at least one.
        counted_all: There are no others.
    """
    if len(recordings) == 1 and counted_all:
        return recordings[0].session, "only one"
    unbroken = [one for one in recordings if one.is_unbroken and one.samples]
    dated = [one for one in recordings if one.started_unix_us is not None and one.samples]
    if counted_all and unbroken and all(one.started_unix_us is not None for one in unbroken):
        return max(dated, key=lambda one: one.started_unix_us or 0).session, "time of day"
    return recordings[0].session, "place"


def unbroken_sessions(pieces: NDArray[np.void]) -> frozenset[int]:
    """The sessions of which every block from number 0 to the last one is there.

    Args:
        pieces: All usable blocks; (k,) of PIECE.
    """
    ordered = pieces[np.lexsort((pieces["number"], pieces["session"]))]
    reached: dict[int, int] = {}
    broken: set[int] = set()
    columns = (ordered[name].tolist() for name in ("session", "number", "count"))
    for session, number, count in zip(*columns, strict=True):
        reach = reached.get(session, 0)
        if number > reach:
            broken.add(session)
        reached[session] = max(reach, number + count)
    return frozenset(reached.keys() - broken)
