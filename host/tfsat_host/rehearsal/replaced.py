"""What lay in a rehearsal's folder, kept there until what replaces it is whole.

While files are replaced, those of before wait in a hidden subfolder. An interruption puts them back; so does the next
rehearsal, if the program was killed or the power failed.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

WAITING = ".tfsat-rehearsal-before"
_REPLACED = ".tfsat-rehearsal-replaced"
_HALF = ".half-copied"


class Before:
    """Files of one folder that are being replaced.

    Attributes:
        waiting: The hidden subfolder. While it is there, the folder holds nothing that is whole.
    """

    def __init__(self, folder: Path, mark: str) -> None:
        self._folder = folder
        self._mark = folder / mark
        self.waiting = folder / WAITING

    def begin(self) -> None:
        """From here on `put_back` restores what `set_aside` and `copy_aside` are told, and the mark; raises OSError."""
        shutil.rmtree(self._folder / _REPLACED, ignore_errors=True)
        self._folder.mkdir(parents=True, exist_ok=True)
        self.waiting.mkdir()
        self.set_aside(self._mark)

    def set_aside(self, path: Path) -> None:
        """The file is gone until `put_back`; a subfolder that this leaves empty goes, too."""
        place = self._place(path)
        if path.is_file() or path.is_symlink():
            place.parent.mkdir(parents=True, exist_ok=True)
            path.replace(place)
        self._without_empty(path.parent)

    def copy_aside(self, path: Path) -> None:
        """The file stays, and is about to be written; what it was is kept."""
        place = self._place(path)
        if path.is_file() and not place.exists() and self.waiting.is_dir():
            place.parent.mkdir(parents=True, exist_ok=True)
            half = place.with_name(f"{place.name}{_HALF}")
            shutil.copy2(path, half)
            half.replace(place)

    def put_back(self, written: Iterable[Path]) -> None:
        """The folder is as it was; `written` are the new files, whether they are there yet or not."""
        for path in (*written, self._mark):
            path.unlink(missing_ok=True)
            self._without_empty(path.parent)
        # The mark comes last: with its hashes there, a program that is killed here has put everything back.
        places = sorted(self.waiting.rglob("*"), key=lambda place: (place.name == self._mark.name, place))
        for place in places:
            if place.is_file() and place.suffix != _HALF:
                path = self._folder / place.relative_to(self.waiting)
                path.parent.mkdir(parents=True, exist_ok=True)
                place.replace(path)
        shutil.rmtree(self.waiting)
        with suppress(OSError):  # something is in it: it was there before
            self._folder.rmdir()

    def forget(self) -> None:
        """The new files are whole, or nothing was moved yet: nothing is put back from here on."""
        if self.waiting.is_dir():
            self.waiting.replace(self._folder / _REPLACED)
        shutil.rmtree(self._folder / _REPLACED, ignore_errors=True)

    def _place(self, path: Path) -> Path:
        return self.waiting / path.relative_to(self._folder)

    def _without_empty(self, folder: Path) -> None:
        if folder != self._folder:
            with suppress(OSError):  # not there, or something of somebody else's is in it
                folder.rmdir()
