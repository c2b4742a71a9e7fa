"""Whether a result is what it was: the same keys and words, and numbers within a tolerance that follows their ±."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from difflib import unified_diff
from typing import Any

OF_STD = 0.05
"""A number whose standard deviation is stated may change by this part of it."""
RELATIVE = 1e-3
ABSOLUTE = 1e-6
"""For a number without one, in its unit: far above what another processor changes."""
LAST_DIGITS = 2.0
"""A printed number may change by so many units of its last digit."""

_NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")
_RULE = re.compile(r"([ ─━-])\1+")


def differences(expected: Any, actual: Any, place: str = "", std: Any = None) -> Iterator[str]:
    """Yield each place where two JSON values differ, with both values.

    Args:
        expected: What was recorded.
        actual: What is there now.
        place: Where both stand, for the message.
        std: The standard deviation of the number, or of each number of the list, if one is stated beside it.
    """
    if isinstance(expected, dict) and isinstance(actual, dict):
        for key in sorted({*expected, *actual}):
            if key not in actual:
                yield f"{place}.{key}: gone"
            elif key not in expected:
                yield f"{place}.{key}: new"
            else:
                # A number's tolerance stands beside it in the same object.
                stated = _std_beside(key, expected)
                yield from differences(expected[key], actual[key], f"{place}.{key}", stated)
    elif isinstance(expected, list) and isinstance(actual, list):
        if len(expected) != len(actual):
            yield f"{place}: {len(expected)} items became {len(actual)}"
        # A list of numbers may have a list of standard deviations, one for each.
        each_std = std if isinstance(std, list) and len(std) == len(expected) else [None] * len(expected)
        for number, (old, new) in enumerate(zip(expected, actual, strict=False)):
            yield from differences(old, new, f"{place}[{number}]", each_std[number])
    elif not _same(expected, actual, std):
        yield f"{place}: {expected!r} became {actual!r}"


def _std_beside(key: str, beside: Mapping[str, Any]) -> Any:
    return beside.get("std") if key == "value" else beside.get(f"{key}_std")


def _same(expected: Any, actual: Any, std: Any) -> bool:
    # A flag must not pass for the number 1.
    if isinstance(expected, bool) or isinstance(actual, bool):
        return expected is actual
    if isinstance(expected, float | int) and isinstance(actual, float | int):
        # Counts are exact: only measured numbers have a tolerance.
        if isinstance(expected, int) and isinstance(actual, int):
            return expected == actual
        if isinstance(std, float) and std > 0:
            return abs(expected - actual) <= OF_STD * std
        return math.isclose(expected, actual, rel_tol=RELATIVE, abs_tol=ABSOLUTE)
    return bool(expected == actual)


def text_differences(expected: str, actual: str, *, numbers: bool = True) -> list[str]:
    """Return the lines that differ between two texts, as `diff -u` shows them.

    It is empty if only numbers differ, within tolerance.

    Args:
        expected: What was recorded.
        actual: What is printed now.
        numbers: Compare numbers and line ends; else neither, as both change from run to run.
    """
    old, new = (_words(text) if numbers else " ".join(_words(text).split()) for text in (expected, actual))
    if old == new and (not numbers or all(map(_same_digits, _numbers(expected), _numbers(actual)))):
        return []
    return list(unified_diff(expected.splitlines(), actual.splitlines(), "recorded", "now", lineterm="", n=1))


def _words(text: str) -> str:
    """Replace each number by `#`, and each run of blanks or of a rule by one.

    Their lengths depend on the numbers' digits.
    """
    return _RULE.sub(r"\1", _NUMBER.sub("#", text))


def _numbers(text: str) -> list[str]:
    return _NUMBER.findall(text)


def _same_digits(old: str, new: str) -> bool:
    """Return whether both have the same number of decimals and nearly the same last one."""
    if old == new:
        return True
    decimals, exponent = _decimals(old)
    # Whole numbers are counts here as well; another number of decimals is another format.
    if decimals == 0 or _decimals(new) != (decimals, exponent):
        return False
    return abs(float(old) - float(new)) <= LAST_DIGITS * 10.0 ** (exponent - decimals) * (1 + 1e-9)


def _decimals(number: str) -> tuple[int, int]:
    mantissa, _, exponent = number.partition("e")
    return len(mantissa.partition(".")[2]), int(exponent or 0)
