"""Declared tables, quantities and sentences on a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from itertools import groupby, takewhile
from typing import Any, Self

from tfsat_host.next_step import Advice
from tfsat_host.notices import printable as printable
from tfsat_host.present.output import Output
from tfsat_host.present.wrapping import fill_lines, stream_columns
from tfsat_host.quantity import Column, Columns, Quantity, Table

WIDEST = 80
_LABEL = 13
_MIN_TEXT_COLUMNS = 24


def show_table(table: Table, out: Output) -> None:
    """Rows that are not folded, in one table or two; below them what the table has folded, and its caption."""
    visible_rows = table.rows[: len(table.rows) - table.folded]
    if visible_rows:
        beside = tuple(column for column in table.shown if column.label not in table.below)
        show_rows(beside, visible_rows, out, title=table.title)
        if table.below:
            below = (column for column in table.shown if column.label in table.below)
            show_rows((beside[0], *below), visible_rows, out, title=f"{table.title} (continued)")
    sentences([text for text in (table.fold, table.caption if visible_rows else "") if text], out)


def show(parts: Iterable[str | Table], out: Output) -> None:
    """Lines and tables in their order."""
    for part in parts:
        if isinstance(part, Table):
            show_table(part, out)
        else:
            out.line(part)


def show_rows(columns: Columns, rows: Sequence[Any], out: Output, *, title: str = "") -> None:
    """Rows under the columns that are for people."""
    visible_columns = [column for column in columns if column.label]
    heads = [f"{column.label} / {column.unit}" if column.unit else column.label for column in visible_columns]
    out.table(heads, [[_text(column.cell(row)) for column in visible_columns] for row in rows], title=title)


def show_facts(columns: Columns, row: Any, out: Output, *, color: str = "") -> None:
    """Write `Label: value unit` for each column that is for people, values below one another; empty ones are left out.

    Args:
        columns: Of the row; the text of a column's `words` may be empty.
        row: An object with what the columns take, or a mapping of their keys.
        out: Where to.
        color: Of the first value's first word on a terminal, as a select-graphic-rendition sequence has it.
    """
    cells = [(column, column.cell(row)) for column in columns if column.label]
    facts = [(f"{column.label}:", _with_unit(column, cell)) for column, cell in cells]
    shown = [(label, text) for label, text in facts if text]
    width = max((len(label) for label, _ in shown), default=0) + 1
    for number, (label, text) in enumerate(shown):
        write_labelled(label, text, out, color="" if number else color, label_columns=width)


def _with_unit(column: Column, cell: Quantity | str) -> str:
    if isinstance(cell, str):
        # Words have their units in them; a vector is numbers alone.
        return cell if column.words is not None else f"{cell} {column.unit}".rstrip()
    return f"{cell.text('unknown')} {cell.unit}".rstrip()


def show_quantities(quantities: Iterable[Quantity], out: Output) -> None:
    """Show each quantity on a line; those of a group share one line."""
    for group, alike in groupby(quantities, key=lambda quantity: quantity.group):
        written = [(quantity, f"{quantity.text('unknown')} {quantity.unit}".rstrip()) for quantity in alike]
        if group:
            # What all labels begin with, such as "Initial rate", the group's name says already.
            words = [quantity.label.split() for quantity, _ in written]
            shared = len(list(takewhile(lambda column: len(set(column)) == 1, zip(*words, strict=False))))
            named = [
                " ".join([*label[shared:], text]) for label, (_, text) in zip(words, written, strict=True)
            ]
            sentences([f"{group}: {', '.join(named)}"], out)
        else:
            notes = [
                f"{quantity.label}: {text}{f', {quantity.note}' if quantity.note else ''}"
                for quantity, text in written
            ]
            sentences(notes, out)


def _text(cell: Quantity | str) -> str:
    return printable(cell.text() if isinstance(cell, Quantity) else cell)


def write_labelled(
    label: str, text: str, out: Output, *, color: str = "", label_columns: int = _LABEL
) -> None:
    """Write one or more sentences behind a label; the text begins at `label_columns`.

    Further lines begin below its text, or below the label if that leaves no room. `color` is that of the
    text's first word on a terminal, as a select-graphic-rendition sequence has it.
    """
    width = _width()
    # A narrow terminal leaves no column beside the label: go on below it.
    indent = label_columns if width >= _MIN_TEXT_COLUMNS + label_columns else 2
    first = label.ljust(indent) if indent == label_columns else f"{label}  ".lstrip() or "  "
    for number, line in enumerate(_wrap_text(out.complete(text), width, first, " " * indent)):
        out.line(line, colored=text.split()[0] if color and number == 0 else "", color=color)


def write_verdict(text: str, color: str, out: Output) -> None:
    """Write a verdict, its words before the colon coloured on a terminal; further lines are indented."""
    sentences([text], out, colored=text.partition(":")[0], color=color)


def bullets(texts: Iterable[str], out: Output) -> None:
    """Write each text, of one sentence or more, as a bullet."""
    for text in texts:
        for line in wrap_bullet(text, out):
            out.line(line)


def wrap_bullet(text: str, out: Output) -> list[str]:
    """Return the lines of a bullet, its commands completed."""
    return _wrap_text(out.complete(text), _width(), "  - ", "    ")


def wrap_sentence(text: str, out: Output) -> list[str]:
    """Return the lines of a text, its commands completed; further lines are indented."""
    return _wrap_text(out.complete(text), _width(), "", "  ")


def sentences(texts: Iterable[str], out: Output, *, colored: str = "", color: str = "") -> None:
    """Write the texts as they are, one below the other; `colored` is a part of them that has that colour."""
    for text in texts:
        for line in wrap_sentence(text, out):
            out.line(line, colored=colored, color=color)


def list_facts(label: str, texts: Sequence[str], out: Output) -> None:
    """Write `Label: text`; of several texts `Label: number of them`, and each below; nothing where there is none."""
    if len(texts) == 1:
        sentences([Advice(f"{label}: ", texts[0])], out)
    elif texts:
        out.line(f"{label}: {len(texts)}")
        bullets(texts, out)


def _wrap_text(text: str, width: int, first: str, others: str) -> list[str]:
    return fill_lines(printable(text), width, first, others)


def _width() -> int:
    return min(stream_columns(sys.stdout) or WIDEST, WIDEST)


class Narration:
    """Steps as lines, a program's bars as progress; to be used as a context.

    Args:
        out: Where.
        program: Whose bars.
        marks: Of a whole bar.
    """

    def __init__(self, out: Output, program: str, marks: int) -> None:
        self._out = out
        self._program = program
        self._marks = marks
        self._bar: str | None = None
        self._advance: Callable[[float], None] = lambda _marks: None
        self._stack = ExitStack()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def step(self, text: str) -> None:
        """Something begins, or the user should do something."""
        self._end()
        self._out.note(f"{text} …")

    def advance(self, bar: str, marks: int) -> None:
        """Advance the bar of this name by so many marks."""
        if bar != self._bar:
            self._end()
            # One bar at a time: entering the next one's context takes the place of the last.
            progress = self._out.progress(f"{self._program}: {bar}", total=self._marks)
            self._bar, self._advance = bar, self._stack.enter_context(progress)
        self._advance(marks)

    def _end(self) -> None:
        self._stack.close()
        self._bar = None
