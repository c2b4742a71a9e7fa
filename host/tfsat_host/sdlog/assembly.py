"""Which blocks of a file make up one recording, in order.

Where the time of day does not tell the newest recording (see `recordings`), its place does: the logger
writes a recording from the start of its file, over whatever an older recording left there. The middle
(median) position of its blocks decides, because a single old block may survive at the very start where
a write was lost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import errors
from .blocks import Unusable
from .copies import take_each_number_once
from .recordings import Census, ChosenBy, Recording, newest, unbroken_sessions
from .source import LogSource


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
        other_sessions: Ids of the file's other recordings, as they stand in the file.
        recordings: All of the file, as they stand in it; of very many the first ones.
        chosen_by: Why it was this one.
        set_aside: What was left out.
    """

    session: int
    pieces: NDArray[np.void]
    other_sessions: tuple[int, ...]
    recordings: tuple[Recording, ...]
    chosen_by: ChosenBy
    set_aside: SetAside


def assemble(
    source: LogSource, pieces: NDArray[np.void], unusable: Unusable, census: Census, session: int | None
) -> Assembly:
    """Choose a recording (`session`, or the newest) and put its blocks in order.

    Args:
        source: The file; read again only where blocks of one number compete.
        pieces: All usable blocks, as they stand in the file.
        unusable: The other blocks, counted.
        census: What was seen of each recording.
        session: The recording asked for.

    Raises:
        LogError: the file has no block to choose from, or cannot be read.
        SessionError: it has none of `session`.
    """
    if not len(pieces):
        raise _nothing_found(source, unusable)
    sessions = _sessions_by_position(pieces)
    recordings = census.recordings(sessions, unbroken_sessions(pieces))
    chosen_by: ChosenBy = "asked for"
    if session is None:
        session, chosen_by = newest(recordings, counted_all=len(recordings) == len(sessions))
    elif session not in sessions:
        raise errors.no_such_session(source.path, session, sessions)
    own = pieces[pieces["session"] == session]
    taken = take_each_number_once(source, own)
    set_aside = SetAside(
        never_written=unusable.never_written,
        torn=unusable.torn,
        foreign=unusable.foreign,
        malformed=unusable.malformed,
        newer=unusable.newer,
        stale=int(pieces["count"].sum() - own["count"].sum()),
        duplicate=taken.duplicate,
        conflicting=taken.conflicting,
    )
    others = tuple(other for other in sessions if other != session)
    return Assembly(session, taken.pieces, others, recordings, chosen_by, set_aside)


def _sessions_by_position(pieces: NDArray[np.void]) -> tuple[int, ...]:
    """The ids of all recordings, by the median position of their blocks."""
    if (pieces["session"] == pieces["session"][0]).all():
        return (int(pieces["session"][0]),)
    ordered = pieces[np.lexsort((pieces["position"], pieces["session"]))]
    ids, first = np.unique(ordered["session"], return_index=True)
    upto = np.cumsum(ordered["count"])
    before = upto[first] - ordered["count"][first]
    middle = before + (np.append(before[1:], upto[-1]) - before - 1) // 2
    piece = np.searchsorted(upto, middle, side="right")
    median = ordered["position"][piece] + middle - (upto[piece] - ordered["count"][piece])
    return tuple(ids[np.argsort(median, kind="stable")].tolist())


def _nothing_found(source: LogSource, unusable: Unusable) -> errors.LogError:
    path = source.path
    if unusable.newer:
        return errors.newer_version(path)
    if unusable.torn:
        return errors.no_blocks(
            path, f"{unusable.torn} of its blocks look like ours and all of them are damaged"
        )
    if unusable.malformed:
        return errors.no_blocks(path, "its blocks hold impossible values")
    if unusable.never_written and not unusable.foreign:
        return errors.never_written(path, source.size_bytes)
    return errors.no_blocks(path, "it holds no block that begins with the log's magic number")
