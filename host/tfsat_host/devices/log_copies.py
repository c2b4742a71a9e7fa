"""Recordings as files of this computer: partial ones, fetched ones, and files that are one under another name.

A recording that is being fetched is a file next to its place, which the next attempt goes on with. `NAME.part` has the
recording's full size from the beginning. The blocks themselves show what of it was fetched: one whose CRC-32
matches and that names the recording's session was; everything else is asked for again, zeros included, as they may be
room that was never filled. So no list can disagree with the file, and a computer that lost its power costs no more than
what it had not written.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from io import FileIO
from pathlib import Path
from types import TracebackType
from typing import Self

from tfsat_host.devices.log_transfer import Span, entry_words, is_whole, session_of
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import sha256_of
from tfsat_host.json_values import parse_dataclass
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.messages import LogEntry
from tfsat_host.user_folders import NoUserFolder, state_folder
from tfsat_host.whole_file import flush_to_disk, write_whole

_CHUNK_BLOCKS = 2048


def _unproven_spans(file: FileIO, entry: LogEntry) -> Iterator[Span]:
    """Spans of a file's blocks of which none proves itself to be the recording's; it has its size.

    The first block is what the listed session was read from. Raises _OtherSession if it is another's.
    """
    first = count = 0
    chunk = b""
    for index in range(entry.blocks):
        at = index % _CHUNK_BLOCKS * BLOCK_BYTES
        if at == 0:
            chunk = file.read(_CHUNK_BLOCKS * BLOCK_BYTES)
        block = chunk[at : at + BLOCK_BYTES]
        is_intact = is_whole(block)
        if index == 0 and is_intact and session_of(block) != entry.session:
            # The listed session was read from this very block: here lies another recording.
            raise _OtherSession(session_of(block))
        # A block that proves itself ends a span of doubtful ones; empty and torn blocks extend it.
        if is_intact and session_of(block) == entry.session:
            if count:
                yield first, count
            count = 0
        elif count:
            count += 1
        else:
            first, count = index, 1
    if count:
        yield first, count


class _OtherSession(ValueError):
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
        part_exists = self.path.exists()
        # Not buffered: a block counts as kept once the file has it, and a full disk fails here, not at the end.
        self._file: FileIO = self.path.open("r+b" if part_exists else "w+b", buffering=0)
        try:
            self.missing = list(self._look(entry)) if part_exists else self._begin(entry)
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
        # An unbuffered write may take less than it is given.
        while written < len(block):
            written += self._file.write(block[written:])

    def finish(self) -> str:
        """Flush the complete file to disk, give it its final name, and return its SHA-256."""
        # On disk before it gets its name: after a power cut, the final name never holds missing blocks.
        flush_to_disk(self._file.fileno())
        self._file.seek(0)
        digest = hashlib.file_digest(self._file, "sha256").hexdigest()
        self._file.close()
        self.path.replace(self._target)
        return digest

    def _begin(self, entry: LogEntry) -> list[Span]:
        # Empty it first: what is added then reads as zeros, which never prove themselves.
        self._file.truncate(0)
        self._file.truncate(self._size)
        return [(0, entry.blocks)] if entry.blocks else []

    def _look(self, entry: LogEntry) -> Iterator[Span]:
        """Spans without a block that proves itself."""
        size = os.fstat(self._file.fileno()).st_size
        if size != self._size:
            raise self._other(f"it has {size} bytes, the recording has {self._size}", entry)
        try:
            yield from _unproven_spans(self._file, entry)
        except _OtherSession as error:
            sessions = f"it has session {error.session:08x}, the recording has {entry.session:08x}"
            raise self._other(sessions, entry) from None

    def _other(self, why: str, entry: LogEntry) -> PartialLogError:
        return PartialLogError(
            what=f"{self.path} is the beginning of another recording than {entry_words(entry)}: {why}.",
            meaning="Nothing was fetched; the file is unchanged.",
            next_step=f"Delete {self.path} if it is of no use, name another place with --out, or add --force.",
        )


def sha256_if_same(logger: LoggerClient, entry: LogEntry, path: Path) -> str | None:
    """Return the file's SHA-256 if it is the recording, block by block; None if it is not.

    Blocks that prove themselves by their CRC and session are taken for the recording's; only the others are
    read from the logger, zeros included, as they may be room that was never filled.

    Raises:
        OSError: the file cannot be read.
        TfsatError: what the transfer raises.
    """
    if not path.is_file() or path.stat().st_size != entry.blocks * BLOCK_BYTES:
        return None
    with path.open("rb", buffering=0) as file:
        try:
            doubtful = list(_unproven_spans(file, entry))
        except _OtherSession:
            return None
        differing: list[int] = []

        def compare(index: int, block: bytes) -> None:
            file.seek(index * BLOCK_BYTES)
            if file.read(BLOCK_BYTES) != block:
                differing.append(index)

        # Doubtful blocks are compared with the logger's own, byte by byte.
        outcome = logger.fetch_blocks(entry, doubtful, compare)
        if differing or outcome.unreadable:
            return None
        file.seek(0)
        return hashlib.file_digest(file, "sha256").hexdigest()


@dataclass(frozen=True, slots=True)
class FetchedCopy:
    """A file with a recording, as it was when it was fetched."""

    path: str
    sha256: str
    fetched_unix_s: int = 0

    def is_unchanged(self) -> bool:
        """Return whether the file is there and still the same."""
        try:
            return sha256_of(Path(self.path)) == self.sha256
        except OSError:
            return False


class FetchedLogs:
    """What was fetched from loggers with this computer, in the user's state directory, so that nothing else is erased.

    An entry is worth something only while the fetched copy is unchanged: its SHA-256 is compared each time. A user
    without a home folder has no memory of copies: then no copy is known.
    """

    def __init__(self) -> None:
        try:
            self.path: Path | None = state_folder() / "fetched.json"
        except NoUserFolder:
            self.path = None

    def copy_of(self, serial: str, entry: LogEntry) -> Path | None:
        """Return the path of the newest unchanged copy of a logger's recording; None if there is none.

        Raises:
            TfsatError: the file of copies is damaged.
        """
        copies = reversed(self._read().get(_key(serial, entry), []))
        return next((Path(copy.path) for copy in copies if copy.is_unchanged()), None)

    def sha256_of(self, serial: str, entry: LogEntry, path: Path) -> str | None:
        """Return the SHA-256 of `path` if it is an unchanged copy of this recording, otherwise None.

        Raises:
            TfsatError: the file of copies is damaged.
        """
        for copy in self._read().get(_key(serial, entry), []):
            if _same_file(Path(copy.path), path) and copy.is_unchanged():
                return copy.sha256
        return None

    def add(self, serial: str, entry: LogEntry, path: Path, sha256: str) -> None:
        """`path` holds the whole recording, as other copies of it may.

        Raises:
            TfsatError: the file of copies is damaged, or this user has no folder for it.
            OSError: it cannot be written.
        """
        file = self.path or state_folder() / "fetched.json"
        copies_by_key = self._read()
        place = str(path.absolute())
        # A place holds one recording: what was noted about it before is void.
        for key, copies in copies_by_key.items():
            copies_by_key[key] = [copy for copy in copies if copy.path != place]
        new_copy = FetchedCopy(place, sha256, int(time.time()))
        copies_by_key.setdefault(_key(serial, entry), []).append(new_copy)
        written = {key: [asdict(copy) for copy in copies] for key, copies in copies_by_key.items() if copies}
        write_whole(file, json.dumps(written, indent=1).encode())

    def _read(self) -> dict[str, list[FetchedCopy]]:
        if self.path is None:
            return {}
        try:
            values = json.loads(self.path.read_text(encoding="utf-8"))
            return {
                key: [parse_dataclass(FetchedCopy, copy, ("fetched_unix_s",)) for copy in copies]
                for key, copies in values.items()
            }
        except FileNotFoundError:
            return {}
        except (ValueError, KeyError, TypeError, AttributeError):
            raise TfsatError(
                what=f"{self.path} is damaged: it notes which recordings were fetched.",
                meaning="No recording is concerned, neither on the logger nor on this computer.",
                next_step=f"Delete {self.path}, then the same command again.",
            ) from None


def _same_file(path: Path, other: Path) -> bool:
    try:
        return path.samefile(other)
    except OSError:
        return False


def _key(serial: str, entry: LogEntry) -> str:
    return f"{serial or 'no-serial'}/{entry.number}/{entry.session:08x}/{entry.blocks}"
