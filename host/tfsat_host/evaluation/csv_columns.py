"""Rows of a CSV file that a person typed or a tracking program wrote, read by the names of its columns.

What cannot be read is refused with file, line, column and cure; see `CsvForm.fail`.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from tfsat_host.errors import TfsatError

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_SHOWN = 40
"""Characters of a wrong cell that a message shows: a damaged file may hold a line of millions."""


@dataclass(frozen=True, slots=True)
class CsvForm:
    """What a file is to hold, and what it means if it does not.

    Attributes:
        path: The file.
        subject: What it is, in words.
        required: Columns that must be there; others are free.
        meaning: What cannot be told without it.
        error: What is raised.
    """

    path: Path
    subject: str
    required: tuple[str, ...]
    meaning: str
    error: type[TfsatError]

    def fail(self, what: str, next_step: str, line: int | None = None) -> NoReturn:
        """Raises `error`; `what` is led by the file, and the line if one is to blame."""
        where = f"{self.path}:{line}" if line is not None else f"{self.path}"
        raise self.error(what=f"{where}: {what}", meaning=self.meaning, next_step=next_step)


@dataclass(frozen=True, slots=True)
class CsvRow:
    """One row; cells without their surrounding blanks, missing ones empty."""

    form: CsvForm
    line: int
    cells: dict[str, str]

    def text(self, column: str) -> str:
        """The cell; empty where the file has no such column."""
        return self.cells.get(column, "")

    def number(self, column: str, *, largest: float, above: float | None = None) -> float:
        """A finite number of magnitude `largest` at most, greater than `above` if that is given."""
        cell = self.text(column)
        if not _NUMBER.fullmatch(cell):
            shown = repr(cell[:_SHOWN]) if cell else "missing"
            cure = "Write a number there, with a point for the decimals, or leave out the whole row."
            self.form.fail(f"{column} is {shown}.", cure, self.line)
        value = float(cell)
        if abs(value) > largest:
            self.form.fail(
                f"{column} is {value:g}, beyond {largest:g}.",
                "Correct the number or its unit, or leave out the whole row.",
                self.line,
            )
        if above is not None and not value > above:
            self.form.fail(
                f"{column} is {value:g}; it must be above {above:g}.",
                f"Correct it, or leave the column {column} out.",
                self.line,
            )
        return value


def read_rows(form: CsvForm) -> list[CsvRow]:
    """All rows below the header that are not blank.

    Raises:
        TfsatError: of the form's kind; the file cannot be read, or a column is missing or there twice.
    """
    try:
        with form.path.open(encoding="utf-8-sig", newline="") as file:
            return list(_rows(form, file))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is no text in UTF-8"
        form.fail(f"The {form.subject} cannot be read: {reason}.", "Give the path of a CSV file.")
    except csv.Error as error:
        form.fail(f"this is no CSV file: {error}.", f"Begin it with the line {','.join(form.required)}")


def _rows(form: CsvForm, file: Iterable[str]) -> Iterator[CsvRow]:
    rows = csv.reader(file, strict=True)
    names = [name.strip() for name in next(rows, [])]
    for name in form.required:
        if name not in names:
            cure = f"Begin the file with the line {','.join(form.required)} and separate columns by commas."
            form.fail(f"there is no column {name}.", cure, 1)
    for name in names:
        if name and names.count(name) > 1:
            cure = "Keep the one that is meant, and rename or remove the other."
            form.fail(f"the column {name[:_SHOWN]} is there {names.count(name)} times.", cure, 1)
    for row in rows:
        if any(cell.strip() for cell in row):
            cells = (cell.strip() for cell in row)
            yield CsvRow(form, rows.line_num, dict(zip(names, cells, strict=False)))
