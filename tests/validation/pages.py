"""`make pages`: puts the tables of CSV files into the pages of docs/, whose prose is written by hand.

A table stands between two marks, and is the whole file or those of its rows whose first column has the words behind
its name:

    <!-- table: sequencer-proof/figures.csv power cuts -->
    <!-- end -->
"""

from __future__ import annotations

import re
from pathlib import Path

from tests.paths import DOCS
from tests.validation.tables import MET, markdown_table, read_rows

# A mark, the file's name, words to select rows, and everything up to the end mark.
_TABLE = re.compile(r"(<!-- table: (\S+\.csv)(?: ([^\n]+?))? -->\n).*?(<!-- end -->)", re.DOTALL)
_MISSED = re.compile(r"^## Missed targets$(.*?)(?=^## |\Z)", re.DOTALL | re.MULTILINE)


def fill_tables(text: str, folder: Path = DOCS) -> str:
    """Return a page with its tables as their files have them. Raises ValueError, OSError."""

    # Only the text between the marks is replaced, the marks stay.
    def fill(mark: re.Match[str]) -> str:
        rows = read_rows(folder / mark[2], mark[3] or "")
        return f"{mark[1]}\n{markdown_table(rows)}\n{mark[4]}"

    return _TABLE.sub(fill, text)


def fill_pages(folder: Path = DOCS) -> list[Path]:
    """Fill the tables of every page; return the pages that changed."""
    changed = []
    for page in sorted(folder.glob("*.md")):
        text = page.read_text(encoding="utf-8")
        filled = fill_tables(text, folder)
        if filled != text:
            page.write_text(filled, encoding="utf-8")
            changed.append(page)
    return changed


def find_missed(text: str, folder: Path = DOCS) -> set[str]:
    """Return what misses its target in a table of a page: the first cell of each row that is not met."""
    missed = set()
    for mark in _TABLE.finditer(text):
        columns, *rows = read_rows(folder / mark[2], mark[3] or "")
        # Only tables with a "met" column can miss a target.
        if MET in columns:
            missed |= {row[0] for row in rows if row[columns.index(MET)] == "no"}
    return missed


def list_missed(text: str) -> set[str]:
    """Return what a page's section "Missed targets" names: all that stands there in bold."""
    section = _MISSED.search(text)
    # Names on a page are bold and may wrap over lines.
    names = re.findall(r"\*\*(.+?)\*\*", section[1], re.DOTALL) if section else []
    return {" ".join(name.split()) for name in names}


if __name__ == "__main__":
    fill_pages()
