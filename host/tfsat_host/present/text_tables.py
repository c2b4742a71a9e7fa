"""Tables that no terminal is too narrow for: words stay whole, and what does not fit in a row goes below."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rich import box
from rich.cells import cell_len
from rich.table import Table
from rich.text import Text

_TABLE_GAP, _TABLE_EDGES = 3, 2  # characters between two columns, and at both ends, of box.SIMPLE_HEAD
_BLOCK_GAP = 2


def table_of(
    columns: Sequence[Text], rows: Sequence[Sequence[Text]], numeric: Sequence[bool], title: str, width: int
) -> Table:
    """Build a table at most `width` characters wide; a block of lines per row if its columns do not fit.

    A longer word is the only one to be broken. `numeric` columns are aligned right; a `title` stands above,
    unless empty.
    """
    room = width - _TABLE_EDGES - _TABLE_GAP * (len(columns) - 1)
    widths = _widths([columns, *rows], room)
    if widths is None:
        # Too wide: standard deviations on lines of their own make columns narrower.
        rows = [[_std_below(cell) for cell in row] for row in rows]
        widths = _widths([columns, *rows], room)
    if widths is None:
        return _blocks(columns, rows, title, width)
    table = Table(box=box.SIMPLE_HEAD, title=title or None, title_justify="left", pad_edge=False)
    for name, right, fitting in zip(columns, numeric, widths, strict=True):
        table.add_column(name, justify="right" if right else "left", overflow="fold", width=fitting)
    for row in rows:
        table.add_row(*row)
    return table


def _blocks(columns: Sequence[Text], rows: Sequence[Sequence[Text]], title: str, width: int) -> Table:
    """Build a table of a line per cell, with its column's name, and an empty line between two rows."""
    pairs = [[name, cell] for row in rows for name, cell in zip(columns, row, strict=True)]
    widths = _widths(pairs, width - _BLOCK_GAP) or (None, None)
    table = Table(box=None, show_header=False, title=title or None, title_justify="left", pad_edge=False)
    for fitting in widths:
        table.add_column(overflow="fold", width=fitting)
    for number, (name, cell) in enumerate(pairs, 1):
        table.add_row(name, cell)
        # An empty line after each row's block.
        if number % len(columns) == 0:
            table.add_row()
    return table


def _std_below(cell: Text) -> Text:
    """Move a cell's standard deviation to a line of its own."""
    before, *std = cell.split(" ± ")
    return cell if not std else Text("\n± ").join([before, *std])


def _widths(rows: Sequence[Sequence[Text]], room: int) -> list[int] | None:
    """Compute each column's width: its longest line, or narrower; None if words would break.

    The first row is narrowed first.
    """

    def widest(size: Callable[[Text], int], rows: Sequence[Sequence[Text]]) -> list[int]:
        return [max(map(size, column), default=0) for column in zip(*rows, strict=True)]

    widths, least = widest(_longest_line, rows), widest(_longest_word, rows)
    below = widest(_longest_line, rows[1:]) or least
    if sum(least) > room:
        return None
    while sum(widths) > room:
        # Take from the widest; first from columns that only their head makes wide.
        narrower = (i for i, width in enumerate(widths) if width > least[i])
        widths[max(narrower, key=lambda i: (widths[i] > below[i], widths[i]))] -= 1
    return widths


def _longest_line(cell: Text) -> int:
    return max(map(cell_len, cell.plain.split("\n")))


def _longest_word(cell: Text) -> int:
    """Return the width of the cell's longest word; a line with a standard deviation counts as one word."""
    lines = cell.plain.split("\n")
    words = [word for line in lines for word in ([line] if "±" in line else line.split())]
    return max(map(cell_len, words), default=0)
