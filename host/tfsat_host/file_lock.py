"""One program at a time, by a lock that the system takes back when its holder dies."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from tfsat_host.errors import TfsatError

LOCK_TIMEOUT_S = 30.0
_POLL_S = 0.02


class LockError(TfsatError):
    """The file system has no locks, or refuses this one (exit code 1)."""


class BusyError(LockError):
    """Another program has held the lock for too long (exit code 1)."""


@contextmanager
def one_at_a_time(lock: Path, what: str, *, patience_s: float = LOCK_TIMEOUT_S) -> Iterator[IO[bytes]]:
    """Hold a lock while the block runs, so that no other program that takes it runs at the same time.

    Yields the lock's file, which may say who holds it.

    Args:
        lock: An empty file that is made, and removed afterwards; a system that cannot remove open files keeps
            it. One that a killed program left is free.
        what: The thing locked, for the error: `the record of RUN`.
        patience_s: The time to wait for another holder.

    Raises:
        BusyError: another one holds it.
        LockError: the file system refuses the lock.
        OSError: the file cannot be made.
    """
    deadline_s = time.monotonic() + patience_s
    # Poll: a call that blocks on the lock could not give up after `patience_s`.
    while (file := _claim(lock)) is None:
        if time.monotonic() > deadline_s:
            raise BusyError(
                what=f"Another program has been writing {what} for {patience_s:g} s.",
                meaning="Nothing was changed by this command.",
                next_step="End the other one, then run this command again.",
            )
        time.sleep(_POLL_S)
    with file:
        try:
            yield file
        finally:
            _let_go(file, lock)


def _claim(lock: Path) -> IO[bytes] | None:
    """Open and lock the lock's file; return None while another program holds it."""
    file = lock.open("ab")
    try:
        if _try_lock(file, lock):
            return file
    except OSError as error:
        file.close()
        # A file that cannot be locked is of no use: leave none behind.
        with suppress(OSError):
            lock.unlink()
        raise LockError(
            what=f"{lock} cannot be locked: {error.strerror or error}.",
            meaning=f"Without a lock two programs could write in {lock.parent} at once. Nothing was changed.",
            next_step="Work in a folder on a disk of this computer: some network mounts have no locks.",
        ) from error
    file.close()
    return None


if sys.platform == "win32":
    import msvcrt

    def _try_lock(file: IO[bytes], lock: Path) -> bool:  # noqa: ARG001  an open file cannot be removed: it is the lock's
        # Windows locks bytes from the file's position on: always the first one.
        file.seek(0)
        try:
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True

    def _let_go(file: IO[bytes], lock: Path) -> None:  # noqa: ARG001
        file.seek(0)
        msvcrt.locking(file.fileno(), msvcrt.LK_UNLCK, 1)

else:
    import fcntl
    import os

    def _try_lock(file: IO[bytes], lock: Path) -> bool:
        """Lock the open file and return whether that succeeded.

        The previous holder removed its file: a lock on that removed file does not count.
        """
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return os.path.samestat(os.fstat(file.fileno()), lock.stat())
        except (BlockingIOError, FileNotFoundError):
            return False

    def _let_go(file: IO[bytes], lock: Path) -> None:
        """Removed while it is held: no program can hold the same file and another one of its name."""
        with suppress(OSError):
            lock.unlink()
        fcntl.flock(file, fcntl.LOCK_UN)
