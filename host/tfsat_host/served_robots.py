"""Which emulated robots are served now, and in which folders: commands find their ports without being told."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tfsat_host.user_folders import NoUserFolder, state_folder

HOLDER = "emulate.pid"
"""In the folder of a served robot: locked by the process that serves it, which the system ends with the process."""


def served_folders() -> list[Path]:
    """Return the folders in which robots are served by this user's processes."""
    try:
        notes = sorted((state_folder() / "served").iterdir())
    except (NoUserFolder, OSError):
        return []
    return [folder for folder in map(Path.resolve, notes) if is_served(folder)]


@contextmanager
def announce_served(folder: Path) -> Iterator[None]:
    """Let commands find the robot that is served in this folder."""
    try:
        note = state_folder() / "served" / str(os.getpid())
    except NoUserFolder:
        # Then its ports have to be named.
        yield
        return
    note.parent.mkdir(parents=True, exist_ok=True)
    # Left behind by a killed process with the same number.
    note.unlink(missing_ok=True)
    note.symlink_to(folder.absolute())
    try:
        yield
    finally:
        note.unlink(missing_ok=True)


def is_served(folder: Path) -> bool:
    """Return whether a live process serves a robot in the folder."""
    with suppress(ImportError, OSError):
        # Windows has no pseudo-terminals, so nothing is served there.
        import fcntl

        with (folder / HOLDER).open("rb") as holder:
            try:
                # A shared lock disturbs no other onlooker, and fails only while the holder has its exclusive one.
                fcntl.flock(holder, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except OSError:  # held; or a file system without locks, which cannot tell
                return True
    return False
