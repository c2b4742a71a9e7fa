"""The record's entries, and the one text that some entries have."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from typing import Any, Literal

from tfsat_host import json_values

MADE_BY = "tfsat-host: each entry names files by SHA-256, and the entry before it by its own"
FORMAT = 1


@dataclass(frozen=True, slots=True)
class SignedFile:
    """A file as it was when an entry was made.

    Attributes:
        name: Below the run's folder, with `/` between folders.
        sha256: Of its bytes, hexadecimal.
        bytes: How many.
    """

    name: str
    sha256: str
    bytes: int


@dataclass(frozen=True, slots=True)
class Entry:
    """Something was done.

    Attributes:
        at: When, with its time zone.
        by: What did it, such as `tfsat-host preflight 0.8.0: GO`.
        files: What it vouches for.
        previous: SHA-256 of the entry before it; empty in the first.
    """

    at: datetime
    by: str
    files: tuple[SignedFile, ...]
    previous: str


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that is not as the record says.

    Attributes:
        kind: What happened to it.
        name: The file, or the record itself.
        sentence: For people.
    """

    kind: Literal["changed", "missing", "inserted", "damaged"]
    name: str
    sentence: str


def sha256_of_entry(entry: Entry) -> str:
    """Of its JSON without spaces, keys sorted, hexadecimal."""
    text = json.dumps(_as_json(entry), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def format_record(entries: tuple[Entry, ...]) -> str:
    """The file's text; `last` is the hash of the last entry, which no other one names."""
    record = {
        "made_by": MADE_BY,
        "format": FORMAT,
        "entries": [_as_json(entry) for entry in entries],
        "last": sha256_of_entry(entries[-1]) if entries else "",
    }
    return json.dumps(record, indent=1) + "\n"


def parse_record(text: str) -> tuple[tuple[Entry, ...], str]:
    """Its entries, and what it says of the last one's hash. Raises ValueError: it is no record."""
    try:
        record = json.loads(text)
        if record["format"] != FORMAT:
            raise ValueError(f"its format is {record['format']!r}, this program reads {FORMAT}")
        return tuple(_entry(one) for one in record["entries"]), _hash_before(record["last"])
    except (KeyError, TypeError, RecursionError, OverflowError) as error:
        raise ValueError(f"{type(error).__name__} at {error}") from error


def _as_json(entry: Entry) -> dict[str, Any]:
    return {
        "at": entry.at.astimezone(UTC).isoformat().replace("+00:00", "Z"),
        "by": entry.by,
        "files": [asdict(file) for file in entry.files],
        "previous": entry.previous,
    }


def _entry(one: dict[str, Any]) -> Entry:
    return Entry(
        json_values.moment(one["at"]),
        json_values.text(one["by"], empty=False),
        tuple(_file(file) for file in one["files"]),
        _hash_before(one["previous"]),
    )


def _file(file: dict[str, Any]) -> SignedFile:
    return SignedFile(
        json_values.text(file["name"], empty=False),
        json_values.sha256(file["sha256"]),
        json_values.byte_count(file["bytes"]),
    )


def _hash_before(value: object) -> str:
    """Of an entry; nothing before the first one."""
    return "" if value == "" else json_values.sha256(value)
