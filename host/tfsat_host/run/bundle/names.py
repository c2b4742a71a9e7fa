"""What may go into an archive and come out of it: names that are safe on every system, and files that are files."""

from __future__ import annotations

import os
import re
import stat
import unicodedata
from collections.abc import Iterable
from pathlib import Path

PATH_CHARACTERS_MAX = 400
_PART_BYTES_MAX = 200
_FORBIDDEN = re.compile(r'[\x00-\x1f\x7f<>:"|?*\\]')
_UNSEEN = frozenset({"Cc", "Cf", "Zl", "Zp"})
"""Categories of Unicode: controls, marks that turn the direction of writing or have no width, and ends of lines."""
_DEVICE = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|com[0-9¹²³]|lpt[0-9¹²³])(\..*)?", re.IGNORECASE)
_SPECIAL = {
    stat.S_IFIFO: "is a pipe",
    stat.S_IFSOCK: "is a socket",
    stat.S_IFCHR: "is a device",
    stat.S_IFBLK: "is a device",
}


def trouble_with_name(name: str) -> str | None:
    """Why a file of that name must not be made, as the end of a sentence; None: it may be."""
    if not name or len(name) > PATH_CHARACTERS_MAX:
        return f"has {len(name)} characters"
    if name.startswith("/") or re.match(r"[A-Za-z]:", name):
        return "is absolute: it would be written outside of the folder"
    if _FORBIDDEN.search(name):
        return "holds a character that not every system allows in a name"
    if any(unicodedata.category(character) in _UNSEEN for character in name):
        return "holds a character that cannot be seen"
    for part in name.split("/"):
        if part == "..":
            return "leads out of the folder by `..`"
        if part in ("", "."):
            return "has an empty part"
        if part[-1] in ". " or part[0] == " ":
            return "has a part that ends in a dot or a space, or begins with one"
        if _DEVICE.fullmatch(part):
            return "is a device on Windows"
        try:
            if len(part.encode("utf-8")) > _PART_BYTES_MAX:
                return "has a part that is too long"
        except UnicodeEncodeError:
            return "is no valid text"
    return None


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


def collision_among(names: Iterable[str]) -> tuple[str, str] | None:
    """Two names that some system takes for one, or of which one is a folder of the other; None: there are none."""
    files: dict[str, str] = {}
    folders: dict[str, str] = {}
    for name in names:
        parts = name.split("/")
        key = _folded(name)
        if key in files or key in folders:
            return files.get(key) or folders[key], name
        files[key] = name
        for depth in range(1, len(parts)):
            folder = "/".join(parts[:depth])
            key = _folded(folder)
            if key in files or folders.setdefault(key, folder) != folder:
                return files.get(key) or folders[key], name
    return None


def _folded(name: str) -> str:
    """As the least careful file system sees it: without case, in one normal form."""
    return unicodedata.normalize("NFC", unicodedata.normalize("NFKC", name).casefold())
