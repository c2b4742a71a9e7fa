"""Whether a result is what it was: the same keys, names and whole numbers, and other numbers within a tolerance."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

RELATIVE = 1e-4
ABSOLUTE = 1e-6
"""In the unit of the number: far below each figure's standard deviation, far above what another processor changes."""


def differences(expected: Any, found: Any, place: str = "") -> Iterator[str]:
    """Each place where two JSON values differ, with both values."""
    if isinstance(expected, dict) and isinstance(found, dict):
        for key in sorted({*expected, *found}):
            if key not in found:
                yield f"{place}.{key}: gone"
            elif key not in expected:
                yield f"{place}.{key}: new"
            else:
                yield from differences(expected[key], found[key], f"{place}.{key}")
    elif isinstance(expected, list) and isinstance(found, list):
        if len(expected) != len(found):
            yield f"{place}: {len(expected)} items became {len(found)}"
        for number, (old, new) in enumerate(zip(expected, found, strict=False)):
            yield from differences(old, new, f"{place}[{number}]")
    elif not _same(expected, found):
        yield f"{place}: {expected!r} became {found!r}"


def _same(expected: Any, found: Any) -> bool:
    if isinstance(expected, bool) or isinstance(found, bool):
        return expected is found
    if isinstance(expected, float) and isinstance(found, int | float):
        return math.isclose(expected, found, rel_tol=RELATIVE, abs_tol=ABSOLUTE)
    if isinstance(expected, int) and isinstance(found, float):
        return math.isclose(expected, found, rel_tol=RELATIVE, abs_tol=ABSOLUTE)
    return bool(expected == found)
