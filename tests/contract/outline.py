"""What is compared of a JSON value: keys, names, shapes, units and key numbers; not sentences, not every row.

A text of a moment (a hash, a temporary folder, a time) is replaced by its kind, a long list of numbers by its shape,
mean and spread, a long list of objects by what its items have in common.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from tfsat_host import __version__

MAX_NUMBERS = 12
MAX_OBJECTS = 6
"""Lists up to these lengths are compared item by item."""
SENTENCE = "(a sentence)"
NUMBER = "(a number)"
_ROBOTS = re.compile(r"/\S*/robots/")
_HASH = re.compile(r"\b([0-9a-f]{64}|[0-9a-f]{16})\b")
_SESSION = re.compile(r"\bRAM-[0-9a-f]{8}\b")
_TIME = re.compile(r"\b20\d\d-?\d\d-?\d\dT\d\d:?\d\d:?\d\d(\.\d+)?(Z|\+00:00)?")
_MOMENTARY = frozenset({"environment", "age_s", "seconds", "bytes", "session"})
_NOT_DETERMINED = frozenset({"directions"})
"""Eigenvectors of the singular part of a fit: as good with another sign or mixed."""


def outline(value: Any, folder: str) -> Any:
    """Return a JSON value without sentences, temporary folders, hashes and long lists.

    Args:
        value: Any JSON value.
        folder: The scenario's folder, whose path stands in texts.
    """
    if isinstance(value, dict):
        return {
            key: "momentary" if key in _MOMENTARY | _NOT_DETERMINED else outline(item, folder)
            for key, item in value.items()
        }
    if isinstance(value, list):
        numbers = _outline_numbers(value)
        return numbers if numbers is not None else shorten([outline(item, folder) for item in value])
    if isinstance(value, str):
        return _outline_text(value, folder)
    return value


def shorten(items: list[Any]) -> Any:
    """Shorten a list of outlines if long: to its length and its common outline."""
    if len(items) <= MAX_OBJECTS or all(isinstance(item, str) and item != SENTENCE for item in items):
        return items
    return {"items": len(items), "each": common(items)}


def common(items: Sequence[Any]) -> Any:
    """Find the outlines' common part: the same value, the names that occur, or the kind of number."""
    if all(item == items[0] for item in items):
        return items[0]
    present = [item for item in items if item is not None]
    if all(isinstance(item, dict) for item in items):
        keys = list(dict.fromkeys(key for item in items for key in item))
        return {
            key if all(key in item for item in items) else f"{key}?": common(
                [x[key] for x in items if key in x]
            )
            for key in keys
        }
    if all(isinstance(item, list) for item in items):
        lengths = sorted({len(item) for item in items})
        inner = [value for item in items for value in item]
        return {
            "items": lengths if len(lengths) > 1 else lengths[0],
            "each": common(inner) if inner else None,
        }
    if all(isinstance(item, bool) for item in present):
        kind: Any = "true or false"
    elif all(isinstance(item, int | float) for item in present):
        kind = NUMBER
    elif all(isinstance(item, str) for item in present):
        kind = " | ".join(sorted(set(present)))
    else:
        kind = " | ".join(sorted({type(item).__name__ for item in present}))
    return kind if len(present) == len(items) else f"{kind} | null"


def _outline_numbers(value: list[Any]) -> Any:
    """Return the outline of a long list of numbers, or of equally long lists of numbers; else None."""
    if len(value) <= MAX_NUMBERS:
        return None
    try:
        array = np.array([[np.nan if x is None else x for x in row] if isinstance(row, list) else
                          np.nan if row is None else row for row in value])  # fmt: skip
    except ValueError:
        return None
    return outline_array(array) if array.dtype.kind in "fiub" else None


def outline_array(array: np.ndarray[Any, Any]) -> dict[str, Any]:
    """Shape and kind of an array, and of numbers the mean, the RMS and how many are none."""
    outlined: dict[str, Any] = {"shape": list(array.shape), "kind": array.dtype.kind}
    if array.dtype.names:
        return {**outlined, "fields": list(array.dtype.names)}
    if array.dtype.kind in "fiub" and array.size:
        numbers = array.astype(np.float64)
        finite = numbers[np.isfinite(numbers)]
        outlined |= {"not_finite": int(numbers.size - finite.size)}
        if finite.size:
            outlined |= {"mean": float(finite.mean()), "rms": float(np.sqrt(np.mean(finite**2)))}
    return outlined


def _outline_text(text: str, folder: str) -> str:
    text = _ROBOTS.sub("ROBOTS/", text.replace(folder, "FOLDER"))
    if " " in text.strip() or "\n" in text:
        return SENTENCE
    return "VERSION" if text == __version__ else without_moments(text)


def without_moments(text: str) -> str:
    """Replace each date, time, hash, serial number and drawn session of a text by its kind.

    The text may be a file's name.
    """
    return _TIME.sub("TIME", _SESSION.sub("RAM-SESSION", _HASH.sub("(a hash)", text)))


def without_numbers(value: Any) -> Any:
    """Return an outline's keys and names alone.

    Lists of numbers are replaced by their shape, lists of objects by their common outline.
    """
    if isinstance(value, dict):
        return {key: without_numbers(item) for key, item in value.items()}
    if isinstance(value, list):
        items = [without_numbers(item) for item in value]
        alike = all(item == items[0] for item in items)
        if items and alike and isinstance(items[0], str) and items[0].endswith(NUMBER):
            return f"{len(items)} x {items[0]}"
        return {"items": len(items), "each": common(items)} if items and isinstance(items[0], dict) else items
    return value if isinstance(value, str | bool) or value is None else NUMBER
