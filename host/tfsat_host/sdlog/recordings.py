"""The recordings that a file holds, which of them is the newest, and which blocks it is made of.

Where the time of day does not decide which recording is the newest, its place does: the logger writes a recording
from the start of its file, over whatever an older recording left there. The middle (median) position of its blocks
decides, because a single old block may survive at the very start where a write was lost.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tfsat_host.arrays import IntArray, RecordArray
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.log_layout import HEADER_BYTES

from .copies import take_each_number_once
from .header import MIN_WALL_CLOCK_US, WALL_CLOCK
from .log_errors import LogError, NoBlockError, SessionError
from .source import LogSource

ChosenBy = Literal["only one", "asked for", "header", "time of day", "place"]
MAX_RECORDINGS = 4096
"""Recordings that are looked at one by one; in a file with more the place decides."""
# Of a whole block: the header's payload begins behind the block's head.
_WALL_CLOCK = slice(HEADER_BYTES + WALL_CLOCK.start, HEADER_BYTES + WALL_CLOCK.stop)
_HEADER, _FOOTER = int(BlockKind.HEADER), int(BlockKind.FOOTER)


@dataclass(frozen=True)
class Recording:
    """One recording of a file, by a first look.

    Attributes:
        session: Its random id.
        started_unix_us: Time of day of its first block that is there; None if no header has it.
        samples: In its blocks, second copies counted too.
        blocks: Likewise.
        is_unbroken: Every block from number 0 to the last one is there.
        has_end: A footer is there.
        has_header: A header or a copy of it is there: without one nothing of it can be decoded.
    """

    session: int
    started_unix_us: int | None
    samples: int
    blocks: int
    is_unbroken: bool
    has_end: bool
    has_header: bool


@dataclass(frozen=True)
class SetAside:
    """Blocks of the file that are no part of the recording, by reason.

    Attributes:
        never_written: Zero blocks: room that the logger prepared and did not need.
        torn: Begin like a block of ours; their CRC is wrong. A ragged end of the file is one.
        foreign: Not ours.
        malformed: The CRC is right, the contents impossible.
        newer: The CRC is right, the layout version unknown.
        stale: Undamaged, of the file's other recordings, whole or not.
        duplicate: A second copy of a block that was taken: the logger writes the last seconds twice.
        conflicting: Undamaged, with the number of a block that was taken, and different.
    """

    never_written: int = 0
    torn: int = 0
    foreign: int = 0
    malformed: int = 0
    newer: int = 0
    stale: int = 0
    duplicate: int = 0
    conflicting: int = 0


@dataclass(frozen=True, eq=False)
class Assembly:
    """The blocks of one recording.

    Attributes:
        session: Its random id.
        pieces: Where its blocks stand, by number, each number once; (k,) of PIECE, joined where possible.
        other_sessions: Ids of the file's other recordings, in the order of the file.
        recordings: All of the file, in its order; of very many the first ones.
        chosen_by: Why it was this one.
        set_aside: What was left out.
    """

    session: int
    pieces: RecordArray
    other_sessions: tuple[int, ...]
    recordings: tuple[Recording, ...]
    chosen_by: ChosenBy
    set_aside: SetAside


@dataclass
class _Tally:
    first_number: int
    first_time_us: int
    unix_offset_us: int | None = None
    samples: int = 0
    blocks: int = 0
    has_end: bool = False
    has_header: bool = False


class Census:
    """Counts the blocks of each recording as they are read."""

    def __init__(self) -> None:
        self._tallies: dict[int, _Tally] = {}

    def add(self, data: memoryview, heads: RecordArray, where: IntArray) -> None:
        """Count usable blocks: `heads` are (k,) theirs, `where` (k,) their places in `data`."""
        sessions = heads["session"]
        if not len(sessions):
            return
        # Nearly every chunk holds a single session: spare the sorting then.
        if (sessions == sessions[0]).all():
            self._add(data, heads, where)
            return
        for session in np.unique(sessions):
            own = np.flatnonzero(sessions == session)
            self._add(data, heads.take(own), where[own])

    def recordings(self, sessions: Iterable[int], unbroken: frozenset[int]) -> tuple[Recording, ...]:
        """Return the recordings counted, in the order of `sessions`."""
        return tuple(
            Recording(
                session=session,
                started_unix_us=_start_of(tally),
                samples=tally.samples,
                blocks=tally.blocks,
                is_unbroken=session in unbroken,
                has_end=tally.has_end,
                has_header=tally.has_header,
            )
            for session in sessions
            if (tally := self._tallies.get(session)) is not None
        )

    def _add(self, data: memoryview, heads: RecordArray, where: IntArray) -> None:
        session = int(heads["session"][0])
        first = heads[np.argmin(heads["block_number"])]
        tally = self._tallies.get(session)
        if tally is None:
            # A jumble of sessions must not grow without limit; the place decides among more.
            if len(self._tallies) == MAX_RECORDINGS:
                return
            tally = self._tallies[session] = _Tally(int(first["block_number"]), int(first["time_us"]))
        if first["block_number"] < tally.first_number:
            # The earliest block dates the beginning, wherever it stands in the file.
            tally.first_number, tally.first_time_us = int(first["block_number"]), int(first["time_us"])
        tally.blocks += len(heads)
        tally.samples += int(heads["sample_count"].sum())
        tally.has_end = tally.has_end or bool((heads["kind"] == _FOOTER).any())
        headers = np.flatnonzero(heads["kind"] == _HEADER).tolist()
        tally.has_header = tally.has_header or bool(headers)
        if tally.unix_offset_us is None:
            # The first header with a time of day gives the offset of Unix time from the logger's clock.
            for row in headers:
                block = data[int(where[row]) * BLOCK_BYTES :][:BLOCK_BYTES]
                unix_us = int.from_bytes(block[_WALL_CLOCK], "little")
                if unix_us >= MIN_WALL_CLOCK_US:
                    tally.unix_offset_us = unix_us - int(heads["time_us"][row])
                    break


def _start_of(tally: _Tally) -> int | None:
    return None if tally.unix_offset_us is None else tally.unix_offset_us + tally.first_time_us


def assemble(
    source: LogSource, pieces: RecordArray, unusable: Counter[str], census: Census, session: int | None
) -> Assembly:
    """Choose a recording (`session`, or the newest) and put its blocks in order.

    Args:
        source: The file; read again only where blocks of one number compete.
        pieces: All usable blocks, in the order of the file.
        unusable: The other blocks, counted by reason.
        census: What each recording has.
        session: The recording asked for.

    Raises:
        LogError: the file has no block to choose from, or cannot be read.
        SessionError: it has none of `session`.
    """
    if not len(pieces):
        raise _nothing_found(source, unusable)
    sessions = _sessions_by_position(pieces)
    recordings = census.recordings(sessions, _unbroken_sessions(pieces))
    chosen_by: ChosenBy = "asked for"
    if session is None:
        session, chosen_by = _newest(recordings, counted_all=len(recordings) == len(sessions))
    elif session not in sessions:
        raise SessionError(
            what=f"{source.path} holds no recording {session:08x}.",
            meaning="Nothing was decoded.",
            next_step="Its recordings: " + ", ".join(f"{session_id:08x}" for session_id in sessions),
        )
    own = pieces if len(sessions) == 1 else pieces[pieces["session"] == session]
    unique_pieces, duplicate, conflicting = take_each_number_once(source, own)
    # Whole blocks of other recordings are set aside as stale, not as damage.
    stale = int(pieces["count"].sum() - own["count"].sum())
    set_aside = SetAside(**unusable, stale=stale, duplicate=duplicate, conflicting=conflicting)
    others = tuple(other for other in sessions if other != session)
    return Assembly(session, unique_pieces, others, recordings, chosen_by, set_aside)


def _newest(recordings: Sequence[Recording], counted_all: bool) -> tuple[int, ChosenBy]:
    """Choose the session to decode, and return the criterion that decided.

    The time of day decides if every unbroken recording has one, otherwise the place: a recording is written
    from the start of its file, over what an older one left there. One without a header cannot be decoded and is
    taken only if none has one.

    The recordings, at least one, are by their place in the file; `counted_all`: there are no others.
    """
    if len(recordings) == 1 and counted_all:
        return recordings[0].session, "only one"
    decodable = [candidate for candidate in recordings if candidate.has_header]
    # No scales are known without a header: repeat the choice among those that have one.
    if counted_all and decodable and not recordings[0].has_header:
        session, chosen_by = _newest(decodable, counted_all)
        return session, "header" if chosen_by in ("only one", "place") else chosen_by
    # Undated fragments of older recordings do not veto the time of day; an undated whole one does.
    unbroken = [candidate for candidate in recordings if candidate.is_unbroken and candidate.samples]
    dated = [
        candidate for candidate in recordings if candidate.started_unix_us is not None and candidate.samples
    ]
    if counted_all and unbroken and all(candidate.started_unix_us is not None for candidate in unbroken):
        return max(dated, key=lambda candidate: candidate.started_unix_us or 0).session, "time of day"
    return recordings[0].session, "place"


def _unbroken_sessions(pieces: RecordArray) -> frozenset[int]:
    """Return the sessions of which, among all usable blocks, every block from number 0 to the last one is there."""
    ordered = pieces[np.lexsort((pieces["number"], pieces["session"]))]
    reached: dict[int, int] = {}
    broken: set[int] = set()
    columns = (ordered[name].tolist() for name in ("session", "number", "count"))
    # Sweep each session by number: a piece that begins beyond what is reached leaves a hole.
    for session, number, count in zip(*columns, strict=True):
        reach = reached.get(session, 0)
        if number > reach:
            broken.add(session)
        reached[session] = max(reach, number + count)
    return frozenset(reached.keys() - broken)


def _sessions_by_position(pieces: RecordArray) -> tuple[int, ...]:
    """Return the ids of all recordings, by the median position of their blocks."""
    if (pieces["session"] == pieces["session"][0]).all():
        return (int(pieces["session"][0]),)
    ordered = pieces[np.lexsort((pieces["position"], pieces["session"]))]
    ids, first = np.unique(ordered["session"], return_index=True)
    upto = np.cumsum(ordered["count"])
    # Median block by rank over a session's pieces: a stray old block does not move it.
    before = upto[first] - ordered["count"][first]
    middle = before + (np.append(before[1:], upto[-1]) - before - 1) // 2
    piece = np.searchsorted(upto, middle, side="right")
    # From the rank back to a position inside the piece that holds it.
    median = ordered["position"][piece] + middle - (upto[piece] - ordered["count"][piece])
    return tuple(ids[np.argsort(median, kind="stable")].tolist())


def _nothing_found(source: LogSource, unusable: Counter[str]) -> LogError:
    path = source.path
    # The most telling reason first: a newer layout, a file never used, then damage.
    if unusable["newer"]:
        return LogError(
            f"{path} was recorded with a block layout that this program does not know.",
            "Take the release of tfsat that the logger runs, and in its folder: python -m pip install .",
            "Nothing was decoded; the recording itself is undamaged.",
        )
    if unusable["never_written"] and not unusable["torn"] + unusable["malformed"] + unusable["foreign"]:
        return NoBlockError(
            f"{path} holds {source.size_bytes} zero bytes and no block: "
            "it was prepared for a recording that never began.",
            Advice(
                "Look for another file on the card; before the next drop, ",
                NextStep("status"),
                " must show the logger recording.",
            ),
            "Nothing was recorded in this file.",
        )
    detail = "it holds no block that begins with the log's magic number"
    if unusable["torn"]:
        detail = f"{unusable['torn']} of its blocks look like ours and all of them are damaged"
    elif unusable["malformed"]:
        detail = "its blocks hold impossible values"
    return NoBlockError(
        f"{path} is not a tfsat log: {detail}.",
        "Give a recording off the logger's card (DROP0001.BIN and up), a copy, or an image of the card.",
    )
