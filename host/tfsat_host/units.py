"""Conversions between what people read and what boards and files carry, exact where they must be.

Decimal numbers that people type (58.75 deg, 0.70 s) have no exact binary value. Everything that is
rounded, compared or sent goes through the shortest decimal text of a float, so that 1.05 s is
1 050 000 µs and not 1 049 999.
"""

from __future__ import annotations

import math
from decimal import ROUND_HALF_EVEN, Decimal
from fractions import Fraction

US_PER_S = 1_000_000
CDEG_PER_DEG = 100
STANDARD_GRAVITY_M_S2 = 9.80665
"""One g of an accelerometer's scale (CGPM 1901)."""


def exact(value: float) -> Fraction:
    """Return the number a person wrote: the shortest decimal text that reads back as `value`.

    Raises:
        ValueError: `value` is infinite or not a number.
    """
    if not math.isfinite(value):
        raise ValueError(f"{value} is not a finite number")
    # Python's repr is the shortest decimal that reads back as the same float.
    return Fraction(repr(float(value)))


def cdeg_from_deg(angle_deg: float) -> int:
    """Hundredths of a degree, rounded half to even.

    Raises:
        ValueError: `angle_deg` is infinite or not a number.
    """
    if not math.isfinite(angle_deg):
        raise ValueError(f"{angle_deg} is not a finite number")
    # Decimal rounds halves of the number as it was typed, not of its binary neighbour.
    return int((Decimal(repr(float(angle_deg))) * CDEG_PER_DEG).to_integral_value(ROUND_HALF_EVEN))


def deg_from_cdeg(angle_cdeg: int) -> float:
    """Degrees, as the float nearest to the exact decimal value."""
    return angle_cdeg / CDEG_PER_DEG


def s_from_us(t_us: int) -> float:
    """Seconds, as the float nearest to the exact decimal value."""
    return t_us / US_PER_S


def round_up(value: Fraction | int, step: int) -> int:
    """Return the smallest multiple of `step` not below `value`; exact multiples stay as they are."""
    return math.ceil(Fraction(value) / step) * step
