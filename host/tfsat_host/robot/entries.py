"""Typed reading of a robot file's entries, with errors that name file, line, entry and cure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NoReturn

import numpy as np

from tfsat_host.robot.errors import RobotFileError
from tfsat_host.robot.model import FloatArray
from tfsat_host.toml_lines import has_header, line_of
from tfsat_host.toml_values import finite, shown


class Entry:
    """One table of the file: hands out its values by type and remembers which keys were asked for."""

    def __init__(
        self,
        path: Path,
        text: str,
        table: str,
        index: int,
        values: Mapping[str, object],
        label: str | None = None,
    ) -> None:
        self._path = path
        self._text = text
        self._table = table
        self._index = index
        self._values = values
        self._label = label or (f"{table} {index + 1}" if table else "")
        self._known: set[str] = set()

    def fail(self, key: str, problem: str, cure: str) -> NoReturn:
        """Raise the error for `key` of this entry."""
        line = line_of(self._text, self._table, self._index, key)
        where = f"{self._path}:{line}" if line is not None else str(self._path)
        entry = f"{self._label}, {key}" if self._label else key
        raise RobotFileError(
            what=f"{where}: {entry}: {problem}.",
            meaning="Without a valid robot model no maneuver can be designed, flown or judged.",
            next_step=cure,
        )

    def has(self, key: str) -> bool:
        """Whether `key`, which may be left out, is there."""
        self._known.add(key)
        return key in self._values

    def value(self, key: str, kind: str) -> object:
        """The raw value of `key`; `kind` says what is expected, for the error."""
        self._known.add(key)
        if key not in self._values:
            self.fail(key, "is missing", f"Add `{key} = ` with {kind}.")
        return self._values[key]

    def number(self, key: str) -> float:
        """A finite number."""
        value = self.value(key, "a number")
        number = finite(value)
        if number is None:
            self.fail(key, f"{shown(value)} is not a finite number", f"Give `{key}` a number.")
        return number

    def positive(self, key: str) -> float:
        """A number above zero."""
        value = self.number(key)
        if value <= 0.0:
            self.fail(key, f"{value:g} is not positive", f"Give `{key}` a number above zero.")
        return value

    def deviation(self, key: str, greatest: float = math.inf) -> float:
        """A standard deviation: a number from 0 to `greatest`; 0 if it is left out."""
        value = self.number(key) if self.has(key) else 0.0
        if value < 0.0:
            self.fail(key, f"{value:g} is negative", f"Give `{key}` a standard deviation, 0 or above.")
        if value > greatest:
            self.fail(key, f"{value:g} is above {greatest:g}", f"Give `{key}` at most {greatest:g}.")
        return value

    def integer(self, key: str, allowed: Iterable[int]) -> int:
        """One of `allowed`."""
        choices = tuple(allowed)
        value = self.value(key, "an integer")
        if isinstance(value, bool) or not isinstance(value, int) or value not in choices:
            listed = ", ".join(map(str, choices)) if len(choices) <= 8 else f"{choices[0]} to {choices[-1]}"
            self.fail(key, f"{shown(value)} is not allowed", f"Give `{key}` one of: {listed}.")
        return value

    def text(self, key: str) -> str:
        """A non-empty string."""
        value = self.value(key, "a text in quotes")
        if not isinstance(value, str) or not value:
            self.fail(key, f"{shown(value)} is not a text", f'Write `{key} = "..."`.')
        return value

    def vector(self, key: str, length: int = 3) -> FloatArray:
        """(length,) finite numbers."""
        value = self.value(key, f"{length} numbers in brackets")
        numbers = [finite(x) for x in value] if isinstance(value, list) else []
        if len(numbers) != length or None in numbers:
            problem = f"{shown(value)} is not a list of {length} numbers"
            self.fail(key, problem, f"Give `{key}` {length} numbers.")
        return np.array(numbers, dtype=np.float64)

    def matrix(self, key: str) -> FloatArray:
        """(3, 3) finite numbers, written as three rows."""
        rows = self.value(key, "three rows of three numbers")
        if not isinstance(rows, list) or len(rows) != 3:
            self.fail(key, "is not a list of three rows", f"Give `{key}` three rows of three numbers.")
        return np.array([self._holding(key, row).vector(key) for row in rows])

    def boxes(self, key: str) -> list[tuple[FloatArray, FloatArray]]:
        """One or more boxes, each as its lowest and its highest corner; none if `key` is left out."""
        if not self.has(key):
            return []
        boxes = self.value(key, "boxes")
        cure = f"Write `{key} = [[[xmin, ymin, zmin], [xmax, ymax, zmax]]]`, one pair of corners a box."
        if not isinstance(boxes, list) or not boxes:
            self.fail(key, "is not a list of boxes", cure)
        pairs: list[tuple[FloatArray, FloatArray]] = []
        for box in boxes:
            if not isinstance(box, list) or len(box) != 2:
                self.fail(key, f"{shown(box)} is not a pair of corners", cure)
            low, high = (self._holding(key, corner).vector(key) for corner in box)
            if not (low < high).all():
                self.fail(key, f"{shown(box)} has no volume", "Write each box's lowest corner first.")
            pairs.append((low, high))
        return pairs

    def table(self, key: str) -> Entry:
        """A table inside this one."""
        value = self.value(key, "a table")
        if not isinstance(value, dict):
            self.fail(key, f"{shown(value)} is not a table", f"Write `{key}` as a table of named values.")
        header = f"{self._table}.{key}" if self._table else key
        if not has_header(self._text, header, self._index):
            return InlineEntry(self, key, value)
        return Entry(self._path, self._text, header, self._index, value, None if self._table else header)

    def tables(self, key: str) -> list[Entry]:
        """All `[[key]]` tables; none is an empty list."""
        self._known.add(key)
        value = self._values.get(key, [])
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            self.fail(key, "is not a list of tables", f"Write each one below its own line `[[{key}]]`.")
        return [Entry(self._path, self._text, key, i, item) for i, item in enumerate(value)]

    def _holding(self, key: str, value: object) -> Entry:
        """This entry with another value of `key`: one of the list that it holds."""
        return Entry(self._path, self._text, self._table, self._index, {key: value}, self._label)

    def done(self) -> None:
        """Refuse keys that nobody asked for: a misspelt entry must not be silently ignored."""
        for key in self._values:
            if key not in self._known:
                known = ", ".join(sorted(self._known))
                self.fail(key, "is not known here", f"Remove it or correct its name; known are: {known}.")


class InlineEntry(Entry):
    """A table written in braces on its owner's line."""

    def __init__(self, owner: Entry, key: str, values: Mapping[str, object]) -> None:
        super().__init__(owner._path, owner._text, owner._table, owner._index, values)
        self._owner = owner
        self._key = key

    def fail(self, key: str, problem: str, cure: str) -> NoReturn:
        """Raise the error for `key` of this table, at its owner's line."""
        self._owner.fail(f"{self._key}.{key}", problem, cure)
