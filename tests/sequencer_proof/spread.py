"""How a campaign's numbers spread: a few figures and a histogram in text."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass

WIDEST_BAR = 40


@dataclass(frozen=True, slots=True)
class Spread:
    """Of some numbers."""

    least: float
    median: float
    greatest: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Spread:
        return cls(min(values), statistics.median(values), max(values))

    def plus(self, offset: float, scale: float = 1.0) -> Spread:
        """Of the same numbers, times `scale`, plus `offset`."""
        return Spread(*(offset + scale * value for value in (self.least, self.median, self.greatest)))


def histogram(values: Sequence[int], bin_width: int) -> list[tuple[int, int]]:
    """(lower end of the bin, how many), every bin from the first that has any to the last."""
    bins = [value // bin_width for value in values]
    return [(number * bin_width, bins.count(number)) for number in range(min(bins), max(bins) + 1)]


def bar(count: int, most: int) -> str:
    """At least a mark where there is anything."""
    return "#" * max(bool(count), round(WIDEST_BAR * count / most))
