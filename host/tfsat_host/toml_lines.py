"""Where an entry of a TOML file stands: the parser does not say, and a person needs to know."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from typing import NamedTuple

# All that may hold a bracket or a line feed without opening anything or ending a statement, and what does.
_TOKEN = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}'
    r"|'''.*?'{3,5}"
    r'|"(?:\\.|[^"\\\n])*"'
    r"|'[^'\n]*'"
    r"|\#[^\n]*"
    r"|[\[\]{}\n]",
    re.DOTALL,
)
_KEY = re.compile(r"""\s*(?:[^="'\n#]|"(?:\\.|[^"\\\n])*"|'[^'\n]*')+=""")


class _Statement(NamedTuple):
    """A header, or a key with its value: the line (from 1) on which it begins, and its dotted name in parts."""

    line: int
    is_header: bool
    name: tuple[str, ...]


def line_of(text: str, table: str, index: int, key: str) -> int | None:
    """Line (from 1) of `key` in the `index`-th `[[table]]`, of its header if the key is not there.

    Args:
        text: A whole file that the parser took.
        table: Name of the table, empty for the entries above all tables. A sub-table `joint.servo` belongs to
            the `[[joint]]` before it.
        index: Which of the tables of that name, from 0.
        key: Name of the entry, with dots for what lies inside of it. One that is a table itself stands at its
            header; what has no line of its own stands where that begins which holds it: `body = [`.

    Returns:
        None if there is no such table.
    """
    path = tuple(table.split(".")) if table else ()
    wanted = tuple(key.split("."))
    nearest: int | None = None
    for statement in _of_table(text, path, index):
        if statement.name == wanted:
            return statement.line
        if nearest is None and statement.name[:1] == wanted[:1]:
            nearest = statement.line
    if nearest is not None or not path:
        return nearest or 1
    return _header_line(text, path, index) or _line_of_holder(text, path[0])


def has_header(text: str, table: str, index: int) -> bool:
    """Whether the `index`-th `[[table]]` has a header of its own; else its entries stand inside of a value."""
    path = tuple(table.split("."))
    return any(s.is_header and s.name == path for s in _of_owner(text, path[:1], index))


def _of_table(text: str, path: tuple[str, ...], index: int) -> Iterator[_Statement]:
    """The entries of a table and the headers of its sub-tables, all named from that table on."""
    inside = not path
    for statement in _of_owner(text, path[:1], index):
        line, is_header, name = statement
        if is_header:
            inside = name == path
            if len(name) > len(path) and name[: len(path)] == path:
                yield _Statement(line, True, name[len(path) :])
        elif inside:
            yield statement


def _of_owner(text: str, owner: tuple[str, ...], index: int) -> Iterator[_Statement]:
    """The `index`-th table of that name with all that belongs to it; the whole file without a name."""
    seen, inside = -1, not owner
    for statement in _statements(text):
        if owner and statement.is_header:
            seen += statement.name == owner
            inside = seen == index and statement.name[:1] == owner
        if inside:
            yield statement


def _header_line(text: str, path: tuple[str, ...], index: int) -> int | None:
    """Line of a table's header; of its owner's, for a sub-table that has none."""
    headers = [statement for statement in _of_owner(text, path[:1], index) if statement.is_header]
    own = [header.line for header in headers if header.name == path]
    return next(iter(own + [header.line for header in headers]), None)


def _line_of_holder(text: str, name: str) -> int | None:
    """Line of the value above all tables that holds the tables of that name."""
    for statement in _statements(text):
        if statement.is_header:
            return None
        if statement.name[0] == name:
            return statement.line
    return None


def _statements(text: str) -> Iterator[_Statement]:
    """All of the file's statements, in its order; neither rows of an array nor lines of a text are any."""
    depth, start, line = 0, 0, 1
    for token in _TOKEN.finditer(text + "\n"):
        depth += {"[": 1, "{": 1, "]": -1, "}": -1}.get(token[0], 0)
        if token[0] == "\n" and depth == 0:
            written = text[start : token.start()]
            if found := _statement(written, line):
                yield found
            line += written.count("\n") + 1
            start = token.end()


def _statement(written: str, line: int) -> _Statement | None:
    """The parser itself takes the name apart, so that quotes and escapes mean what they do to it."""
    if written.lstrip().startswith("["):
        return _Statement(line, True, _names(tomllib.loads(written.strip())))
    if key := _KEY.match(written):
        return _Statement(line, False, _names(tomllib.loads(f"{key[0]} 0")))
    return None


def _names(parsed: object) -> tuple[str, ...]:
    """The keys from the outermost to the innermost of nested tables with one entry each."""
    names = []
    while isinstance(parsed, dict | list) and parsed:
        if isinstance(parsed, list):
            parsed = parsed[0]
        else:
            ((name, parsed),) = parsed.items()
            names.append(name)
    return tuple(names)
