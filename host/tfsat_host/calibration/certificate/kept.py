"""Files that are whole or not there, and one writer at a time."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tfsat_host.calibration.errors import CalibrationError

_PATIENCE_S = 10.0
_POLL_S = 0.05
_DEAD_S = 60.0
"""Writing takes less than a second: a lock that is older was left behind by a program that was killed."""


def write_whole(path: Path, data: bytes) -> None:
    """Writes a file so that a power cut or a full disk leaves the old one or the new one. Raises OSError."""
    target = path.resolve()  # a link stays one
    target.parent.mkdir(parents=True, exist_ok=True)
    beside = target.with_name(f".{target.name}.new")
    try:
        with beside.open("wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        beside.replace(target)
    except OSError:
        with suppress(OSError):
            beside.unlink()
        raise


@contextmanager
def one_writer(path: Path) -> Iterator[None]:
    """While the block runs no other program that asks likewise writes the file.

    Raises:
        CalibrationError: another one has been writing for ten seconds.
        OSError: the folder cannot be written.
    """
    lock = path.with_name(f".{path.name}.lock")
    lock.parent.mkdir(parents=True, exist_ok=True)
    _claim(lock)
    try:
        yield
    finally:
        lock.unlink(missing_ok=True)


def _claim(lock: Path) -> None:
    deadline_s = time.monotonic() + _PATIENCE_S
    while True:
        try:
            os.close(os.open(lock, os.O_CREAT | os.O_EXCL | os.O_WRONLY))
        except FileExistsError:
            with suppress(FileNotFoundError):
                if time.time() - lock.stat().st_mtime > _DEAD_S:
                    lock.unlink()
        else:
            return
        if time.monotonic() > deadline_s:
            raise CalibrationError(
                what=f"Another program has been writing this calibration for {_PATIENCE_S:g} s ({lock} is there).",
                meaning="This step was not kept.",
                next_step=f"End the other one; if there is none, delete {lock}. Then run this command again.",
            )
        time.sleep(_POLL_S)
