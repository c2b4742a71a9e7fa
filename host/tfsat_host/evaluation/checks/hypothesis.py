"""What may be wrong with a sensor, and how the consistency vector would look if that were put right."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One thing that may be wrong, put right.

    Attributes:
        family: What it is, and of which sensor: two of one family are the same cause to a person.
        left: (size,) the vector then.
        free: (size, q) what q unknown numbers add to it.
        said: The cause in words, by those numbers (q,) as they fit best.
        next_step: What to do about it.
    """

    family: tuple[str, ...]
    left: FloatArray
    free: FloatArray
    said: Callable[[FloatArray], str]
    next_step: str


def fixed(family: tuple[str, ...], left: FloatArray, cause: str, next_step: str) -> Hypothesis:
    """One without unknown numbers."""
    return Hypothesis(family, left, np.zeros((len(left), 0)), lambda _: cause, next_step)
