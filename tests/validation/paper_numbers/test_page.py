"""The page of the paper's numbers is what the code computes today."""

from __future__ import annotations

import re

import pytest

from tests.validation.paper_numbers.__main__ import PAGE, sections
from tests.validation.paper_numbers.page import row

_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[+-]?\d+)?")


@pytest.mark.parametrize("quick", [True, pytest.param(False, marks=pytest.mark.prove)])
def test_the_page_is_what_its_command_writes(quick: bool) -> None:
    """Word by word; numbers may differ by two units of their last digit, as processors round differently."""
    heads = re.split(r"\n(?=## )", PAGE.read_text(encoding="utf-8"))[1:]
    written = {text.splitlines()[0]: text.rstrip() for text in heads}
    assert len(written) == 5
    for computed in sections(quick=quick):
        text = written[computed.splitlines()[0]]
        assert _NUMBER.sub("#", text) == _NUMBER.sub("#", computed.rstrip())
        for before, now in zip(_NUMBER.findall(text), _NUMBER.findall(computed), strict=True):
            last_digit = 10.0 ** -len(before.partition(".")[2])
            assert float(now) == pytest.approx(float(before), abs=2.0 * last_digit if "." in before else 0.0)


@pytest.mark.parametrize(
    ("paper", "ours", "shown", "verdict"),
    [
        ("26.11", 26.112, "26.112", "same"),
        ("26.11", 26.118, "26.118", "+0.008"),
        ("100", 125.1, "125.1", "+25.1"),
        ("0.70", 0.7, "0.700", "same"),
    ],
)
def test_a_number_is_compared_in_the_digits_that_are_printed(
    paper: str, ours: float, shown: str, verdict: str
) -> None:
    found = row("a number", paper, ours)
    assert (found.ours, found.verdict) == (shown, verdict)
