"""Which blocks of a file make up one recording, in order.

The logger writes a recording from the start of its file, over whatever an older recording left there.
So the recording whose blocks stand first is the newest; the middle (median) position decides, because
a single old block may survive at the very start where a write was lost.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from . import errors
from .blocks import BlockIndex


@dataclass(frozen=True)
class SetAside:
    """Blocks of the file that are no part of the recording, by reason.

    Attributes:
        never_written: Zero blocks: room that the logger prepared and did not need.
        torn: Begin like a block of ours; their CRC is wrong. A ragged end of the file is one.
        foreign: Not ours.
        malformed: The CRC is right, the contents impossible.
        newer: The CRC is right, the layout version unknown.
        stale: Undamaged, of another recording.
        duplicate: A second copy of a block that was taken.
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
        entries: Its blocks, by number, each number once; fields as in `BlockIndex`.
        other_sessions: Ids of the file's other recordings, as they stand in the file.
        set_aside: What was left out.
    """

    session: int
    entries: NDArray[np.void]
    other_sessions: tuple[int, ...]
    set_aside: SetAside


def assemble(index: BlockIndex, path: Path, size_bytes: int, session: int | None) -> Assembly:
    """Choose a recording (`session`, or the newest) and put its blocks in order.

    Raises:
        LogError: the file has no block to choose from.
        SessionError: it has none of `session`.
    """
    entries = index.entries
    if not len(entries):
        raise _nothing_found(index, path, size_bytes)
    sessions = _sessions_by_position(entries)
    if session is None:
        session = sessions[0]
    elif session not in sessions:
        raise errors.no_such_session(path, session, sessions)
    own = entries if len(sessions) == 1 else entries[entries["session"] == session]
    if np.any(own["number"][1:] <= own["number"][:-1]):
        own = own[np.lexsort((own["position"], -own["sample_count"].astype(np.int16), own["number"]))]
    again = np.zeros(len(own), np.bool_)
    again[1:] = own["number"][1:] == own["number"][:-1]
    taken = own[~again]
    same = taken["crc"][np.cumsum(~again) - 1] == own["crc"]
    set_aside = SetAside(
        never_written=index.never_written,
        torn=index.torn,
        foreign=index.foreign,
        malformed=index.malformed,
        newer=index.newer,
        stale=len(entries) - len(own),
        duplicate=int(np.count_nonzero(again & same)),
        conflicting=int(np.count_nonzero(again & ~same)),
    )
    others = tuple(other for other in sessions if other != session)
    return Assembly(session, taken, others, set_aside)


def _sessions_by_position(entries: NDArray[np.void]) -> tuple[int, ...]:
    """The ids of all recordings, by the median position of their blocks."""
    ids: NDArray[np.uint32] = np.unique(entries["session"])
    if len(ids) == 1:
        return (int(ids[0]),)
    order = np.lexsort((entries["position"], entries["session"]))
    _, first, count = np.unique(entries["session"][order], return_index=True, return_counts=True)
    median = entries["position"][order[first + (count - 1) // 2]]
    return tuple(ids[np.argsort(median, kind="stable")].tolist())


def _nothing_found(index: BlockIndex, path: Path, size_bytes: int) -> errors.LogError:
    if index.newer:
        return errors.newer_version(path)
    if index.torn:
        return errors.no_blocks(
            path, f"{index.torn} of its blocks look like ours and all of them are damaged"
        )
    if index.malformed:
        return errors.no_blocks(path, "its blocks hold impossible values")
    if index.never_written and not index.foreign:
        return errors.never_written(path, size_bytes)
    return errors.no_blocks(path, "it holds no block that begins with the log's magic number")
