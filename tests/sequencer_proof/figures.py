"""How a campaign's numbers spread, as a page tells it."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass

from tests.sequencer_proof.signals import CYCLES_PER_US, Extremes

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


def us(cycles: float) -> str:
    """Microseconds: to the cycle, 1/16 us."""
    text = f"{cycles / CYCLES_PER_US:.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def signed_us(cycles: float) -> str:
    """Microseconds with their sign."""
    return us(cycles) if cycles <= 0 else f"+{us(cycles)}"


def range_us(extremes: Extremes) -> str:
    return f"{us(extremes.least)} to {us(extremes.greatest)} µs"


def signed_range_us(extremes: Extremes) -> str:
    return f"{signed_us(extremes.least)} to {signed_us(extremes.greatest)} µs"


def range_ms(extremes: Extremes) -> str:
    """To 10 us."""
    low, high = (value / CYCLES_PER_US / 1000 for value in (extremes.least, extremes.greatest))
    return f"{low:.2f} to {high:.2f} ms"
