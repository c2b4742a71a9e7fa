"""Figures of many errors together, and the rows that show them."""

from __future__ import annotations

import csv
import io
import textwrap
from collections.abc import Iterable, Sequence

import numpy as np

from tests.validation.calibration_proof.robots import Errors
from tfsat_host.arrays import FloatArray

COVERED = (0.90, 0.99)
"""So often must a 95 % interval hold the truth."""
_NORMAL_95 = 1.959964


def table(columns: Sequence[str], rows: Iterable[Sequence[str]], words: int = 1) -> str:
    """In Markdown; the first `words` columns are text, the others numbers."""
    head = [*["---"] * words, *["--:"] * (len(columns) - words)]
    return "".join(f"| {' | '.join(row)} |\n" for row in (columns, head, *rows))


def csv_text(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """The same for a file next to the page; percentages without their sign."""
    with io.StringIO(newline="") as text:
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([cell.removesuffix(" %") for cell in row] for row in rows)
        return text.getvalue()


def rms(values: FloatArray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def z_rms(errors: Errors) -> float:
    """Root mean square of the errors in their own standard deviations."""
    return rms(errors.error / errors.std)


def covered(errors: Errors) -> float:
    """Share of the values whose 95 % interval holds the truth."""
    return float((np.abs(errors.error) < _NORMAL_95 * errors.std).mean())


def percent(share: float) -> str:
    return f"{100.0 * share:.1f} %"


def figures(errors: Errors, digits: int = 4) -> tuple[str, ...]:
    """rms, largest, median of the stated std, z, and how often the interval holds the truth."""
    return (
        f"{rms(errors.error):.{digits}f}",
        f"{np.abs(errors.error).max():.{digits}f}",
        f"{np.median(errors.std):.{digits}f}",
        f"{z_rms(errors):.2f}",
        percent(covered(errors)),
    )


def filled(prose: str) -> str:
    """Its paragraphs, each filled again: the figures in it have other widths than their names."""
    paragraphs = prose.strip().split("\n\n")
    return "\n\n".join(textwrap.fill(one, 120, break_on_hyphens=False) for one in paragraphs) + "\n"
