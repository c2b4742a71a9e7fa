"""Numbers as table cells: what is unknown is a dash."""

from __future__ import annotations

import math
from datetime import UTC, datetime

import numpy as np

NOTHING = "–"
_MOST_DECIMALS = 6
MINUS = "−"
"""As the page writes it: a hyphen is shorter than a plus."""


def number(value: float, digits: int, *, signed: bool = False) -> str:
    """With so many decimals."""
    if not np.isfinite(value):
        return NOTHING
    # Rounded first: what rounds to zero has no sign.
    rounded = round(float(value), digits) + 0.0
    return f"{rounded:{'+' if signed and rounded else ''}.{digits}f}".replace("-", MINUS)


def significant(value: float, digits: int = 3) -> str:
    """With so many significant digits, for numbers of any size."""
    return f"{value:.{digits}g}".replace("-", MINUS) if np.isfinite(value) else NOTHING


def decimals_of(std: float, least: int = 2) -> int:
    """With so many decimals a standard deviation has two significant digits; `least` where there is none."""
    if not np.isfinite(std) or std <= 0.0:
        return least
    return min(max(1 - math.floor(math.log10(std)), 0), _MOST_DECIMALS)


def with_std(value: float, std: float, *, signed: bool = False) -> str:
    """`+54.950 ± 0.023`: as many decimals as the standard deviation has a meaning with."""
    if not np.isfinite(value):
        return NOTHING
    digits = decimals_of(std)
    return f"{number(value, digits, signed=signed)} ± {number(std, digits)}"


def utc(moment: datetime | None) -> str:
    """A time of day."""
    return NOTHING if moment is None else f"{moment.astimezone(UTC):%Y-%m-%d %H:%M} UTC"
