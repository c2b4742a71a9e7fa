"""Bytes of a log, by blocks: a file, a raw card image or a device, read and never mapped.

A mapped file that a failing card cannot deliver kills the process; a read that fails is an error
that can be shown.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Self

from tfsat_host.protocol.limits import BLOCK_BYTES

from . import errors

CHUNK_BLOCKS = 4096
"""Blocks that are read at a time (2 MiB, which stay in the processor's cache)."""


class LogSource:
    """An open log.

    Raises:
        LogError: there is no file, it is a directory, it cannot be read or it is empty.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            if path.is_dir():
                raise errors.not_a_file(path, sorted(path.glob("*.[bB][iI][nN]")))
            self._file = path.open("rb", buffering=0)
        except FileNotFoundError:
            raise errors.missing(path) from None
        except OSError as error:
            raise errors.unreadable(path, error.strerror or str(error)) from None
        try:
            self.size_bytes = self._file.seek(0, os.SEEK_END)
        except OSError as error:
            self._file.close()
            raise errors.unreadable(path, error.strerror or str(error)) from None
        if self.size_bytes == 0:
            self._file.close()
            raise errors.empty(path)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    @property
    def block_count(self) -> int:
        """Whole blocks in the file."""
        return self.size_bytes // BLOCK_BYTES

    def chunks(self) -> Iterator[tuple[int, memoryview]]:
        """Yield (index of the first block, up to CHUNK_BLOCKS whole blocks); the buffer is reused."""
        buffer = memoryview(bytearray(min(CHUNK_BLOCKS, self.block_count) * BLOCK_BYTES))
        for first in range(0, self.block_count, CHUNK_BLOCKS):
            size = min(CHUNK_BLOCKS, self.block_count - first) * BLOCK_BYTES
            yield first, self.read_into(buffer[:size], first * BLOCK_BYTES)

    def read_blocks(self, position: int, count: int) -> memoryview:
        """Blocks `position` and following, in a buffer of their own. Raises LogError as `read_into`."""
        return self.read_into(memoryview(bytearray(count * BLOCK_BYTES)), position * BLOCK_BYTES)

    def tail(self) -> bytes:
        """The bytes behind the last whole block."""
        size = self.size_bytes % BLOCK_BYTES
        return bytes(self.read_into(memoryview(bytearray(size)), self.size_bytes - size))

    def read_into(self, target: memoryview, offset: int) -> memoryview:
        """Fill `target` with the bytes at `offset`.

        Raises:
            LogError: the system refuses, or the file is shorter than it was.
        """
        done = 0
        try:
            self._file.seek(offset)
            while done < len(target):
                got = self._file.readinto(target[done:])
                if not got:
                    raise errors.changed_while_read(self.path)
                done += got
        except OSError as error:
            raise errors.unreadable(self.path, error.strerror or str(error)) from None
        return target
