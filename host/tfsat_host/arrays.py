"""Types of arrays; their shapes and units are in docstrings. And how an object of many of them is shown."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]
RecordArray = NDArray[np.void]
"""Of named fields."""
_MAX_SHOWN = 4
"""Elements of an array that is shown by value."""
_MAX_TEXT = 80


def describe_fields(data: Any) -> str:
    """Describe a dataclass, a line a field: arrays by shape and type, what is large by its kind; its `__repr__`."""
    lines = [f"  {field.name}: {_describe(getattr(data, field.name))}" for field in fields(data)]
    return "\n".join((f"<{type(data).__name__}", *lines)) + ">"


def _describe(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return (
            f"{value.shape} {value.dtype}"
            if value.size > _MAX_SHOWN
            else np.array2string(value, separator=", ")
        )
    if isinstance(value, tuple | list | dict) and any(map(is_dataclass, value)):
        return f"{len(value)} of {type(next(iter(value))).__name__}"
    if is_dataclass(value):
        return f"<{type(value).__name__}>"
    text = repr(value)
    return text if len(text) <= _MAX_TEXT else f"{text[:_MAX_TEXT]} …"
