"""What was fetched from loggers with this computer, so that nothing else is erased.

A note is worth something only while the copy is as it was fetched: its SHA-256 is compared each time.
"""

from __future__ import annotations

import hashlib
import json
import time
from pathlib import Path
from typing import Any

from tfsat_host.errors import TfsatError
from tfsat_host.protocol.messages import LogEntry


class FetchedLogs:
    """The notes, in the user's state directory."""

    def __init__(self) -> None:
        import platformdirs

        self.path = Path(platformdirs.user_state_dir("tfsat")) / "fetched.json"

    def copy_of(self, serial: str, entry: LogEntry) -> Path | None:
        """Where the copy of a logger's recording lies; None if there is none, or it is not as it was.

        Raises:
            TfsatError: the notes are damaged.
        """
        note = self._notes().get(_key(serial, entry))
        if note is None:
            return None
        path = Path(str(note["path"]))
        try:
            with path.open("rb") as file:
                same = hashlib.file_digest(file, "sha256").hexdigest() == note["sha256"]
        except OSError:
            return None
        return path if same else None

    def add(self, serial: str, entry: LogEntry, path: Path, sha256: str) -> None:
        """Notes that `path` holds the whole recording. Raises TfsatError."""
        from tfsat_host.cli.outputs import write_atomically

        notes = self._notes()
        notes[_key(serial, entry)] = {
            "path": str(path.absolute()),
            "sha256": sha256,
            "fetched_unix_s": int(time.time()),
        }
        text = json.dumps(notes, indent=1)
        write_atomically(self.path, lambda file: file.write_text(text, encoding="utf-8"))

    def _notes(self) -> dict[str, dict[str, Any]]:
        try:
            notes = json.loads(self.path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return {}
        except ValueError:
            notes = None
        if not isinstance(notes, dict) or not all(_is_note(note) for note in notes.values()):
            raise TfsatError(
                what=f"{self.path} is damaged: it notes which recordings were fetched.",
                meaning="No recording is concerned, neither on the logger nor on this computer.",
                next_step=f"Delete {self.path}, then the same command again.",
            )
        return notes


def _is_note(note: object) -> bool:
    return isinstance(note, dict) and {"path", "sha256"} <= note.keys()


def _key(serial: str, entry: LogEntry) -> str:
    return f"{serial or 'no-serial'}/{entry.number}/{entry.session:08x}/{entry.blocks}"
