"""Values of a JSON file that somebody may have edited or damaged: each as what it should be, or refused by name."""

from __future__ import annotations

import re
from datetime import UTC, datetime

_SHA256 = re.compile(r"[0-9a-f]{64}")
_SESSION = re.compile(r"[0-9a-f]{8}")


def text(value: object, *, empty: bool = True) -> str:
    """Any text; without `empty` a character at least. Raises ValueError."""
    if not isinstance(value, str) or not (value or empty):
        raise ValueError(f"{value!r} is no text")
    return value


def sha256(value: object) -> str:
    """64 hexadecimal digits. Raises ValueError."""
    if not isinstance(value, str) or not _SHA256.fullmatch(value):
        raise ValueError(f"{value!r} is no SHA-256")
    return value


def session_id(value: object) -> str:
    """A recording's id, 8 hexadecimal digits. Raises ValueError."""
    if not isinstance(value, str) or not _SESSION.fullmatch(value):
        raise ValueError(f"{value!r} is no recording's id")
    return value


def byte_count(value: object) -> int:
    """The size of a file. Raises ValueError."""
    if type(value) is not int or value < 0:
        raise ValueError(f"{value!r} is no number of bytes")
    return value


def moment(value: object) -> datetime:
    """A time with its zone, ISO 8601, in UTC. Raises ValueError."""
    at = datetime.fromisoformat(text(value))
    if at.tzinfo is None:
        raise ValueError(f"{value!r} has no time zone")
    return at.astimezone(UTC)
