"""What was fetched from loggers with this computer, so that nothing else is erased.

A note is worth something only while the copy is as it was fetched: its SHA-256 is compared each time.
"""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import sha256_of
from tfsat_host.protocol.messages import LogEntry
from tfsat_host.whole_file import write_whole


class FetchedLogs:
    """The notes, in the user's state directory."""

    def __init__(self) -> None:
        import platformdirs

        self.path = Path(platformdirs.user_state_dir("tfsat")) / "fetched.json"

    def copy_of(self, serial: str, entry: LogEntry) -> Path | None:
        """Where a copy of a logger's recording lies, the newest first; None if none stands as it was fetched.

        Raises:
            TfsatError: the notes are damaged.
        """
        notes = reversed(self._notes().get(_key(serial, entry), []))
        return next((Path(note["path"]) for note in notes if _stands(note)), None)

    def sha256_of(self, serial: str, entry: LogEntry, path: Path) -> str | None:
        """The SHA-256 of `path` if it is as it was fetched from this recording; None if it is anything else.

        Raises:
            TfsatError: the notes are damaged.
        """
        for note in self._notes().get(_key(serial, entry), []):
            if _same_file(Path(note["path"]), path) and _stands(note):
                return str(note["sha256"])
        return None

    def add(self, serial: str, entry: LogEntry, path: Path, sha256: str) -> None:
        """Notes that `path` holds the whole recording, beside the other copies of it. Raises TfsatError."""
        notes = self._notes()
        place = str(path.absolute())
        for key, copies in notes.items():
            notes[key] = [note for note in copies if note["path"] != place]
        note = {"path": place, "sha256": sha256, "fetched_unix_s": int(time.time())}
        notes.setdefault(_key(serial, entry), []).append(note)
        text = json.dumps({key: copies for key, copies in notes.items() if copies}, indent=1)
        write_whole(self.path, text.encode())

    def _notes(self) -> dict[str, list[dict[str, Any]]]:
        try:
            notes = json.loads(self.path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return {}
        except ValueError:
            notes = None
        if not isinstance(notes, dict) or not all(_are_notes(copies) for copies in notes.values()):
            raise TfsatError(
                what=f"{self.path} is damaged: it notes which recordings were fetched.",
                meaning="No recording is concerned, neither on the logger nor on this computer.",
                next_step=f"Delete {self.path}, then the same command again.",
            )
        return notes


def _are_notes(copies: object) -> bool:
    return isinstance(copies, list) and all(
        isinstance(note, dict) and all(isinstance(note.get(name), str) for name in ("path", "sha256"))
        for note in copies
    )


def _stands(note: dict[str, Any]) -> bool:
    try:
        return sha256_of(Path(note["path"])) == str(note["sha256"])
    except OSError:
        return False


def _same_file(one: Path, other: Path) -> bool:
    try:
        return one.samefile(other)
    except OSError:
        return False


def _key(serial: str, entry: LogEntry) -> str:
    return f"{serial or 'no-serial'}/{entry.number}/{entry.session:08x}/{entry.blocks}"
