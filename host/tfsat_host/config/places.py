"""Where each entry of a TOML text stands, which its parser does not tell."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from typing import NamedTuple

Path = tuple[str | int, ...]
"""Keys from the outermost table inwards, and indices from 0 in lists of tables: `("body", 1, "mass_kg")`."""
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


class Place(NamedTuple):
    """A statement of a text, its lines ended by line feeds.

    Attributes:
        line: On which it begins, from 1.
        start, end: Its characters, those around it on its lines included, but not the last line feed.
        whole: It is the entry itself: neither a header, nor an entry that only holds it or lies in it.
    """

    line: int
    start: int
    end: int
    whole: bool


def line_of(text: str, path: Path) -> int:
    """Line (from 1) of an entry; of the nearest that holds it if it has none of its own: `body = [`, a header.

    Args:
        text: A whole file that the parser took, its lines ended by line feeds.
        path: Of the entry; what lies above all tables and is not there counts as line 1.
    """
    places = places_of(text)
    return next((places[path[:n]].line for n in range(len(path), 0, -1) if path[:n] in places), 1)


def places_of(text: str) -> dict[Path, Place]:
    """Find the first statement of each table and entry.

    The `text` is as in `line_of`.
    """
    places: dict[Path, Place] = {}
    counts: dict[Path, int] = {}
    table: Path = ()
    for line, start, end in _statements(text):
        statement = text[start:end]
        is_header = statement.lstrip().startswith("[")
        # Parsed alone, a statement gives its path as nested keys, dots and quotes resolved.
        names, is_list = _names(tomllib.loads(statement))
        # Headers are absolute, entries relative to the header above them.
        place = () if is_header else table
        for number, name in enumerate(names, 1):
            place = (*place, name)
            places.setdefault(place, Place(line, start, end, not is_header and number == len(names)))
            if is_header and is_list and number == len(names):
                # Each [[header]] begins the next element of its list.
                counts[place] = counts.get(place, -1) + 1
            # What lies inside a list of tables belongs to its latest element, as TOML has it.
            if place in counts:
                place = (*place, counts[place])
                places.setdefault(place, Place(line, start, end, False))
        if is_header:
            table = place
    return places


def _statements(text: str) -> Iterator[tuple[int, int, int]]:
    """Line, first character and end of each header or entry; neither rows of an array nor lines of a text are any."""
    depth, start, line = 0, 0, 1
    for token in _TOKEN.finditer(text + "\n"):
        # Strings and comments are tokens as a whole, so every bracket seen here is one.
        depth += {"[": 1, "{": 1, "]": -1, "}": -1}.get(token[0], 0)
        if token[0] == "\n" and depth == 0:
            yield line, start, token.start()
            # Arrays and texts of several lines hold line feeds of their own.
            line += text.count("\n", start, token.start()) + 1
            start = token.end()


def _names(parsed: object) -> tuple[list[str], bool]:
    """Follow nested tables of one entry each.

    Returns:
        The keys from the outermost to the innermost table, and whether a list ends them.
    """
    names = []
    while isinstance(parsed, dict) and len(parsed) == 1:
        ((name, parsed),) = parsed.items()
        names.append(name)
    return names, isinstance(parsed, list)
