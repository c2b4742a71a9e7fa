"""Types of arrays; their shapes and units are in docstrings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]
RecordArray = NDArray[np.void]
"""Of named fields."""
