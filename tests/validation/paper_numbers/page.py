"""A number of the paper next to ours, and the page of all of them."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass

HEAD = """\
# The paper's numbers, and ours

Written by `make paper-numbers`; do not edit. [The paper](../README.md#where-things-are) is that of the README; ours are
computed from the files of `robots/`, in the same units. A difference is ours less the paper's. *Same*: equal in every
digit that the paper prints. *Given*: not determined by the paper's inputs, only used.
"""


@dataclass(frozen=True, slots=True)
class Row:
    """One number.

    Attributes:
        what: What it is, and where in the paper.
        paper: As printed.
        ours: With one digit more where that says something; in the unit of `paper`, or with its own.
        verdict: "same", a difference, or "given".
        why: Where it is not the same, why; how it was computed, where that is not plain.
    """

    what: str
    paper: str
    ours: str
    verdict: str
    why: str = ""


def row(
    what: str, paper: str, ours: float, *, unit: str = "", why: str = "", digits: int | None = None
) -> Row:
    """A row for one printed number: compared in the digits that the paper prints, shown with one more."""
    printed = len(paper.partition(".")[2]) if digits is None else digits
    same = f"{ours:.{printed}f}" == paper
    verdict = "same" if same else f"{ours - float(paper):+.{printed + 1}f}"
    space = f" {unit}" if unit else ""
    return Row(what, f"{paper}{space}", f"{ours:.{printed + 1}f}", verdict, why)


def section(title: str, text: str, rows: list[Row]) -> str:
    """A heading, a few sentences, the table, and below it why each number differs."""
    lines = [
        f"## {title}",
        "",
        *([*textwrap.wrap(text, 118), ""] if text else []),
        "| number | paper | ours | difference | |",
        "|---|---|---|---|---|",
    ]
    notes: list[str] = []
    for one in rows:
        notes += [one.why] if one.why else []
        mark = f"({len(notes)})" if one.why else ""
        lines.append(f"| {one.what} | {one.paper} | {one.ours} | {one.verdict} | {mark} |")
    lines.append("")
    for number, note in enumerate(notes, start=1):
        lines += textwrap.wrap(f"{number}. {note}", 118, subsequent_indent="   ")
    return "\n".join([*lines, ""] if notes else lines)
