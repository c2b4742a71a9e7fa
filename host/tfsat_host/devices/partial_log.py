"""A recording that is being fetched: a file beside its place, which the next attempt goes on with.

`NAME.part` has the recording's full size from the beginning. What of it was fetched is told by the blocks
themselves: one whose CRC-32 matches and that names the recording's session was; everything else is asked for
again, zeros included, as they may be room that was never filled. So no list can disagree with the file, and a
computer that lost its power costs no more than what it had not written.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from io import FileIO
from pathlib import Path
from types import TracebackType
from typing import Self

from tfsat_host.devices.log_names import entry_words
from tfsat_host.devices.log_transfer import Span, is_whole, session_of
from tfsat_host.errors import TfsatError
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.messages import LogEntry

_CHUNK_BLOCKS = 2048


def unproven_spans(file: FileIO, entry: LogEntry) -> Iterator[Span]:
    """Spans of a file's blocks of which none proves itself to be the recording's; it has its size.

    The first block is what the listed session was read from. Raises SessionError if it is another's.
    """
    first = count = 0
    chunk = b""
    for index in range(entry.blocks):
        at = index % _CHUNK_BLOCKS * BLOCK_BYTES
        if at == 0:
            chunk = file.read(_CHUNK_BLOCKS * BLOCK_BYTES)
        block = chunk[at : at + BLOCK_BYTES]
        whole = is_whole(block)
        if index == 0 and whole and session_of(block) != entry.session:
            raise SessionError(session_of(block))
        if whole and session_of(block) == entry.session:
            if count:
                yield first, count
            count = 0
        elif count:
            count += 1
        else:
            first, count = index, 1
    if count:
        yield first, count


class SessionError(ValueError):
    """A file begins with a block of another recording; `session` is that one's."""

    def __init__(self, session: int) -> None:
        super().__init__(f"session {session:08x}")
        self.session = session


class PartialLogError(TfsatError):
    """What lies there is the beginning of another recording."""


class PartialLog:
    """`NAME.part`, open to be filled.

    Args:
        target: Where the recording will be.
        entry: The recording, as listed.
        replace: What another recording left there may go.

    Attributes:
        path: `NAME.part`.
        missing: Spans of blocks that are still to be fetched.
        present_blocks: The others, when it was opened.

    Raises:
        PartialLogError: another recording is in it.
    """

    def __init__(self, target: Path, entry: LogEntry, *, replace: bool = False) -> None:
        self._target = target
        self._size = entry.blocks * BLOCK_BYTES
        self.path = target.with_name(f"{target.name}.part")
        target.parent.mkdir(parents=True, exist_ok=True)
        found = self.path.exists()
        # Not buffered: a block counts as kept once the file has it, and a full disk fails here, not at the end.
        self._file: FileIO = self.path.open("r+b" if found else "w+b", buffering=0)
        try:
            self.missing = list(self._look(entry)) if found else self._begin(entry)
        except PartialLogError:
            if not replace:
                self._file.close()
                raise
            self.missing = self._begin(entry)
        self.present_blocks = entry.blocks - sum(count for _, count in self.missing)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    def put(self, index: int, block: bytes) -> None:
        """Puts a block in its place. Raises OSError when the disk is full."""
        self._file.seek(index * BLOCK_BYTES)
        written = 0
        while written < len(block):
            written += self._file.write(block[written:])

    def finish(self) -> str:
        """All blocks are there: gives the file its name once it is on the disk; its SHA-256."""
        os.fsync(self._file.fileno())
        self._file.seek(0)
        digest = hashlib.file_digest(self._file, "sha256").hexdigest()
        self._file.close()
        self.path.replace(self._target)
        return digest

    def _begin(self, entry: LogEntry) -> list[Span]:
        self._file.truncate(0)
        self._file.truncate(self._size)
        return [(0, entry.blocks)] if entry.blocks else []

    def _look(self, entry: LogEntry) -> Iterator[Span]:
        """Spans without a block that proves itself."""
        size = os.fstat(self._file.fileno()).st_size
        if size != self._size:
            raise self._other(f"it has {size} bytes, the recording has {self._size}", entry)
        try:
            yield from unproven_spans(self._file, entry)
        except SessionError as error:
            sessions = f"it has session {error.session:08x}, the recording has {entry.session:08x}"
            raise self._other(sessions, entry) from None

    def _other(self, why: str, entry: LogEntry) -> PartialLogError:
        return PartialLogError(
            what=f"{self.path} is the beginning of another recording than {entry_words(entry)}: {why}.",
            meaning="Nothing was fetched; the file is as it was.",
            next_step=f"Delete {self.path} if it is of no use, name another place with --out, or add --force.",
        )
