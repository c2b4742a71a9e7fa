"""How a table of a certificate is laid out: declared once for reading and writing, and how its numbers are checked.

A layout has the keys of a table in their order; one that ends in `?` may be left out: its values were never measured.
To each key belongs an `Item`, the layout of a table inside, or a text or list that must stand there: a unit, a frame.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.steps.step import AXES
from tfsat_host.config import Table
from tfsat_host.config.table import shorten_value

DIGITS: Final = 12
"""Of every number: far below every uncertainty, and 0.02 stays 0.02."""
Layout = Mapping[str, Any]


@dataclass(frozen=True)
class Item:
    """One entry.

    Attributes:
        name: Of its value in memory.
        read: Takes it from its table, by its key.
        si: What one of the file's units is in SI.
    """

    name: str
    read: Callable[[Table, str], Any]
    si: float | NDArray[np.float64] = 1.0


def numbers(name: str, *shape: int, si: float | NDArray[np.float64] = 1.0) -> Item:
    """Build the item of an array of that shape, or of a number if no shape is given."""
    return Item(name, lambda table, key: table.array(key, *shape) if shape else table.number(key), si)


def deviation(name: str, si: float) -> Item:
    """Build the item of a standard deviation: a number, 0 or above."""
    return Item(name, partial(Table.number, least=0.0), si)


def whole(name: str, least: int, most: int) -> Item:
    """Build the item of a whole number from `least` to `most`."""
    return Item(name, partial(Table.integer, least=least, most=most))


def text(name: str) -> Item:
    """Build the item of a text, which may be empty."""
    return Item(name, partial(Table.text, empty=True))


def times(name: str) -> Item:
    """Build the item of the times at which a body's axes were measured, for those that were."""

    def read(table: Table, key: str) -> dict[str, datetime]:
        inner = table.table(key, " ".join(AXES))
        return {axis: inner.time(axis) for axis in AXES if inner.has(axis)}

    return Item(name, read)


def read_values(table: Table, layout: Layout) -> dict[str, Any]:
    """Read a table's values in SI units, by item name; None for an omitted entry.

    Raises:
        CalibrationError: an entry does not match the layout.
    """
    # Unknown keys first: a misspelt optional one would otherwise pass as never measured.
    table.only(" ".join(layout).replace("?", ""))
    values: dict[str, Any] = {}
    for key, item in layout.items():
        name = key.rstrip("?")
        if name != key and not table.has(name):
            # An optional table that is absent: none of its values was measured.
            values |= dict.fromkeys(leaf.name for leaf in _items(item))
        elif isinstance(item, Item):
            value = item.read(table, name)
            values[item.name] = value * item.si if isinstance(value, float | np.ndarray) else value
        elif isinstance(item, Mapping):
            values |= read_values(table.table(name), item)
        elif (stated := table.value(name, str(item))) != item:
            # A unit, frame or order must stand as written: converting silently would guess.
            table.fail(
                name,
                f"{shorten_value(stated)} is not {item!r}, which this program writes and reads",
                f"Convert the values to {item!r} and name that here, or move this file away: "
                "a step of tfsat-host calibrate writes it again from its recordings.",
            )
    return values


def written_values(layout: Layout, values: Mapping[str, Any]) -> dict[str, Any]:
    """Convert values to a table in the file's units, the inverse of `read_values`.

    Unknown values are omitted: None, NaN, no time at all.
    """
    entries = {}
    for key, item in layout.items():
        if isinstance(item, Item):
            value = _format_value(values[item.name], item.si)
        elif isinstance(item, Mapping):
            # A table of units without a value is left out as a whole.
            has_values = any(_format_value(values[leaf.name], leaf.si) is not None for leaf in _items(item))
            value = written_values(item, values) if has_values else None
        else:
            value = item
        if value is not None:
            entries[key.rstrip("?")] = value
    return entries


def _items(layout: Layout | Item) -> list[Item]:
    if isinstance(layout, Item):
        return [layout]
    return [item for item in layout.values() if isinstance(item, Item)]


def _format_value(value: Any, si: float | NDArray[np.float64]) -> Any:
    if isinstance(value, float | np.ndarray):
        # A NaN anywhere means not measured: the array is left out rather than written in part.
        rounded = _round_values((np.asarray(value) / si).tolist())
        return None if np.isnan(rounded).any() else rounded
    return None if value is None or value in ((), [], {}) else value


def _round_values(value: Any) -> Any:
    return (
        [_round_values(item) for item in value] if isinstance(value, list) else float(f"{value:.{DIGITS}g}")
    )


ROUNDING = 1e-6
"""So far may a number that a person copied differ from what follows from another: more digits say nothing."""


def covariance(entry: Table, key: str, written: FloatArray) -> FloatArray:
    """Check the covariance (n, n) read from `key` and return it exactly symmetric.

    Raises:
        CalibrationError: it is not symmetric, or not positive.
    """
    variances = np.diag(written)
    if (variances < 0.0).any():
        entry.fail(key, "the covariance has a negative variance")
    # Compare relative to the deviations: the entries have different units.
    size = np.sqrt(np.outer(variances, variances))
    if (np.abs(written - written.T) > ROUNDING * size).any():
        entry.fail(key, "the covariance is not symmetric")
    # Correlations are free of units, so that one tolerance fits all eigenvalues.
    scaled = np.divide(written, size, out=np.zeros_like(written), where=size > 0.0)
    if (written[size == 0.0] != 0.0).any() or np.linalg.eigvalsh(scaled).min() < -ROUNDING:
        entry.fail(key, "the covariance is not positive: no errors can vary like that")
    return np.asarray((written + written.T) / 2.0)


def check_std(entry: Table, key: str, stated: FloatArray, derived: FloatArray) -> None:
    """Refuses a std that is not the covariance's: one of them was changed by hand; both in the file's units.

    Raises:
        CalibrationError: they differ.
    """
    if not np.allclose(stated, derived, rtol=ROUNDING, atol=0.0):
        derived_text = " ".join(f"{value:.6g}" for value in np.atleast_1d(derived))
        entry.fail(key, f"is not what its covariance says ({derived_text})")


def check_rotation(entry: Table, key: str, matrix: FloatArray) -> None:
    """Refuses a matrix (3, 3) that is no proper rotation.

    Raises:
        CalibrationError: its rows are not orthogonal, not of length 1, or mirrored.
    """
    if np.abs(matrix @ matrix.T - np.eye(3)).max() > ROUNDING:
        entry.fail(key, "is no rotation: its rows are not perpendicular and of length 1")
    if np.linalg.det(matrix) < 0.0:
        entry.fail(key, "is no rotation but a mirror: two of its rows may be exchanged")
