"""What lies in a folder and is no file of it: links that lead elsewhere, pipes, devices."""

from __future__ import annotations

import os
import stat
from pathlib import Path

_SPECIAL = {
    stat.S_IFIFO: "is a pipe",
    stat.S_IFSOCK: "is a socket",
    stat.S_IFCHR: "is a device",
    stat.S_IFBLK: "is a device",
}


def trouble_with_file(path: Path, root: Path) -> str | None:
    """Why what lies there must not be copied, as the end of a sentence; None: a file or a folder, and it may be.

    A link to a file in the same folder or below counts as that file. A link to a folder does not: it may lead round in
    a circle, and what it leads to is there without it.

    Args:
        path: In `root` or below.
        root: A person named it, so it may be a link itself.

    Raises:
        OSError: it cannot be looked at.
    """
    try:
        mode = path.stat().st_mode
    except OSError:
        if path.is_symlink():
            return "is a link that leads nowhere"
        raise
    real = os.path.realpath(path)
    if not Path(real).is_relative_to(os.path.realpath(root)):
        return f"is a link that leads out of the folder, to {real}"
    if stat.S_ISDIR(mode):
        return "is a link to a folder" if path.is_symlink() else None
    return None if stat.S_ISREG(mode) else _SPECIAL.get(stat.S_IFMT(mode), "is no file")
