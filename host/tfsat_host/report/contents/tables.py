"""Declared tables and quantities as parts of the page's document."""

from __future__ import annotations

import math
import re
from typing import Any

from tfsat_host import quantity
from tfsat_host.quantity import Column, Quantity
from tfsat_host.report.document import Fold, KeyNumber, Table

_HYPHEN = re.compile(r"(?:(?<=^)|(?<=[\s(]))-(?=\d)|(?<=\de)-(?=\d)")
"""Before a number, or its power of ten."""


def table(shown: quantity.Table) -> Table:
    """As the page shows it."""
    columns = shown.shown
    made = Table(
        title=shown.title,
        columns=[f"{one.label} ({one.unit})" if one.unit else one.label for one in columns],
        rows=[[_text(one, row) for one in columns] for row in shown.rows],
        caption=shown.caption,
    )
    if shown.folded:
        made["fold"] = Fold(first=len(shown.rows) - shown.folded, words=shown.fold)
    return made


def key_number(one: Quantity) -> KeyNumber:
    """As the page shows it; what is not finite is None."""
    made = KeyNumber(
        label=one.label,
        value=_finite(one.value),
        std=_finite(one.std) if math.isfinite(one.value) else None,
        unit=one.unit,
        note=one.note,
    )
    if one.group:
        made["row"] = one.group
    return made


def _finite(value: float | None) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None


def _text(column: Column, row: Any) -> str:
    """Numbers with a real minus: a hyphen is shorter than a plus."""
    cell = column.cell(row)
    if isinstance(cell, Quantity):
        return _HYPHEN.sub("−", cell.text())
    is_name = column.words is None and isinstance(column.value(row), str)
    return cell if is_name else _HYPHEN.sub("−", cell)
