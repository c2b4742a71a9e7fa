"""Values as JSON has them; and those of a JSON file that may have been edited or damaged, refused by name."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import fields, is_dataclass
from datetime import UTC, datetime
from types import UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin, get_type_hints

T = TypeVar("T")
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
    """Check a recording's id, 8 hexadecimal digits, and return it. Raises ValueError."""
    if not isinstance(value, str) or not _SESSION.fullmatch(value):
        raise ValueError(f"{value!r} is no recording's id")
    return value


def byte_count(value: object) -> int:
    """Check the size of a file in bytes and return it. Raises ValueError."""
    # Not isinstance, which takes true for 1.
    if type(value) is not int or value < 0:
        raise ValueError(f"{value!r} is no number of bytes")
    return value


def moment(value: object) -> datetime:
    """Parse an ISO 8601 time with a time zone into UTC. Raises ValueError."""
    at = datetime.fromisoformat(text(value))
    if at.tzinfo is None:
        raise ValueError(f"{value!r} has no time zone")
    return at.astimezone(UTC)


def flag(value: object) -> bool:
    """Return whether the value is true."""
    return value is True


def parse_dataclass(kind: type[T], values: Any, optional: Container[str] = ()) -> T:
    """Build a dataclass from its JSON object, parsing each field by its type.

    A field is text, a time, a flag, a number of bytes, another such dataclass, one of these or null
    (`X | None`), a list (`tuple[X, ...]`) or a table (`Mapping[str, X]`) of one, or `Any`; or
    `Annotated` names its parser.

    Args:
        kind: The dataclass.
        values: The object that `json.loads` returned.
        optional: Fields, also of dataclasses in it, that may be left out: older files have none.

    Raises:
        KeyError: a field is not there.
        ValueError, TypeError: a field has a wrong value or type.
    """
    hints = get_type_hints(kind, include_extras=True)
    names = [field.name for field in fields(kind) if field.name not in optional or field.name in values]  # type: ignore[arg-type]
    return kind(**{name: _field(hints[name], values[name], name, optional) for name in names})


def _field(kind: Any, value: Any, name: str, optional: Container[str]) -> Any:
    origin, args = get_origin(kind), get_args(kind)
    # Annotated carries its own parser, which goes before the type.
    if origin is Annotated:
        return args[1](value)
    # X | None: null, or what X takes.
    if origin in (Union, UnionType):
        return None if value is None else _field(args[0], value, name, optional)
    if origin is tuple:
        if not isinstance(value, list):
            raise ValueError(f"its {name} is no list")
        return tuple(_field(args[0], element, name, optional) for element in value)
    if origin is Mapping:
        if not isinstance(value, dict):
            raise ValueError(f"its {name} is no table")
        return {key: _field(args[1], element, key, optional) for key, element in value.items()}
    if isinstance(kind, type) and is_dataclass(kind):
        return parse_dataclass(kind, value, optional)
    return _READERS[kind](value)


_READERS: dict[Any, Callable[[Any], Any]] = {
    str: text,
    int: byte_count,
    bool: flag,
    datetime: moment,
    Any: lambda value: value,
}


def jsonable(value: Any, show: Callable[[str], str] = str) -> Any:
    """Return plain JSON: paths, enums and numpy values become text, numbers and lists; NaN becomes null.

    `show` completes the commands of an `Advice`.
    """
    if isinstance(value, Mapping):
        return {str(key): jsonable(item, show) for key, item in value.items()}
    if isinstance(value, str) or value is None or isinstance(value, bool):
        return str(show(value)) if isinstance(value, str) else value
    if isinstance(value, int):
        return int(value)
    if isinstance(value, float):
        return float(value) if value - value == 0 else None
    if hasattr(value, "tolist"):
        return jsonable(value.tolist(), show)
    if isinstance(value, Iterable):
        return [jsonable(item, show) for item in value]
    return str(value)


def format_json(value: Any) -> str:
    """Format a JSON file's text, one entry a line; paths, numpy values and NaN as `jsonable` has them."""
    return json.dumps(jsonable(value), indent=1, allow_nan=False) + "\n"
