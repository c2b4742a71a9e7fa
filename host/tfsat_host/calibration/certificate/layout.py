"""How values stand in a certificate, declared once for reading and writing.

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

from tfsat_host.calibration.steps.step import AXES
from tfsat_host.config import Table
from tfsat_host.config.table import shown

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
    """An array of that shape, or a number."""
    return Item(name, lambda table, key: table.array(key, *shape) if shape else table.number(key), si)


def deviation(name: str, si: float) -> Item:
    """A number, 0 or above."""
    return Item(name, partial(Table.number, least=0.0), si)


def whole(name: str, least: int, most: int) -> Item:
    """A whole number from `least` to `most`."""
    return Item(name, partial(Table.integer, least=least, most=most))


def text(name: str) -> Item:
    """A text, which may be empty."""
    return Item(name, partial(Table.text, empty=True))


def times(name: str) -> Item:
    """When each axis of a body was measured, for those that were."""

    def read(table: Table, key: str) -> dict[str, datetime]:
        inner = table.table(key, " ".join(AXES))
        return {axis: inner.time(axis) for axis in AXES if inner.has(axis)}

    return Item(name, read)


def read_values(table: Table, layout: Layout) -> dict[str, Any]:
    """The values of a table in SI, by the names of their items; None where an entry was left out.

    Raises:
        CalibrationError: at whatever is not as the layout says.
    """
    table.only(" ".join(layout).replace("?", ""))
    found: dict[str, Any] = {}
    for key, item in layout.items():
        name = key.rstrip("?")
        if name != key and not table.has(name):
            found |= dict.fromkeys(one.name for one in _items(item))
        elif isinstance(item, Item):
            value = item.read(table, name)
            found[item.name] = value * item.si if isinstance(value, float | np.ndarray) else value
        elif isinstance(item, Mapping):
            found |= read_values(table.table(name), item)
        elif (stated := table.value(name, str(item))) != item:
            table.fail(
                name,
                f"{shown(stated)} is not {item!r}, which this program writes and reads",
                f"Convert the values to {item!r} and name that here, or move this file away: "
                "a step of tfsat-host calibrate writes it again from its recordings.",
            )
    return found


def written_values(layout: Layout, values: Mapping[str, Any]) -> dict[str, Any]:
    """What `read_values` gives back, as it stands in the file; without what is not known: None, NaN, no time at all."""
    found = {}
    for key, item in layout.items():
        if isinstance(item, Item):
            value = _written(values[item.name], item.si)
        elif isinstance(item, Mapping):
            known = any(_written(values[one.name], one.si) is not None for one in _items(item))
            value = written_values(item, values) if known else None
        else:
            value = item
        if value is not None:
            found[key.rstrip("?")] = value
    return found


def _items(layout: Layout | Item) -> list[Item]:
    if isinstance(layout, Item):
        return [layout]
    return [item for item in layout.values() if isinstance(item, Item)]


def _written(value: Any, si: float | NDArray[np.float64]) -> Any:
    if isinstance(value, float | np.ndarray):
        rounded = _rounded((np.asarray(value) / si).tolist())
        return None if np.isnan(rounded).any() else rounded
    return None if value is None or value in ((), [], {}) else value


def _rounded(value: Any) -> Any:
    return [_rounded(item) for item in value] if isinstance(value, list) else float(f"{value:.{DIGITS}g}")
