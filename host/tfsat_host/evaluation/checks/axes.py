"""The ways in which a sensor's axes can be exchanged and reversed, and words for them."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def signed_exchanges() -> FloatArray:
    """(47, 3, 3) what shows instead of the truth: every exchange and reversal of axes but none at all."""
    found = [
        np.diag(signs) @ np.eye(3)[list(order)]
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]
    return np.array([one for one in found if not np.array_equal(one, np.eye(3))])


def right_angled_turns() -> FloatArray:
    """(23, 3, 3) those that a sensor can be mounted by: without a mirror."""
    every = signed_exchanges()
    return np.asarray(every[np.linalg.det(every) > 0.0])


def in_words(exchange: FloatArray) -> str:
    """Such as `x and y exchanged, z reversed`; `exchange` (3, 3) makes what is shown of what is true."""
    sources = np.abs(exchange).argmax(axis=1)
    signs = exchange[np.arange(3), sources]
    moved = [axis for axis in range(3) if sources[axis] != axis]
    parts = []
    if len(moved) == 3:
        parts.append(
            ", ".join(
                f"{'xyz'[axis]} shows {'-' if signs[axis] < 0 else ''}{'xyz'[sources[axis]]}"
                for axis in range(3)
            )
        )
        return parts[0]
    if moved:
        parts.append(f"{'xyz'[moved[0]]} and {'xyz'[moved[1]]} exchanged")
    reversed_axes = ["xyz"[axis] for axis in range(3) if signs[axis] < 0]
    if reversed_axes:
        parts.append(f"{' and '.join(reversed_axes)} reversed")
    return ", ".join(parts)
