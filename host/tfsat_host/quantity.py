"""What the columns of a result are: key, label, unit, and how value and standard deviation are taken; declared once.

A name ends with its unit, as everywhere in this code: `size_deg` is in degrees. A column takes its value from the
attribute of its own name, or from that of the same stem in SI units: `size_deg` from `size_rad`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from enum import Enum
from functools import reduce
from pathlib import PurePath
from typing import Any

UNKNOWN = "–"
_MAX_DECIMALS = 6
_PER_RAD = 180.0 / math.pi

UNITS: Mapping[str, tuple[str, str, float]] = {
    "deg": ("deg", "rad", _PER_RAD),
    "deg_s": ("deg/s", "rad_s", _PER_RAD),
    "deg_s2": ("deg/s^2", "rad_s2", _PER_RAD),
    "ms": ("ms", "s", 1e3),
    "us": ("us", "s", 1e6),
    "s": ("s", "s", 1.0),
    "mm": ("mm", "m", 1e3),
    "mm_s": ("mm/s", "m_s", 1e3),
    "percent": ("%", "share", 1e2),
    "ppm": ("ppm", "ppm", 1.0),
    "g": ("g", "g", 1.0),
    "kg": ("kg", "kg", 1.0),
    "g_m2": ("g m^2", "kg_m2", 1e3),
    "hz": ("Hz", "hz", 1.0),
    "kg_m2_s": ("kg m^2/s", "kg_m2_s", 1.0),
}
"""By the end of a name: what people read, the end of the name in SI units, and how many of the unit make one of SI."""
# How many of each unit make one of SI; the units of SI themselves are 1.
_FACTORS = {si: 1.0 for _, si, _ in UNITS.values()} | {unit: factor for unit, (_, _, factor) in UNITS.items()}

Source = str | Callable[[Any], Any]


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number as people read it.

    Attributes:
        value: In `unit`; NaN where it is unknown.
        std: Its standard deviation, in `unit`; None: it has none. NaN: it is unknown.
        unit: As people write it; may be empty.
        form: How the value is written where no standard deviation says with how many decimals: a format of `format`.
            Begins with + where the sign is written of a positive number, too.
        label: What it is.
        note: What else one has to know; may be empty.
        group: Numbers of the same group stand side by side under its name.
    """

    value: float
    std: float | None = None
    unit: str = ""
    form: str = ".3f"
    label: str = ""
    note: str = ""
    group: str = ""

    def text(self, unknown: str = UNKNOWN) -> str:
        """Without label and unit."""
        if self.std is None:
            return number(self.value, self.form, unknown)
        return plus_minus(self.value, self.std, sign=self.form.startswith("+"), unknown=unknown)


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a table, for all who show or write it.

    Attributes:
        key: In JSON, with the unit at its end; empty: for people only.
        label: Over the column, for people, without the unit; empty: in JSON only.
        of: Attribute of a row (`pair.event` is one of its attribute's, None where that is), or a function of the row
            that gives the value in the key's unit; by default the attribute of the key's stem.
        std: The same of its standard deviation. In JSON it is `<key>_std`.
        form: See `Quantity`.
        shown_in: Unit for people by the end of a name (see `UNITS`) if it is not the key's.
        words: What people read of a row instead of the number.
        columns: Of the row, or rows, that the value is; a function that chooses them by the row where rows differ.
    """

    key: str
    label: str = ""
    of: Source = ""
    std: Source = ""
    form: str = ".3f"
    shown_in: str = ""
    words: Callable[[Any], str] | None = None
    columns: tuple[Column, ...] | Callable[[Any], tuple[Column, ...]] = ()

    @property
    def unit(self) -> str:
        """As people read it; empty for what has none."""
        unit = self.shown_in or unit_of(self.key)
        return UNITS[unit][0] if unit in UNITS else ""

    def value(self, row: Any) -> Any:
        """Return the column's value of a row, in the key's unit.

        If the row is a mapping, the value under the key.
        """
        return row[self.key] if isinstance(row, Mapping) else self._take_value(self.of or self.key, row)

    def std_of(self, row: Any) -> Any:
        """Return the standard deviation in the key's unit; None: the column has none."""
        if not self.std:
            return None
        return row.get(f"{self.key}_std") if isinstance(row, Mapping) else self._take_value(self.std, row)

    def cell(self, row: Any) -> Quantity | str:
        """Format the column's value of a row for people."""
        if self.words is not None:
            return self.words(row)
        value = self.value(row)
        if isinstance(value, bool) or (value is None and not self.unit):
            return {True: "yes", False: "no", None: UNKNOWN}[value]
        if isinstance(value, str | int):
            return str(value)
        factor = _ratio(unit_of(self.key), self.shown_in)
        std = self.std_of(row)
        if isinstance(value, list) and all(isinstance(element, PurePath) for element in value):
            return ", ".join(map(str, value))
        if hasattr(value, "__len__"):
            return vector(
                [factor * element for element in value], None if std is None else factor * std, self.form
            )
        # A deviation that should be there and is not is unknown, which is not the same as exact.
        if self.std and std is None:
            std = math.nan
        return Quantity(
            math.nan if value is None else factor * float(value),
            None if std is None else factor * float(std),
            self.unit,
            self.form,
            self.label,
        )

    def _take_value(self, source: Source, row: Any) -> Any:
        if callable(source):
            return source(row)
        unit = unit_of(self.key)
        # By convention size_deg is made of size_rad: exchange the unit at the end of the name.
        if source == self.key and unit in UNITS and not hasattr(row, source):
            source = f"{self.key.removesuffix(unit)}{UNITS[unit][1]}"
        # A dotted name leads through attributes of attributes; where one of them is None, so is the value.
        value = reduce(lambda of, name: of if of is None else getattr(of, name), source.split("."), row)
        factor = _ratio(unit_of(source), unit)
        return value if factor == 1.0 or value is None else value * factor + 0.0  # no minus zero


Columns = tuple[Column, ...]
ColumnChoice = Columns | Callable[[Any], Columns]
"""The columns of a row, or the function that chooses them by the row."""


def fields(names: str) -> Columns:
    """Columns of JSON only: `key`, or `key=attribute`, by spaces."""
    pairs = (name.partition("=") for name in names.split())
    return tuple(Column(key, of=attribute) for key, _, attribute in pairs)


def columns_of(attribute: str, columns: Columns) -> Columns:
    """Return columns of what a row has under an attribute, as columns of that row."""

    def move(column: Column) -> Column:
        words = column.words
        return replace(
            column,
            of=lambda row: column.value(getattr(row, attribute)),
            std=(lambda row: column.std_of(getattr(row, attribute))) if column.std else "",
            words=None if words is None else lambda row: words(getattr(row, attribute)),
        )

    return tuple(map(move, columns))


@dataclass(frozen=True, slots=True)
class Table:
    """Rows under columns, for people.

    Attributes:
        title: Above.
        columns: Those without a label are not shown.
        rows: Objects with what the columns take, or mappings of their keys.
        caption: What one has to know to read it.
        folded: How many of the last rows may be folded away.
        fold: Under these words.
        below: Labels of columns that have no room beside the others on a terminal: they form a second table there.
    """

    title: str
    columns: Columns
    rows: Sequence[Any]
    caption: str = ""
    folded: int = 0
    fold: str = ""
    below: tuple[str, ...] = ()

    @property
    def shown(self) -> Columns:
        """The columns for people."""
        return tuple(column for column in self.columns if column.label)


def unit_of(name: str) -> str:
    """Return the unit at the end of a name; empty: it has none."""
    # The longest end counts: mm_s ends with s as well.
    ends = (unit for unit in _FACTORS if f"_{name}".endswith(f"_{unit}"))
    return max(ends, key=len, default="")


def number(value: float, form: str = ".3f", unknown: str = UNKNOWN) -> str:
    """Format a number, without a sign if it rounds to zero."""
    if not math.isfinite(value):
        return unknown
    # A number that rounds to zero has no sign: -0.000 would suggest a direction.
    text = format(float(value), form)
    return text if any(digit in text for digit in "123456789") else text.lstrip("+-")


def plus_minus(value: float, std: float, *, sign: bool = False, unknown: str = "unknown") -> str:
    """`27.978 ± 0.014`: as many decimals as the standard deviation has a meaning with, two digits of it."""
    if not math.isfinite(value):
        return unknown
    form = f".{decimals_of(std)}f"
    return f"{number(value, f'+{form}' if sign else form)} ± {number(std, form, unknown)}"


def vector(values: Iterable[float], std: Iterable[float] | None = None, form: str = ".3f") -> str:
    """Components side by side, and where there are standard deviations the greatest of them."""
    if std is None:
        return " ".join(number(value, form) for value in values)
    # One deviation for all components: the greatest bounds each of them.
    greatest = max(std)
    decimals = f".{decimals_of(greatest)}f"
    signed = f"+{decimals}" if form.startswith("+") else decimals
    return f"{' '.join(number(value, signed) for value in values)} ± {number(greatest, decimals)}"


def decimals_of(std: float) -> int:
    """Return the decimals that show two significant digits of `std`; 2 if it is not finite and positive."""
    if not math.isfinite(std) or std <= 0.0:
        return 2
    return min(max(1 - math.floor(math.log10(std)), 0), _MAX_DECIMALS)


def _ratio(source: str, target_unit: str) -> float:
    """Return the factor from the source unit to the wanted one; 1 if either is empty."""
    if source == target_unit or not source or not target_unit:
        return 1.0
    return _FACTORS[target_unit] / _FACTORS[source]


def record(columns: ColumnChoice, row: Any) -> dict[str, Any]:
    """Return a row as a JSON object.

    NaN stays; arrays become lists, choices their names in small letters, times their ISO text, bytes hexadecimal.
    """
    entries: dict[str, Any] = {}
    for column in columns(row) if callable(columns) else columns:
        if not column.key:
            continue
        value = column.value(row)
        entries[column.key] = json_objects(column.columns, value) if column.columns else _plain(value)
        if column.std:
            entries[f"{column.key}_std"] = _plain(column.std_of(row))
    return entries


def records(columns: ColumnChoice, rows: Iterable[Any]) -> list[dict[str, Any]]:
    """Return each row as a JSON object."""
    return [record(columns, row) for row in rows]


def by_name(columns: ColumnChoice) -> Callable[[Mapping[str, Any]], Columns]:
    """Return the columns of a mapping, whose rows have the same columns each."""
    return lambda rows: tuple(Column(name, columns=columns) for name in rows)


def json_objects(columns: ColumnChoice, value: Any) -> Any:
    """Return one row as a JSON object, a list or tuple of rows as a list of them, and None as None."""
    if value is None:
        return None
    # A named tuple is one row.
    rows = isinstance(value, list | tuple) and not hasattr(value, "_fields")
    return records(columns, value) if rows else record(columns, value)


def _plain(value: Any) -> Any:
    if isinstance(value, Enum):
        return value.name.lower()
    if isinstance(value, datetime):
        return value.isoformat()
    if isinstance(value, bytes):
        return value.hex()
    if hasattr(value, "tolist"):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value
