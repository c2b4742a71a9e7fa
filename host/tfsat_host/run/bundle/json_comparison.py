"""Two results compared number by number.

Numbers that were computed twice from the same raw data are the same bit for bit on the same machine with the same
packages. On another one, sums are taken in another order. So two numbers count as the same within a tolerance relative
to the larger of the two or, in a list, to the largest of the list (where 1e-17 next to 1 means zero), or within an
absolute one. Of sentences only the words with a digit count, in which decimals may differ by one in the last digit: a
later version may say the same in other words. All other texts, flags and keys must be equal; which keys have sentences
is part of the tolerance.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from tfsat_host.quantity import Column, Columns, fields

# A number with a decimal point that is no part of a word or of a version such as 1.2.3.
_DECIMAL = re.compile(r"(?<![\w.])[+\-−]?\d+\.\d+(?:e[+-]?\d+)?(?![\w.]*\w)", re.IGNORECASE)
_FIGURE = re.compile(r"[^\s(),;:]*\d[^\s(),;:]*(?<!\.)")
"""A word with a digit in it: a number with its sign, a date, an id."""
NOT_THERE = "not there"
_MAX_CHARACTERS = 24
"""Of a text in a table of differences."""
_WHOLE_MAX = 10**300
"""Greater whole numbers are no float, and none of ours."""


_SENTENCES = frozenset(
    {
        "sentence",
        "sentences",
        "reason",
        "reasons",
        "remark",
        "remarks",
        "notes",
        "what",
        "meaning",
        "next_step",
    }
)
_ON_A_PAGE = _SENTENCES | {
    *("title", "label", "x_label", "y_label", "caption", "note", "words"),
    *("columns", "rows", "row"),
}


class Tolerance(NamedTuple):
    """How far two results may be apart.

    Attributes:
        relative, absolute: Of two numbers: a share of the larger one, or that much.
        sentences: The keys whose texts may say the same in other words.
    """

    relative: float
    absolute: float
    sentences: frozenset[str] = _SENTENCES


EVALUATION_TOLERANCE = Tolerance(1e-5, 1e-9)
"""Of results. Other kernels of the linear algebra (no AVX2, no FMA) move the directions of `identifiability` by up to
4e-6 and everything else by less than 1e-6; the standard deviations are some 1e-4 of their values."""
REPORT_TOLERANCE = Tolerance(1e-4, 1e-9, _ON_A_PAGE)
"""Of the page's curves, which are rounded to five digits of their span; its headings may be named otherwise, and what
its tables say in words is compared in the evaluation."""
CERTIFICATE_TOLERANCE = Tolerance(1e-6, 1e-12)
"""Of a calibration, which is written with twelve digits."""


@dataclass(frozen=True, slots=True)
class Difference:
    """One thing that differs.

    Attributes:
        key: Where, such as `strokes[1].size_deg`.
        bundled, recomputed: Both values.
        relative: By how much of the larger one; None: they are no numbers.
    """

    key: str
    bundled: Any
    recomputed: Any
    relative: float | None


def _words_of(value: object) -> str:
    text = f"{value:.9g}" if isinstance(value, float) else str(value)
    return text if len(text) <= _MAX_CHARACTERS else f"{text[:_MAX_CHARACTERS]}…"


DIFFERENCES: Columns = (
    Column("key", "what"),
    Column("bundled", "bundled", words=lambda difference: _words_of(difference.bundled)),
    Column("recomputed", "recomputed", words=lambda difference: _words_of(difference.recomputed)),
    Column("relative", "relative", form=".1e"),
)


@dataclass(frozen=True)
class ComparedPart:
    """One part of a bundle, computed again.

    Attributes:
        what: `evaluation`, `report` or `calibration`.
        differs: How; None: it was not computed again, and that is no difference.
        sentence: What was done, or why not.
        extent: How much was compared, such as `961 numbers`; may be empty.
        tolerance: With which; None: nothing was compared.
        lacking: It should have been computed and could not be.
        refused: The raw data give none.
    """

    what: str
    differs: Sequence[Difference] | None
    sentence: str
    extent: str = ""
    tolerance: Tolerance | None = None
    lacking: bool = False
    refused: bool = False

    @property
    def identical(self) -> bool:
        """Whether it was computed again without a difference."""
        return not self.refused and not self.lacking and self.differs is not None and not self.differs


COMPARED: Columns = (
    *fields("what sentence lacking"),
    Column("differences", of="differs", columns=DIFFERENCES),
)


def count_numbers(value: Any) -> int:
    """Count the numbers in a JSON value."""
    if isinstance(value, dict):
        return sum(map(count_numbers, value.values()))
    if isinstance(value, list):
        return sum(map(count_numbers, value))
    return isinstance(value, int | float) and not isinstance(value, bool)


def differences(bundled: Any, recomputed: Any, tolerance: Tolerance) -> list[Difference]:
    """Find the differences between two JSON values.

    A list or table present on one side only is reported by its length.
    """
    try:
        return list(_walk(bundled, recomputed, tolerance, _Place("", "", 0.0)))
    except RecursionError:  # nothing of ours is nested so deeply: the other one is not of ours
        return [Difference("", "nested too deeply", "a result", None)]


class _Place(NamedTuple):
    """Where the walk is: the whole key, its last name, and the largest number of the list around."""

    key: str
    name: str
    scale: float


def _walk(first: Any, two: Any, tolerance: Tolerance, at: _Place) -> Iterator[Difference]:
    if isinstance(first, dict) and isinstance(two, dict):
        for name in dict.fromkeys((*first, *two)):
            # Entries of an object share no unit: each number is judged by its own size.
            inner = _Place(f"{at.key}.{name}" if at.key else str(name), str(name), 0.0)
            yield from _walk(first.get(name, NOT_THERE), two.get(name, NOT_THERE), tolerance, inner)
    elif isinstance(first, list) and isinstance(two, list):
        if len(first) != len(two):
            yield Difference(f"{at.key} (length)", len(first), len(two), None)
        # Entries of a list do: a rounding error beside the largest one is no difference.
        scale = max(at.scale, _largest(first), _largest(two))
        for index, (a, b) in enumerate(zip(first, two, strict=False)):
            yield from _walk(a, b, tolerance, _Place(f"{at.key}[{index}]", at.name, scale))
    elif _is_number(first) and _is_number(two):
        if _apart(first, two, tolerance, at.scale):
            yield Difference(at.key, first, two, abs(first - two) / max(abs(first), abs(two)))
    elif isinstance(first, str) and isinstance(two, str) and at.name in tolerance.sentences:
        if not same_figures(first, two):
            yield Difference(at.key, first, two, None)
    elif type(first) is not type(two) or first != two:
        yield Difference(at.key, _format_value(first), _format_value(two), None)


def _format_value(value: Any) -> Any:
    return f"{len(value)} entries" if isinstance(value, list | dict) else value


def same_figures(first_text: str, two: str) -> bool:
    """Return whether two sentences have the same figures, within one unit in the last decimal digit."""
    # Keep the words with a digit: another version may say the same in other words.
    first_text, two = (" ".join(_FIGURE.findall(text)) for text in (first_text, two))
    # Whatever is no decimal (counts, dates, ids, their order) must be equal.
    if _DECIMAL.sub("#", first_text) != _DECIMAL.sub("#", two):
        return False
    # One unit in the last digit of the coarser one; 1.001 allows for decimals rounded to binary.
    return all(
        abs(_value(a) - _value(b)) <= 1.001 * max(_last_digit(a), _last_digit(b))
        for a, b in zip(_DECIMAL.findall(first_text), _DECIMAL.findall(two), strict=True)
    )


def _value(text: str) -> float:
    return float(text.replace("−", "-"))


def _last_digit(text: str) -> float:
    mantissa, _, exponent = text.lower().partition("e")
    return float(10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2])))


def _apart(first_value: float, two: float, tolerance: Tolerance, scale: float) -> bool:
    if first_value == two:
        return False
    allowed = max(tolerance.relative * max(abs(first_value), abs(two), scale), tolerance.absolute)
    # Written so that NaN, or a tolerance that became infinite, counts as apart.
    return not abs(first_value - two) <= allowed < math.inf


def _is_number(value: object) -> bool:
    # type() keeps flags out: True must not pass for 1.
    return isinstance(value, float) or (type(value) is int and abs(value) < _WHOLE_MAX)


def _largest(values: list[Any]) -> float:
    """Return the largest magnitude in a nested list of numbers.

    None entries are ignored; returns 0 if the list holds anything else.
    """
    largest = 0.0
    for value in values:
        if isinstance(value, list):
            largest = max(largest, _largest(value))
        elif _is_number(value):
            largest = max(largest, abs(float(value)))
        elif value is not None:
            # Anything else in the list: its numbers have no common scale.
            return 0.0
    return largest
