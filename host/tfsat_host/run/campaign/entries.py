"""A drop's entry in the index of a campaign and in its own folder: text that may have been edited or damaged."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import pairwise
from typing import Annotated

from tfsat_host import json_values, quantity
from tfsat_host.quantity import Column, Columns, record, records
from tfsat_host.run.files import ROBOTS, UNKNOWN

MADE_BY = "tfsat-host campaign"
FORMAT = 1
NUMBER_MAX = 9999
_OPTIONAL = ("robot",)
"""An older program wrote none."""
_FOLDER = re.compile(r"drop-([0-9]{4})")


def _number(value: object) -> int:
    # type(), as isinstance() takes True for 1.
    if type(value) is not int or not 1 <= value <= NUMBER_MAX:
        raise ValueError(f"{value!r} is no drop's number")
    return value


def _robot(value: object) -> str:
    if value not in ROBOTS:
        raise ValueError(f"{value!r} is none of {', '.join(ROBOTS)}")
    return str(value)


def _file_name(value: object) -> str:
    name = json_values.text(value)
    # Separators, a drive's colon or NUL would let an edited index name a file elsewhere.
    if not name or name in (".", "..") or re.search(r"[/\\:\x00]", name):
        raise ValueError(f"{name!r} is no file's name")
    return name


@dataclass(frozen=True, slots=True)
class Note:
    """What a person wrote of a drop."""

    at: datetime
    text: str


@dataclass(frozen=True, slots=True)
class DropEntry:
    """One drop.

    Attributes:
        number: From 1; never given again.
        recording: The raw log's name in the drop's folder.
        sha256: Of that, hexadecimal.
        session: Its id, 8 hexadecimal digits; None: it cannot be decoded.
        released: When; None: not known.
        added: When it came into the campaign.
        origin: Where it was taken from, as typed.
        robot: Of `ROBOTS`; unknown where the recording cannot be decoded, or an older program added it.
        notes: In order of time.
        void: Why it does not count, and since when; None: it counts.
    """

    number: Annotated[int, _number]
    recording: Annotated[str, _file_name]
    sha256: Annotated[str, json_values.sha256]
    session: Annotated[str, json_values.session_id] | None
    released: datetime | None
    added: datetime
    origin: str
    robot: Annotated[str, _robot] = UNKNOWN
    notes: tuple[Note, ...] = ()
    void: Note | None = None

    @property
    def folder(self) -> str:
        """Of the drop, in the campaign's."""
        return folder_name(self.number)

    def with_note(self, at: datetime, text: str) -> DropEntry:
        """Return a copy of the entry with one more note."""
        return replace(self, notes=(*self.notes, Note(at, text)))


def _note_words(drop: DropEntry) -> str:
    void = [f"VOID: {drop.void.text}"] if drop.void else []
    return "; ".join([*void, *(note.text for note in drop.notes)]) or quantity.UNKNOWN


_NOTE: Columns = (Column("at", of=lambda note: _format_time(note.at)), Column("text"))
ENTRY: Columns = (
    Column("number", "drop"),
    Column("recording", "recording"),
    Column("sha256"),
    Column("session", "session", words=lambda drop: drop.session or "unknown"),
    Column(
        "released",
        "released / UTC",
        of=lambda drop: drop.released and _format_time(drop.released),
        words=lambda drop: "unknown" if drop.released is None else f"{drop.released:%Y-%m-%d %H:%M}",
    ),
    Column("added", of=lambda drop: _format_time(drop.added)),
    Column("origin"),
    Column("robot", "robot"),
    Column("notes", "notes", words=_note_words, columns=_NOTE),
    Column("void", columns=_NOTE),
    Column("folder"),
)
"""Of `drop.json`, of the index and of `--json`."""


def folder_name(number: int) -> str:
    """Return the name of a drop's folder, such as `drop-0007`."""
    return f"drop-{number:04d}"


def number_of(folder: str) -> int | None:
    """Parse the drop's number from its folder's name; return None if it is no drop's folder."""
    match = _FOLDER.fullmatch(folder)
    return int(match[1]) if match and int(match[1]) > 0 else None


def parse_index(text: str) -> tuple[DropEntry, ...]:
    """Parse the drops of an index, sorted by number. Raises ValueError: it is no index, or damaged."""
    with _as_value_error():
        index = json.loads(text)
        if index["made_by"] != MADE_BY or index["format"] != FORMAT:
            raise ValueError(f"it is of {index['made_by']!r}, format {index['format']!r}")
        entries = (
            json_values.parse_dataclass(DropEntry, raw_entry, _OPTIONAL) for raw_entry in index["drops"]
        )
        drops = tuple(sorted(entries, key=lambda drop: drop.number))
    for entry, other in pairwise(drops):
        if entry.number == other.number:
            raise ValueError(f"drop {entry.number} is in it twice")
    return drops


def format_index(drops: Sequence[DropEntry]) -> str:
    """Format the drops as the index's text."""
    return _json({"made_by": MADE_BY, "format": FORMAT, "drops": records(ENTRY, drops)})


def format_drop(drop: DropEntry) -> str:
    """Format the text of a drop's own copy of its entry."""
    return _json(record(ENTRY, drop))


def parse_drop(text: str) -> DropEntry:
    """Parse a drop's own copy of its entry. Raises ValueError: it is none, or damaged."""
    with _as_value_error():
        return json_values.parse_dataclass(DropEntry, json.loads(text), _OPTIONAL)


@contextmanager
def _as_value_error() -> Iterator[None]:
    """Whatever a damaged file makes of the reading of it."""
    try:
        yield
    except (KeyError, TypeError, AttributeError, RecursionError, OverflowError) as error:
        raise ValueError(f"{type(error).__name__}: {error}") from error


def _json(value: object) -> str:
    return json.dumps(value, indent=1, ensure_ascii=False) + "\n"


def _format_time(at: datetime) -> str:
    return at.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
