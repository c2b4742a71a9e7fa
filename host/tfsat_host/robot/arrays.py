"""Arrays of a model: nobody changes them by accident."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tfsat_host.robot.model import FloatArray, IntArray


def frozen(values: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """`values` as a read-only array of that shape; one length may be -1."""
    array = np.array(values, dtype=np.float64).reshape(shape)
    array.flags.writeable = False
    return array


def frozen_indices(values: ArrayLike) -> IntArray:
    """`values` (n,) as a read-only array of indices."""
    array = np.array(values, dtype=np.int64).reshape(-1)
    array.flags.writeable = False
    return array
