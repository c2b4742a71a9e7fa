"""Numbers as table cells: what is unknown is a dash."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np

NOTHING = "–"
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


def with_std(value: float, std: float, digits: int, *, signed: bool = False) -> str:
    """`+54.95 ± 0.02`."""
    if not np.isfinite(value):
        return NOTHING
    return f"{number(value, digits, signed=signed)} ± {number(std, digits)}"


def utc(moment: datetime | None) -> str:
    """A time of day."""
    return NOTHING if moment is None else f"{moment.astimezone(UTC):%Y-%m-%d %H:%M} UTC"
