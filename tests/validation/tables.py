"""Tables of a campaign: written as CSV, shown in Markdown."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Sequence
from enum import Enum
from pathlib import Path
from typing import Any

_NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?( %)?|–|")
MET = "met"
"""Name of the column that says whether a target is met: yes or no."""


def csv_text(columns: Sequence[object], rows: Iterable[Sequence[object]]) -> str:
    """Return a table as CSV, each value as `cell` shows it."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(map(cell, row) for row in (columns, *rows))
    return text.getvalue()


def results_csv(results: Sequence[Any]) -> str:
    """Return named tuples of one type as CSV, a row each."""
    return csv_text(results[0]._fields, results)


def read_rows(path: Path, selected: str = "") -> list[list[str]]:
    """Return the column names and rows of a CSV file.

    Args:
        path: The file.
        selected: Only the rows whose first column says so, without that column; empty: all.

    Raises:
        ValueError: No row does.
    """
    with path.open(newline="", encoding="utf-8") as file:
        columns, *rows = csv.reader(file)
    if not selected:
        return [columns, *rows]
    chosen = [row[1:] for row in rows if row[0] == selected]
    if not chosen:
        raise ValueError(f"{path.name} has no row of {selected!r}")
    return [columns[1:], *chosen]


def markdown_table(rows: Sequence[Sequence[str]]) -> str:
    """Return a table in Markdown, columns of numbers to the right; the first row names the columns."""
    columns, *values = rows
    rules = [
        "--:" if all(_NUMBER.fullmatch(row[k]) for row in values) else "---" for k in range(len(columns))
    ]
    formatted_rows = [
        [
            "**no**" if name == MET and value == "no" else value
            for name, value in zip(columns, row, strict=True)
        ]
        for row in values
    ]
    return "".join(f"| {' | '.join(line)} |\n" for line in (columns, rules, *formatted_rows))


def cell(value: object) -> str:
    """Return a value as tables show it: numbers to four decimals, enumerations by their words."""
    if isinstance(value, Enum):
        return value.value if isinstance(value.value, str) else value.name.lower()
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value + 0.0:.4f}".rstrip("0").rstrip(".")
    if type(value) is tuple:
        return " ".join(map(cell, value))
    return str(value)
