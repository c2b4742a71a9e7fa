"""Files that a command writes: never over a person's work, and never half.

A file is overwritten only with `--force`, or when the same command made it; a recording or a certificate, which nothing
can make again, not even then. A command knows its own by a marker: bytes near the start or the end of the file that
nothing else would put there (the line of column names of a CSV, a generator tag, an archive's comment).
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tfsat_host.errors import TfsatError
from tfsat_host.notices import Notices
from tfsat_host.protocol.limits import BLOCK_MAGIC
from tfsat_host.whole_file import fill_whole, is_special, new_file_beside

SEAL = b"# SHA-256 of all before this line: "
"""The marker of a file that a person may edit: a command knows its own only while nobody has."""
_LOOK_BYTES = 4096
_IRREPLACEABLE = {
    BLOCK_MAGIC.to_bytes(4, "little"): "a recording of the logger",
    b"# tfsat calibration": "a calibration certificate",
}


class UnwritableError(TfsatError):
    """The system does not let a file be written there (exit code 1)."""


@dataclass(frozen=True)
class OutputFile:
    """One file to be made.

    Attributes:
        path: Where.
        marker: Bytes in the first or last 4 KiB by which the command knows its own file.
        write: Writes the contents to the path it is given.
        option: That names the place.
    """

    path: Path
    marker: bytes
    write: Callable[[Path], object]
    option: str = "--out"


def sealed_file(path: Path, text: str) -> OutputFile:
    """Return a text file with a last line, a comment, by which `SEAL` knows whether it was changed."""
    contents = text.encode()
    return OutputFile(path, SEAL, lambda place: place.write_bytes(contents + _seal_line(contents)))


def write_all(files: list[OutputFile], *, force: bool) -> None:
    """Write all of `files`, or none if one of them may not be written.

    Each file appears whole.

    Raises:
        TfsatError: a file exists that this command did not make, or something is in the way.
    """
    # Check all of them before the first is written: all or none.
    for file in files:
        check_may_write(file.path, marker=file.marker, force=force, option=file.option)
    for file in files:
        fill_whole(file.path, file.write)


def write_text(path: Path, marker: bytes, text: str, *, force: bool) -> None:
    """Write one text file, whole. Raises as `write_all` does."""
    write_all(
        [OutputFile(path, marker, lambda to: to.write_text(text, encoding="utf-8", newline="\n"))],
        force=force,
    )


def refuse_special(path: Path, option: str = "--out") -> None:
    """Raises TfsatError for a device, pipe or socket; it is not opened, which could wait forever."""
    if is_special(path):
        raise _refusal(
            f"{path} is a device, pipe or socket, not a file.",
            f"Name a file with {option}; results for a pipe go to stdout: --json.",
        )


def check_may_write(
    path: Path, *, marker: bytes, force: bool, elsewhere: str = "", option: str = "--out"
) -> None:
    """Refuse a path that holds something this command did not make, or that nothing can be written to.

    To be called before what takes long: it tries the folder, or the next above that exists, with an empty file.

    Args:
        path: Where.
        marker: Of the command's own files.
        force: Whether another program's may be overwritten.
        elsewhere: What to do where nothing can be written, for a command without `--out`; a sentence.
        option: The one that names the place.

    Raises:
        TfsatError: it does, or it is a directory, or its folder is none or cannot be written to.
    """
    if path.is_dir():
        raise _refusal(f"{path} is a directory.", f"Move it away, or name another place with {option}.")
    refuse_special(path, option)
    # The nearest folder that exists: those below it will be made in it.
    folder = next(place for place in path.absolute().parents if place.exists())
    if not folder.is_dir():
        raise _refusal(f"{folder} is a file, not a folder.", f"Name another place with {option}.")
    try:
        if path.exists() and not force and not was_made_with(path, marker):
            known = (
                "is not, or no longer, what this command made"
                if marker == SEAL
                else "was not made by this command"
            )
            raise TfsatError(
                what=f"{path} exists and {known}.",
                meaning="Nothing was overwritten.",
                next_step=f"Name another place with {option}, or add --force to overwrite it.",
            )
        # Only with --force is one here; a recording or a certificate is safe from that, too.
        if path.exists() and not was_made_with(path, marker):
            _require_replaceable(path, option)
        # Only a try tells: permissions, quotas and read-only disks have no common test.
        new_file_beside(path, folder).unlink()
    except OSError as error:
        raise UnwritableError(
            what=f"{path} cannot be written: {error.strerror}.",
            meaning="Nothing was written.",
            next_step=elsewhere or f"Name another place with {option}, one that you may write to.",
        ) from error


def new_folder_of(path: Path) -> Path | None:
    """Return the lowest folder that writing a file will make; None: it exists already."""
    return None if path.parent.exists() else path.parent


def tell_new_folder(folder: Path | None, notices: Notices) -> None:
    """Says that it was made: a slip in a name makes one, too."""
    if folder is not None:
        notices.note(f"The folder {folder} was not there: it was made.")


def _require_replaceable(path: Path, option: str) -> None:
    with path.open("rb") as file:
        start = file.read(_LOOK_BYTES)
    for sign, what in _IRREPLACEABLE.items():
        if sign in start:
            raise TfsatError(
                what=f"{path} is {what}.",
                meaning="Nothing can make it again, so nothing was overwritten; --force does not change that.",
                next_step=f"Name another place with {option}; move the file away by hand if it may go.",
            )


def _refusal(what: str, next_step: str) -> TfsatError:
    return TfsatError(what=what, meaning="Nothing was written.", next_step=next_step)


def was_made_with(path: Path, marker: bytes) -> bool:
    """Return whether the file bears the marker near its start or its end."""
    with path.open("rb") as file:
        start = file.read(_LOOK_BYTES)
        # Look at both ends: a CSV begins with its mark, an archive ends with it.
        file.seek(max(file.seek(0, os.SEEK_END) - _LOOK_BYTES, 0))
        if marker not in start and marker not in file.read(_LOOK_BYTES):
            return False
        file.seek(0)
        return marker != SEAL or _is_unchanged(file.read())


def _is_unchanged(contents: bytes) -> bool:
    text, _, _ = contents.rpartition(SEAL)
    return contents == text + _seal_line(text)


def _seal_line(contents: bytes) -> bytes:
    return SEAL + hashlib.sha256(contents).hexdigest().encode() + b"\n"
