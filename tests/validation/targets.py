"""What a campaign is held to: a value and the bounds that it must keep."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.validation.tables import MET, cell, csv_text

COLUMNS = ("quantity", "value", "at least", "at most", "unit", MET)


@dataclass(frozen=True, slots=True)
class Target:
    """One value and its bounds.

    Attributes:
        quantity: What was measured.
        value: As it is printed.
        low, high: The bounds, or None.
        unit: Of all three.
    """

    quantity: str
    value: float
    low: float | None = None
    high: float | None = None
    unit: str = ""

    @property
    def is_met(self) -> bool:
        """Tell whether the value lies within its bounds; NaN does not."""
        return (self.low is None or self.value >= self.low) and (self.high is None or self.value <= self.high)


def targets_csv(targets: Iterable[Target]) -> str:
    """Return the targets as CSV, a row each."""
    return csv_text(
        COLUMNS,
        [
            (
                target.quantity,
                target.value,
                _bound(target.low),
                _bound(target.high),
                target.unit,
                target.is_met,
            )
            for target in targets
        ],
    )


def _bound(value: float | None) -> object:
    return "" if value is None else value


def report_targets(targets: Sequence[Target]) -> int:
    """Print which targets are met; return 1 if one is not."""
    for target in targets:
        bounds = " to ".join("" if end is None else cell(end) for end in (target.low, target.high))
        print(
            f"{target.quantity}: {cell(target.value)} of {bounds} {target.unit}: {'met' if target.is_met else 'MISSED'}"
        )
    return 0 if all(target.is_met for target in targets) else 1


def read_targets(path: Path) -> list[tuple[Target, bool]]:
    """Return each target of a file, and whether the file says that it is met."""
    with path.open(newline="", encoding="utf-8") as file:
        return [
            (
                Target(
                    row["quantity"],
                    float(row["value"]),
                    float(row["at least"]) if row["at least"] else None,
                    float(row["at most"]) if row["at most"] else None,
                    row["unit"],
                ),
                row[MET] == "yes",
            )
            for row in csv.DictReader(file)
        ]
