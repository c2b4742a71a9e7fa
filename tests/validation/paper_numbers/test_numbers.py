"""The tables of the paper's numbers are what the code computes today, and the page says why a number differs."""

from __future__ import annotations

import csv
import re

import pytest

from tests.paths import DOCS
from tests.validation.paper_numbers.numbers import SAME, make_tables, row
from tests.validation.paper_numbers.sections import compute_sections
from tests.validation.tables import read_rows

FOLDER = DOCS / "paper-numbers"
PAGE = (DOCS / "paper-numbers.md").read_text(encoding="utf-8")
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


@pytest.mark.parametrize("quick", [True, pytest.param(False, marks=pytest.mark.prove)])
@pytest.mark.parametrize("name", ["numbers.csv", "details.csv"])
def test_the_tables_are_what_the_code_computes(name: str, quick: bool) -> None:
    """Numbers may differ by two units of their last digit, as processors round differently."""
    sections = compute_sections(quick=quick)
    committed = [row for row in read_rows(FOLDER / name)[1:] if row[0] in sections]
    computed = list(csv.reader(make_tables(sections)[name].splitlines()))[1:]
    assert len(computed) > 1
    # Sections that were not computed are not compared.
    for before, now in zip(committed, computed, strict=True):
        text, text_now = " ".join(before), " ".join(now)
        assert _NUMBER.sub("#", text) == _NUMBER.sub("#", text_now)
        for number, number_now in zip(_NUMBER.findall(text), _NUMBER.findall(text_now), strict=True):
            # The last digit printed: two of its units are a rounding difference.
            last_digit = 10.0 ** -len(number.partition(".")[2])
            within = 2.0 * last_digit if "." in number else 0.0
            assert float(number_now) == pytest.approx(float(number), abs=within)


def test_the_page_says_why_a_number_is_not_the_papers() -> None:
    explained_numbers = set(re.findall(r"^- \*\*(.+?)\*\*", PAGE, re.MULTILINE))
    numbers = {number: difference for _, number, _, _, difference in read_rows(FOLDER / "numbers.csv")[1:]}
    assert explained_numbers <= set(numbers)
    # Every number that differs from the paper's must have a sentence on the page.
    assert {
        number for number, difference in numbers.items() if difference not in (SAME, "")
    } <= explained_numbers


@pytest.mark.parametrize(
    ("paper", "ours", "printed_text", "verdict"),
    [
        ("26.11", 26.112, "26.112", "same"),
        ("26.11", 26.118, "26.118", "+0.008"),
        ("100", 125.1, "125.1", "+25.1"),
        ("0.70", 0.7, "0.700", "same"),
    ],
)
def test_a_number_is_compared_in_the_digits_that_are_printed(
    paper: str, ours: float, printed_text: str, verdict: str
) -> None:
    number_row = row("a number", paper, ours)
    assert (number_row.ours, number_row.verdict) == (printed_text, verdict)
