"""TOML files that people read and write: from a file, or its text, to its table, and back without loss."""

from __future__ import annotations

import json
import logging
import re
import tomllib
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path

from tfsat_host.config.places import Path as Entry
from tfsat_host.config.places import places_of
from tfsat_host.config.table import ConfigKind, Fault, Table, shorten_value

_LOG = logging.getLogger(__name__)

_LONG_NUMBER = re.compile(r"[0-9_]{4300}")  # Python's limit for integers
_MAX_DOTS = 20
_DEEP_KEY = re.compile(rf"^[ \t\[]*[\w-]+(?:[ \t]*\.[ \t]*[\w\"'-]+){{{_MAX_DOTS + 1},}}", re.MULTILINE)
"""The parser takes a minute for forty kilobytes of them."""
_Comments = Mapping[str, str]
_MARKS = {
    "strokes": "maneuver file",
    "inertia_off_diagonals": "robot file",
    "who_am_i": "certificate",
    "drop_height_m": "facility file",
    "frame_ms": "file of servo settings",
}
"""Entries that only one kind of file has."""
_ENDINGS = {
    ".bin": "recording",
    ".csv": "table",
    ".npz": "decoded recording",
    ".json": "JSON file",
    ".html": "page",
}


def _other_kind(path: Path, kind: ConfigKind) -> str:
    """Say what a file is whose name tells it, where it is no TOML; empty for others."""
    name = _ENDINGS.get(path.suffix.lower())
    return "" if name is None else f"{path} is a {name}, no {kind.name}."


def read_config(path: Path, kind: ConfigKind) -> Table:
    """Read the entries of a file, ignoring a byte order mark as Windows editors write it.

    Raises:
        TfsatError: the kind's: the file cannot be read, is not valid TOML, or is of another format.
    """
    try:
        # By size first: a recording given by mistake is not read into memory.
        if path.stat().st_size > kind.bytes_max:
            raise kind.refusal(f"{path}: this is no {kind.name}: it is too large.", Fault.SYNTAX)
        text = path.read_text(encoding="utf-8-sig")
        _LOG.debug("read %s: a %s", path, kind.name)
    except OSError as error:
        what = f"The {kind.name} {path} cannot be read: {error.strerror or error}."
        raise kind.refusal(what, Fault.UNREADABLE) from error
    except UnicodeDecodeError as error:
        what = f"The {kind.name} {path} cannot be read: it is not UTF-8 text."
        raise kind.refusal(_other_kind(path, kind) or what, Fault.NOT_TEXT) from error
    return parse_config(text, str(path), kind)


def parse_config(text: str, source: str, kind: ConfigKind) -> Table:
    """Parse the entries in the text of a file; `source` is the file's name in errors.

    Raises the kind's error as `read_config` does.
    """
    text = text.replace("\r\n", "\n")
    # Before the parser sees them: it would be busy with such keys for minutes.
    if _DEEP_KEY.search(text):
        raise kind.refusal(
            f"{source}: is nested too deeply: a key has more than {_MAX_DOTS} dots.", Fault.SYNTAX
        )
    try:
        values = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        what = _other_kind(Path(source), kind) or f"{source}: {_problem(text, error)}."
        raise kind.refusal(what, Fault.SYNTAX) from error
    top = Table(kind, source, text, (), values)
    # An entry that only one kind has tells which file was given by mistake.
    for mark, name in _MARKS.items():
        if mark in values and name != kind.name:
            raise kind.refusal(f"{source} is a {name}, no {kind.name}.", Fault.FORMAT)
    if kind.format is not None:
        key, number = kind.format
        format_number = top.value(key, str(number))
        # By type: true and 1.0 equal 1 as well.
        if type(format_number) is not int or format_number != number:
            cure = f"Use the tfsat-host that made the file; this one reads the line `{key} = {number}`."
            top.fail(key, f"{shorten_value(format_number)} is not {number}", cure, Fault.FORMAT)
    return top


def _problem(text: str, error: ValueError | RecursionError) -> str:
    if isinstance(error, tomllib.TOMLDecodeError):
        return f"is not valid TOML: {error}"
    if isinstance(error, RecursionError):
        return "is nested too deeply: its brackets lie hundreds deep in one another"
    match = _LONG_NUMBER.search(text)
    where = f" (at line {text.count(chr(10), 0, match.start()) + 1})" if match else ""
    return f"has a number of thousands of digits{where}"


def format_config(
    values: Mapping[str, object], heading: str = "", comments: Mapping[str, str] | None = None
) -> str:
    """Format values as the text of a file.

    Args:
        values: Values by key, in order; None is left out. Tables and lists of tables have headers, to the
            second level; deeper ones are in braces.
        heading: Comments at the top, one per line.
        comments: Comments to append to the entries of these keys, wherever they are.
    """
    top, *tables = _blocks("", values, comments or {})
    top = [*(f"# {line}" for line in heading.splitlines()), *top]
    return "\n\n".join("\n".join(block) for block in (top, *tables)) + "\n"


def with_entry(text: str, path: Entry, value: object, comment: str) -> str:
    """Return the text of a file with an entry's value replaced; the old one stays above it as a comment.

    Args:
        text: A whole file that the parser took, with line feeds as line endings.
        path: The entry to replace.
        value: The new value. A table is set entry by entry if its old entries stand on lines of their own.
        comment: One line to put above the old value.

    Raises:
        KeyError: the entry shares its line with others.
    """
    place = places_of(text).get(path)
    if (place is None or not place.whole) and isinstance(value, Mapping):
        # The table has no statement of its own. Each replacement moves what follows: find places anew.
        for key, item in value.items():
            text = with_entry(text, (*path, key), item, comment)
        return text
    if place is None or not place.whole:
        raise KeyError(path)
    old = text[place.start : place.end]
    # The old statement stays as a comment; the new one keeps its key and indentation.
    rows = [
        f"# {comment}",
        *(f"# {row}" for row in old.splitlines()),
        f"{old.partition('=')[0]}= {_text(value)}",
    ]
    return text[: place.start] + "\n".join(rows) + text[place.end :]


def _blocks(name: str, values: Mapping[str, object], comments: _Comments) -> Iterator[list[str]]:
    """Yield the lines of a table's entries, then those of each table inside it."""
    tables = {}
    lines = []
    for key, value in values.items():
        inner = f"{name}.{key}" if name else key
        # Two levels of headers; tables below them are written in braces.
        if name.count(".") == 0 and isinstance(value, Mapping):
            tables[f"[{inner}]"] = [value]
        elif not name and isinstance(value, list) and value and isinstance(value[0], Mapping):
            tables[f"[[{inner}]]"] = value
        elif value is not None:
            lines.append(f"{key} = {_text(value)}" + (f"  # {comments[key]}" if key in comments else ""))
    # Entries first: behind a header they would belong to its table.
    yield lines
    for header, items in tables.items():
        for item in items:
            first, *rest = _blocks(header.strip("[]"), item, comments)
            yield [header, *first]
            yield from rest


def _text(value: object) -> str:
    """Format a value as TOML.

    A float becomes the shortest text that reads back equal; a matrix gets a line for each of its rows.
    """
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(float(value))  # numpy's as well
    if isinstance(value, datetime):
        return value.astimezone(UTC).isoformat().replace("+00:00", "Z")
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{key} = {_text(item)}' for key, item in value.items())} }}"
    if isinstance(value, list | tuple):
        items = [_text(item) for item in value]
        if items and isinstance(value[0], list):
            return "[\n" + "".join(f"    {item},\n" for item in items) + "]"
        return f"[{', '.join(items)}]"
    if isinstance(value, str):  # JSON's escapes are a subset of TOML's, but DEL must be escaped too
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    return str(value)
