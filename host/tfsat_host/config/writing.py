"""The text of a TOML file: people read it, and `config.reading` gives back what was written without loss."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime

_Comments = Mapping[str, str]


def format_config(
    values: Mapping[str, object], heading: str = "", comments: Mapping[str, str] | None = None
) -> str:
    """The text of a file.

    Args:
        values: By key, in their order; what is None is left out. Tables and lists of tables have headers, to the
            second level; deeper ones stand in braces.
        heading: Comments above all, a line each.
        comments: What to write behind the entries of these keys, wherever they are.
    """
    top, *tables = _blocks("", values, comments or {})
    top = [*(f"# {line}" for line in heading.splitlines()), *top]
    return "\n\n".join("\n".join(block) for block in (top, *tables)) + "\n"


def _blocks(name: str, values: Mapping[str, object], comments: _Comments) -> Iterator[list[str]]:
    """The lines of a table's entries, then of each table inside of it."""
    tables = {}
    lines = []
    for key, value in values.items():
        inner = f"{name}.{key}" if name else key
        if name.count(".") == 0 and isinstance(value, Mapping):
            tables[f"[{inner}]"] = [value]
        elif not name and isinstance(value, list) and value and isinstance(value[0], Mapping):
            tables[f"[[{inner}]]"] = value
        elif value is not None:
            lines.append(f"{key} = {_text(value)}" + (f"  # {comments[key]}" if key in comments else ""))
    yield lines
    for header, items in tables.items():
        for item in items:
            first, *more = _blocks(header.strip("[]"), item, comments)
            yield [header, *first]
            yield from more


def _text(value: object) -> str:
    """A float as the shortest text that gives it back; a matrix with a line for each of its rows."""
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
