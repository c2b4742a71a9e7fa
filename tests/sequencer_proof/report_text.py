"""Figures and tables as text."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from tests.sequencer_proof.signals import CYCLES_PER_US, Extremes


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


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
