"""Bytes of a log, by blocks: a file, a raw card image or a device, read and never mapped.

A mapped file that a failing card cannot deliver kills the process; a read that fails is an error
that can be shown.
"""

from __future__ import annotations

import errno
import logging
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Self

from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import BLOCK_BYTES

from .blocks import MAGIC, is_sound
from .log_errors import LOOK_AGAIN, LogError, NoBlockError, changed_while_read, not_seekable, unreadable

_LOG = logging.getLogger(__name__)

CHUNK_BLOCKS = 4096
"""Blocks that are read at a time (2 MiB, which stay in the processor's cache)."""


class LogSource:
    """An open log.

    Attributes:
        blocks_in_holes: Blocks that `chunks` passed over because a sparse file has nothing there: zeros.

    Raises:
        LogError: there is no file, it is a directory, a pipe or a stream, it cannot be read or it is empty.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.blocks_in_holes = 0
        self._begin = 0
        try:
            if path.is_dir():
                raise _a_folder(path)
            # Look before opening: opening a FIFO would wait until somebody writes to it.
            kind = path.stat().st_mode
            if stat.S_ISFIFO(kind) or stat.S_ISSOCK(kind):
                raise not_seekable(path)
            # Unbuffered: chunks go straight into the callers' own buffers.
            self._file = path.open("rb", buffering=0)
            _LOG.debug("opened %s: a recording", path)
        except FileNotFoundError:
            raise LogError(
                f"There is no file {path}.",
                "Check the name; on the card the recordings are called DROP0001.BIN and up.",
            ) from None
        except OSError as error:
            raise unreadable(path, error) from None
        try:
            # Seek instead of stat, which tells no size of a block device.
            self.size_bytes = self._file.seek(0, os.SEEK_END)
        except OSError as error:
            self._file.close()
            raise unreadable(path, error) from None
        if self.size_bytes == 0:
            self._file.close()
            # An endless character device has size 0 as well.
            if stat.S_ISCHR(kind):
                raise not_seekable(path)
            meaning = "The logger never opened a recording in it, or the copy failed."
            raise NoBlockError(f"{path} is empty (0 bytes).", LOOK_AGAIN, meaning)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    @property
    def block_count(self) -> int:
        """Whole blocks in the file."""
        return (self.size_bytes - self._begin) // BLOCK_BYTES

    def begin_at(self, offset: int) -> None:
        """Count blocks from byte `offset` of the file on; what stands before is not looked at."""
        self._begin = offset

    def chunks(self) -> Iterator[tuple[int, memoryview]]:
        """Yield (index of the first block, up to CHUNK_BLOCKS whole blocks); the buffer is reused.

        Holes of a sparse file are passed over.
        """
        buffer = memoryview(bytearray(min(CHUNK_BLOCKS, self.block_count) * BLOCK_BYTES))
        reached = self.blocks_in_holes = 0
        while (first := self._next_written(reached)) < self.block_count:
            self.blocks_in_holes += first - reached
            reached = min(first + CHUNK_BLOCKS, self.block_count)
            yield first, self.read_into(buffer[: (reached - first) * BLOCK_BYTES], first * BLOCK_BYTES)
        self.blocks_in_holes += self.block_count - reached

    def tail(self) -> bytes:
        """Read the bytes behind the last whole block."""
        whole_bytes = self.block_count * BLOCK_BYTES
        size = self.size_bytes - self._begin - whole_bytes
        return bytes(self.read_into(memoryview(bytearray(size)), whole_bytes))

    def _next_written(self, block: int) -> int:
        """Return the first block from `block` on that lies in no hole of the file, as far as the system knows."""
        if not hasattr(os, "SEEK_DATA") or block >= self.block_count:
            return block
        try:
            # SEEK_DATA skips the holes of a sparse image; round down to the block that holds the data.
            written = self._file.seek(self._begin + block * BLOCK_BYTES, os.SEEK_DATA)
            return max(block, (written - self._begin) // BLOCK_BYTES)
        except OSError as error:
            # ENXIO: only a hole is left. Any other error: the file system cannot tell, so read everything.
            nothing_follows = error.errno == errno.ENXIO
        # A file that got shorter has no data there either: leave that to the read, which reports it.
        if nothing_follows and self._file.seek(0, os.SEEK_END) >= self.size_bytes:
            return self.block_count
        return block

    def read_into(self, target: memoryview, offset: int) -> memoryview:
        """Fill `target` with the bytes `offset` behind the first block's begin.

        Raises:
            LogError: the system refuses, or the file is shorter than it was.
        """
        bytes_read = 0
        try:
            self._file.seek(self._begin + offset)
            while bytes_read < len(target):
                # A raw read may return less than was asked for; nothing: the file got shorter.
                got = self._file.readinto(target[bytes_read:])
                if not got:
                    raise changed_while_read(self.path)
                bytes_read += got
        except OSError as error:
            raise unreadable(self.path, error) from None
        return target


def find_shift(source: LogSource) -> int:
    """Return the byte offset of the first undamaged block modulo BLOCK_BYTES; 0 if none is shifted.

    The blocks of an image are shifted if something stands before it or its start is cut off. This is slower
    than a look at the sectors, so it is for files where that found nothing.

    Raises:
        LogError: the file cannot be read.
    """
    # What is kept of the chunk before is one block, so an index in the window tells the shift.
    previous_block = bytes(BLOCK_BYTES)
    for _, data in source.chunks():
        window = previous_block + data
        at = window.find(MAGIC)
        # The magic number may occur by chance: only a right CRC makes it a block.
        while 0 <= at <= len(window) - BLOCK_BYTES:
            if at % BLOCK_BYTES and is_sound(window[at : at + BLOCK_BYTES]):
                return at % BLOCK_BYTES
            at = window.find(MAGIC, at + 1)
        previous_block = window[-BLOCK_BYTES:]
    return 0


def _a_folder(path: Path) -> LogError:
    logs = sorted(path.glob("*.[bB][iI][nN]"))
    step: str = Advice("Name the file that came off the card: ", NextStep("decode", ("DROP0001.BIN",)))
    if len(logs) == 1:
        step = Advice("It holds one log: ", NextStep("decode", (str(logs[0]),)))
    elif logs:
        step = "It holds several logs, name one: " + ", ".join(map(str, logs))
    return LogError(f"{path} is a directory, not a log.", step)
