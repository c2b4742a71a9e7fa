"""The folder that a rehearsal leaves: its own files and no others, replaced whole or not at all.

While files are replaced, those of before wait in a hidden subfolder. An interruption puts them back; so does the next
rehearsal, if the program was killed or the power failed.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tfsat_host.errors import UsageError
from tfsat_host.file_hash import sha256_of
from tfsat_host.output_files import check_may_write
from tfsat_host.run.campaign.campaign_folder import DROP, INDEX
from tfsat_host.run.files import RECORDING, REHEARSED, rehearsed_files
from tfsat_host.whole_file import write_whole

WAITING = ".tfsat-rehearsal-before"
_REPLACED = ".tfsat-rehearsal-replaced"
_HALF = ".half-copied"
_FIRST_LINE = "made by tfsat-host rehearse"


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
        """Begin the replacement: set the mark aside for `put_back`.

        From here on `put_back` restores the mark and whatever is set or copied aside. Raises OSError.
        """
        # Leftovers of a replacement that was whole and not cleaned up before the program ended.
        shutil.rmtree(self._folder / _REPLACED, ignore_errors=True)
        self._folder.mkdir(parents=True, exist_ok=True)
        self.waiting.mkdir()
        # The mark goes first: with no hashes in place nothing in the folder passes for whole.
        self.set_aside(self._mark)

    def set_aside(self, path: Path) -> None:
        """Move the file away until `put_back`; also remove a subfolder that this leaves empty."""
        place = self._place(path)
        if path.is_file() or path.is_symlink():
            place.parent.mkdir(parents=True, exist_ok=True)
            path.replace(place)
        self._without_empty(path.parent)

    def copy_aside(self, path: Path) -> None:
        """Keep a copy for `put_back` of a file that stays and is about to be written."""
        place = self._place(path)
        if path.is_file() and not place.exists() and self.waiting.is_dir():
            place.parent.mkdir(parents=True, exist_ok=True)
            # Rename when it is whole: a torn copy must never be put back over the original.
            half = place.with_name(f"{place.name}{_HALF}")
            shutil.copy2(path, half)
            half.replace(place)

    def put_back(self, written: Iterable[Path]) -> None:
        """Restore the folder as it was; `written` are the new files, whether they exist yet or not."""
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
        """Discard the old files: the new ones are whole, or nothing was moved yet.

        Nothing is put back from here on.
        """
        if self.waiting.is_dir():
            # One rename decides: before it everything can be put back, after it nothing.
            self.waiting.replace(self._folder / _REPLACED)
        shutil.rmtree(self._folder / _REPLACED, ignore_errors=True)

    def _place(self, path: Path) -> Path:
        return self.waiting / path.relative_to(self._folder)

    def _without_empty(self, folder: Path) -> None:
        if folder != self._folder:
            with suppress(OSError):  # not there, or not empty
                folder.rmdir()


class ResultFolder:
    """Files of one rehearsal, or of a series of them; those of the one before go first.

    Attributes:
        path: Of the folder.
        files: What was written.

    Raises:
        UsageError: the folder is a campaign or one of its drops; or it holds something that no rehearsal made, or a
            file of a rehearsal that was replaced, and `force` is not set.
        TfsatError: it cannot be written to.
    """

    def __init__(self, path: Path, *, force: bool) -> None:
        self.path = path
        self.files: list[Path] = []
        self._force = force
        self._before = Before(path, REHEARSED)
        self._announced: list[Path] = []
        if path.exists() and not path.is_dir():
            raise _refusal(
                f"{path} is a file, and --out names a folder.", "Give the name of a folder with --out."
            )
        # Recover before the checks, which must see the folder as it was before a killed program came.
        self._recover()
        self._check()
        check_may_write(path / REHEARSED, marker=_FIRST_LINE.encode(), force=True)

    def _check(self) -> None:
        """Refuse a folder in which files that no rehearsal made would be overwritten."""
        path = self.path
        # A campaign's files are of real drops: not even --force overwrites those.
        if (path / DROP).exists():
            raise _refusal(
                f"{path} is a drop of a campaign: it holds {DROP}.", "Give another folder with --out."
            )
        if (path / INDEX).exists():
            raise _refusal(f"{path} is a campaign: it holds {INDEX}.", "Give another folder with --out.")
        if self._force or not path.is_dir():
            return
        if any(path.iterdir()) and not (path / REHEARSED).exists():
            raise _refusal(
                f"{path} holds files that no rehearsal made.",
                "Give another folder with --out, or add --force.",
            )
        for name in self._not_ours():
            raise _refusal(
                f"{path / name} is not as the rehearsal made it that made {path}.",
                "Give another folder with --out, or add --force to overwrite it.",
            )

    def _not_ours(self) -> list[str]:
        """List the files that a rehearsal would overwrite and that are not as a rehearsal left them.

        A mark of an older program has no hashes.
        """
        marked = rehearsed_files(self.path)
        if marked and RECORDING not in marked and (self.path / RECORDING).exists():
            return [RECORDING]
        return [name for name, sha256 in marked.items() if not self._is_ours(self.path / name, sha256)]

    def _is_ours(self, path: Path, sha256: str) -> bool:
        return not (sha256 and path.is_file()) or sha256_of(path) == sha256 or self.may_be_made_again(path)

    def may_be_made_again(self, path: Path) -> bool:
        """Return whether a changed file was changed by a command that makes it out of the other files."""
        del path
        return False

    @contextmanager
    def replace_files(self) -> Iterator[None]:
        """Inside, the files of the rehearsal before are away; whatever ends it before `seal` puts them back.

        A file from elsewhere, or one that replaced a rehearsal's, stays.

        Raises:
            UsageError: a file was replaced during the rehearsal.
        """
        # Once more, for minutes may have passed since the folder was checked.
        self._check()
        try:
            ours = [
                name
                for name, sha256 in rehearsed_files(self.path).items()
                if self._is_ours(self.path / name, sha256)
            ]
            old = dict.fromkeys((*(self.path / name for name in ours), *self.stale()))
            self._before.begin()
            for path in old:
                self._before.set_aside(path)
            self.mark()
            yield
            self._before.forget()
        except BaseException:
            # Ctrl-C as well: the folder is left as all new or all old.
            self._settle(self.written_paths())
            raise

    def stale(self) -> Iterable[Path]:
        """Files besides those in the mark that are of the rehearsal before."""
        return ()

    def _recover(self) -> None:
        """Recover from a program that was killed during a replacement.

        It left new files, all in its mark, and the old ones in their hidden folder.
        """
        if self._before.waiting.is_dir():
            self._settle([self.path / name for name in rehearsed_files(self.path)])

    def _settle(self, begun: Iterable[Path]) -> None:
        """Keep all new files if they are whole, which the hashes in their mark say; else restore the old ones."""
        if any(rehearsed_files(self.path).values()):
            self._before.forget()
        else:
            self._before.put_back(begun)

    def written_paths(self) -> list[Path]:
        """List the files that were written or are about to be."""
        return list(dict.fromkeys((*self.files, *self._announced)))

    def mark(self) -> None:
        """Write the mark with the names of all files so far."""
        (self.path / REHEARSED).write_text(
            _text(self._name(path) for path in self.written_paths()), encoding="utf-8"
        )

    def seal(self) -> None:
        """Write the mark with each file's hash.

        A file that is replaced from now on is not a rehearsal's.
        """
        # Announced files need not exist: only what is there can be told from a later change.
        there = [path for path in self.files if path.is_file()]
        lines = (f"{sha256_of(path)}  {self._name(path)}" for path in there)
        write_whole(self.path / REHEARSED, _text(lines).encode())

    def _name(self, path: Path) -> str:
        return path.relative_to(self.path).as_posix()

    def file(self, name: str) -> Path:
        """Return the path at which a file of that name is about to be written, and note it in `files`."""
        path = self.announce(name)
        self.files.append(path)
        return path

    def announce(self, name: str) -> Path:
        """Return the path at which another part is about to write a file of that name.

        It is to be added to `files` when written.
        """
        path = self.path / name
        if path not in self._announced:
            self._before.copy_aside(path)
            self._announced.append(path)
        self.mark()
        return path


def _text(lines: Iterable[str]) -> str:
    return "".join(f"{line}\n" for line in (_FIRST_LINE, *lines))


def _refusal(what: str, next_step: str) -> UsageError:
    return UsageError(
        what=what,
        meaning="Nothing was flown, nothing was overwritten.",
        next_step=next_step,
    )
