"""The folder that a rehearsal leaves, its own and nobody else's."""

from __future__ import annotations

from pathlib import Path

from tfsat_host.errors import UsageError

MARK_FILE = ".tfsat-rehearsal"
"""A folder with this file was made by a rehearsal and may be made again by another; the file names what lies there."""

RECORDING = "SD.bin"


class ResultFolder:
    """Files of one rehearsal, or of a series of them; those of the one before go first.

    Attributes:
        path: Of the folder.
        files: What was written.

    Raises:
        UsageError: the folder holds something that no rehearsal made, or a recording that somebody copied into it,
            and `force` is not set.
    """

    def __init__(self, path: Path, *, force: bool) -> None:
        self.path = path
        self.files: list[Path] = []
        if path.exists() and not path.is_dir():
            raise _refused(
                f"{path} is a file, and --out names a folder.", "Give the name of a folder with --out."
            )
        if path.is_dir() and any(path.iterdir()) and not (path / MARK_FILE).exists() and not force:
            raise _refused(
                f"{path} holds files that no rehearsal made.",
                "Give another folder with --out, or add --force.",
            )
        if self._recording_of_somebody() and not force:
            raise _refused(
                f"{path / RECORDING} was not made by the rehearsal that made {path}.",
                "Give another folder with --out, or add --force to overwrite it.",
            )

    def _recording_of_somebody(self) -> bool:
        """A recording lies there of which the mark does not know; one of an older program names nothing."""
        mark = self.path / MARK_FILE
        if not mark.exists() or not (self.path / RECORDING).exists():
            return False
        names = mark.read_text(encoding="utf-8").splitlines()[1:]
        return bool(names) and RECORDING not in names

    def emptied(self) -> None:
        """There from now on, without what the rehearsal before left in it: none of that is of this one."""
        self.path.mkdir(parents=True, exist_ok=True)
        mark = self.path / MARK_FILE
        if mark.exists():
            for name in mark.read_text(encoding="utf-8").splitlines()[1:]:
                (self.path / Path(name).name).unlink(missing_ok=True)
        self.marked()

    def marked(self) -> None:
        """The mark names all files so far."""
        names = "".join(f"{path.name}\n" for path in self.files if path.parent == self.path)
        (self.path / MARK_FILE).write_text(f"made by tfsat-host rehearse\n{names}", encoding="utf-8")

    def file(self, name: str) -> Path:
        """Where a file of that name is about to be written."""
        path = self.path / name
        self.files.append(path)
        self.marked()
        return path


def _refused(what: str, next_step: str) -> UsageError:
    return UsageError(
        what=what,
        meaning="Nothing was flown, nothing was overwritten.",
        next_step=next_step,
    )
