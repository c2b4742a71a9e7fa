"""A number of the paper next to ours, and the tables of all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from tests.validation.tables import csv_text

SAME, GIVEN = "same", "given"


@dataclass(frozen=True, slots=True)
class Row:
    """One number.

    Attributes:
        what: What it is, and where in the paper.
        paper: As printed.
        ours: With one digit more where that says something; in the unit of `paper`, or with its own.
        verdict: "same", a difference, or "given".
        details: What the page's note on it rests on: value with unit, by what it is of.
    """

    what: str
    paper: str
    ours: str
    verdict: str
    details: Mapping[str, str] = field(default_factory=dict)


def row(
    what: str,
    paper: str,
    ours: float,
    *,
    unit: str = "",
    digits: int | None = None,
    details: Mapping[str, str] | None = None,
) -> Row:
    """Return a row for one printed number: compared in the digits that the paper prints, shown with one more."""
    printed = len(paper.partition(".")[2]) if digits is None else digits
    same = f"{ours:.{printed}f}" == paper
    verdict = SAME if same else f"{ours - float(paper):+.{printed + 1}f}"
    space = f" {unit}" if unit else ""
    return Row(what, f"{paper}{space}", f"{ours:.{printed + 1}f}", verdict, details or {})


Sections = Mapping[str, Sequence[Row]]
"""By the title in docs/paper-numbers.md."""


def make_tables(sections: Sections) -> dict[str, str]:
    """Return the text of each CSV file by its name."""
    numbers = [
        (title, row.what, row.paper, row.ours, row.verdict)
        for title, rows in sections.items()
        for row in rows
    ]
    details = [
        (title, row.what, what, value)
        for title, rows in sections.items()
        for row in rows
        for what, value in row.details.items()
    ]
    return {
        "numbers.csv": csv_text(("section", "number", "paper", "ours", "difference"), numbers),
        "details.csv": csv_text(("section", "number", "of it", "value"), details),
    }
