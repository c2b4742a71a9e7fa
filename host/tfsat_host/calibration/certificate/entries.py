"""Typed reading of a certificate's entries, with errors that name file, line, what is wrong and the cure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.toml_lines import line_of
from tfsat_host.toml_values import SHOWN_CHARACTERS, finite, shown

FloatArray = NDArray[np.float64]

UNREADABLE = "Without a certificate that can be read, nothing is known of the sensors' errors."
REWRITE = (
    "A step of tfsat-host calibrate writes the file anew from its recordings, if you move this one away."
)


class Entry:
    """One table of the certificate.

    Args:
        source: The file, as errors name it.
        text: All of the file.
        table: The table's name with dots; empty for what stands above all tables.
        index: Which one of that name, from 0.
        values: What was parsed.
        label: What the table is of, such as `the bias of body 2`; empty for the file itself.
    """

    def __init__(
        self, source: str, text: str, table: str, index: int, values: Mapping[str, object], label: str = ""
    ) -> None:
        self._source = source
        self._text = text
        self._table = table
        self._index = index
        self._values = values
        self.label = label

    def fail(self, key: str, problem: str, cure: str = REWRITE) -> NoReturn:
        """Raises the error at the entry `key`; `problem` is a sentence without its full stop."""
        line = line_of(self._text, self._table, self._index, key)
        where = self._source if line is None else f"{self._source}, line {line}"
        raise CalibrationError(what=f"{where}: {problem}.", meaning=UNREADABLE, next_step=cure)

    def allow(self, *keys: str) -> None:
        """Refuses every other key: a misspelt one must not be silently ignored."""
        for key in self._values:
            if key not in keys:
                known = f"known are {', '.join(keys)}"
                self.fail(key, f"{self._of(shown(key))} is not known; {known}", f"Remove {shown(key)}.")

    def has(self, key: str) -> bool:
        """Whether there is such an entry."""
        return key in self._values

    def require(self, key: str) -> object:
        """The raw value of an entry that must be there."""
        if key not in self._values:
            self.fail(key, f"{self._of(key)} is missing")
        return self._values[key]

    def expect(self, **named: object) -> None:
        """Refuses a unit, frame or order that is not ours: numbers in another one would be taken for ours."""
        for key, ours in named.items():
            found = self.require(key)
            if found != ours:
                verb = "counts in" if key == "frame" else "is in" if key == "unit" else f"has the {key}"
                self.fail(
                    key,
                    f"{self.label} {verb} {_plain(found)}; this program writes and reads {_plain(ours)}",
                    f"Convert the values to {_plain(ours)} and name that here. {REWRITE}",
                )

    def table(self, key: str, label: str) -> Entry:
        """A table inside of this one."""
        value = self.require(key)
        if not isinstance(value, dict):
            self.fail(key, f"{self._of(key)} is no table")
        name = f"{self._table}.{key}" if self._table else key
        return Entry(self._source, self._text, name, self._index, value, label)

    def tables(self, key: str) -> list[Entry]:
        """All `[[key]]` tables; none is an empty list."""
        value = self._values.get(key, [])
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            self.fail(key, f"{key} is no list of tables: each stands below its own line [[{key}]]")
        return [
            Entry(self._source, self._text, key, index, item, f"{key} {index + 1}")
            for index, item in enumerate(value)
        ]

    def text(self, key: str) -> str:
        """A text, which may be empty."""
        value = self.require(key)
        if not isinstance(value, str):
            self.fail(key, f"{self._of(key)} is {shown(value)}, not a text in quotes")
        return value

    def flag(self, key: str) -> bool:
        """True or false."""
        value = self.require(key)
        if not isinstance(value, bool):
            self.fail(key, f"{self._of(key)} is {shown(value)}, not true or false")
        return value

    def whole(self, key: str, least: int, most: int) -> int:
        """A whole number from `least` to `most`."""
        value = self.require(key)
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            self.fail(key, f"{self._of(key)} is {shown(value)}, not a whole number from {least} to {most}")
        return value

    def number(self, key: str) -> float:
        """A finite number."""
        return float(self.array(key, ()))

    def deviation(self, key: str) -> float:
        """A finite number, 0 or above."""
        value = self.number(key)
        if value < 0.0:
            self.fail(key, f"{self._of(key)} is {value:g}: none is negative")
        return value

    def time(self, key: str) -> datetime:
        """With its time zone, in UTC."""
        value = self.require(key)
        if not isinstance(value, datetime):
            self.fail(key, f"{self._of(key)} is {shown(value)}, not a time such as 2026-07-01T09:30:00Z")
        if value.tzinfo is None:
            self.fail(key, f"{self._of(key)} is a time without a time zone", "Add one: Z stands for UTC.")
        return value.astimezone(UTC)

    def time_or_none(self, key: str) -> datetime | None:
        """Likewise; None if it was left out: never measured."""
        return self.time(key) if self.has(key) else None

    def times(self, key: str, names: Sequence[str]) -> dict[str, datetime]:
        """A time for some of `names`, in their order; none if it was left out: never measured."""
        if not self.has(key):
            return {}
        inner = self.table(key, self._of(key))
        for name in inner._values:
            if name not in names:
                cure = f"Remove {shown(name)}."
                self.fail(
                    key, f"{self._of(key)} names {shown(name)}, which is none of {', '.join(names)}", cure
                )
        return {name: inner.time(name) for name in names if inner.has(name)}

    def array(self, key: str, shape: tuple[int, ...]) -> FloatArray:
        """Finite numbers in rows, as many as `shape` says."""
        value = self.require(key)
        numbers = _numbers(value, shape)
        if numbers is None:
            wanted = " x ".join(map(str, shape)) + " finite numbers" if shape else "a finite number"
            self.fail(key, f"{self._of(key)} is {shown(value)}, not {wanted}")
        return np.array(numbers, dtype=np.float64).reshape(shape)

    def _of(self, key: str) -> str:
        return f"{key} of {self.label}" if self.label else key


def _numbers(value: object, shape: tuple[int, ...]) -> list[float] | None:
    """Row by row; None if one is none, or they are too few or too many."""
    if not shape:
        number = finite(value)
        return None if number is None else [number]
    if not isinstance(value, list) or len(value) != shape[0]:
        return None
    found: list[float] = []
    for item in value:
        row = _numbers(item, shape[1:])
        if row is None:
            return None
        found += row
    return found


def _plain(value: object) -> str:
    """As a person says it: `deg/s`, not `'deg/s'`."""
    if isinstance(value, list):
        return ", ".join(_plain(item) for item in value)
    return value if isinstance(value, str) and 0 < len(value) <= SHOWN_CHARACTERS else shown(value)
