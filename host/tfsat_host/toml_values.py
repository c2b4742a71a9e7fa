"""Values of a TOML file that may be anything: as numbers, and as a message shows them."""

from __future__ import annotations

import math

SHOWN_CHARACTERS = 60


def finite(value: object) -> float | None:
    """The value as a number; None if it is none, or not finite, or too large for one."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def shown(value: object) -> str:
    """A value for a message: its beginning, if it is long."""
    try:
        text = str(value).lower() if isinstance(value, bool) else repr(value)
    except (ValueError, RecursionError):  # an integer of thousands of digits; lists hundreds deep
        return "what stands there"
    return shortened(text)


def shortened(text: str) -> str:
    """The beginning, if it is long."""
    return text if len(text) <= SHOWN_CHARACTERS else text[:SHOWN_CHARACTERS] + "…"
