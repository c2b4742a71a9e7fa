"""One program at a time, by a lock that the system takes back when its holder dies."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from tfsat_host.errors import TfsatError

PATIENCE_S = 30.0
_POLL_S = 0.02


class BusyError(TfsatError):
    """Another program has held the lock for too long (exit code 1)."""


@contextmanager
def one_at_a_time(lock: Path, what: str, *, patience_s: float = PATIENCE_S) -> Iterator[None]:
    """While the block runs no other program that asks likewise does.

    Args:
        lock: An empty file that is made and stays; without it two programs could hold two locks of one name.
        what: What the lock is of, for the error: `the record of RUN`.
        patience_s: How long to wait for another one.

    Raises:
        BusyError: another one holds it.
        OSError: the file cannot be made.
    """
    with lock.open("ab") as file:
        deadline_s = time.monotonic() + patience_s
        while not _locked(file):
            if time.monotonic() > deadline_s:
                raise BusyError(
                    what=f"Another program has been writing {what} for {patience_s:g} s.",
                    meaning="Nothing was changed by this command.",
                    next_step="End the other one, then run this command again.",
                )
            time.sleep(_POLL_S)
        try:
            yield
        finally:
            _unlock(file)


if sys.platform == "win32":
    import msvcrt

    def _locked(file: IO[bytes]) -> bool:
        file.seek(0)
        try:
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

    def _unlock(file: IO[bytes]) -> None:
        file.seek(0)
        msvcrt.locking(file.fileno(), msvcrt.LK_UNLCK, 1)

else:
    import fcntl

    def _locked(file: IO[bytes]) -> bool:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True

    def _unlock(file: IO[bytes]) -> None:
        fcntl.flock(file, fcntl.LOCK_UN)
