"""Files that a power cut, a full disk or an interruption leaves old or new, never half."""

from __future__ import annotations

import errno
import logging
import os
import tempfile
from collections.abc import Callable
from pathlib import Path

_LOG = logging.getLogger(__name__)

_NOT_SUPPORTED = (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOTTY)
"""What file systems answer that have no such thing."""


def write_whole(path: Path, data: bytes) -> None:
    """Writes a file at once: whoever reads it finds all of what it was or all of what it is now.

    Its folder is made where there is none; where `path` is a link, the file behind it is written.

    Raises:
        OSError: it cannot be written; it names `path`, which is as before.
    """
    fill_whole(path, lambda temporary: temporary.write_bytes(data))


def fill_whole(path: Path, fill: Callable[[Path], object]) -> None:
    """Like `write_whole`, for contents that something else writes: `fill` is given a new file in the same folder.

    Raises:
        OSError: it cannot be written; it names `path`, which is as before. What else `fill` raises passes likewise.
    """
    target = Path(os.path.realpath(path))
    if is_special(target):
        raise OSError(errno.EINVAL, "it is a device, pipe or socket, not a file", str(path))
    temporary = None
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        # Beside the target, hence on its file system: only there is the rename atomic.
        temporary = new_file_beside(target)
        fill(temporary)
        # Contents before the name: a power cut after the rename must not find an empty file.
        with temporary.open("r+b") as file:
            flush_to_disk(file.fileno())
        # A temporary file is for its owner alone; the finished one is like any other.
        _give_usual_mode(temporary)
        temporary.replace(target)
        _LOG.debug("wrote %s", target)
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def is_special(path: Path) -> bool:
    """Return whether a path is a device, pipe or socket, neither file nor folder.

    Nothing is opened.
    """
    return path.exists() and not path.is_file() and not path.is_dir()


def flush_to_disk(descriptor: int) -> None:
    """Wait until a file is on the disk; a file system that cannot tell (WSL, network mounts) is taken at its word.

    Raises:
        OSError: the disk is full or fails.
    """
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in _NOT_SUPPORTED:
            raise


def _give_usual_mode(path: Path) -> None:
    """Set the permissions of any new file.

    A file system without permissions keeps its own.
    """
    try:
        path.chmod(0o666 & ~_umask())
    except OSError as error:
        if error.errno not in (*_NOT_SUPPORTED, errno.EPERM, errno.EACCES):
            raise


def new_file_beside(path: Path, folder: Path | None = None) -> Path:
    """Create an empty file named after `path`, in its folder or another one. Raises OSError."""
    descriptor, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=folder or path.parent)
    os.close(descriptor)
    return Path(name)


def _umask() -> int:
    # The mask can only be read by setting it.
    current = os.umask(0)
    os.umask(current)
    return current
