"""Numbers as far as a reader can see them, and strings as long as one can read: a drop is a megabyte otherwise.

A line is drawn a few hundred pixels high and read to four or five digits; the replay moves on screens that show
60 pictures a second. Full precision is in `tfsat-host evaluate --json`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tfsat_host.arrays import FloatArray, IntArray

_REPLAY_STEP_S = 1 / 100
_STEPS_PER_SPAN = 5e4
_MAX_STRING_CHARACTERS = 2000


def round_line(
    values: FloatArray, std: FloatArray | None, *, log: bool
) -> tuple[FloatArray, FloatArray | None]:
    """Return (n,) values of a line and their standard deviations as finely as a plot can show them."""
    # A logarithmic axis shows ratios: significant digits instead of decimals.
    if log:
        return round_to_digits(values), None if std is None else round_to_digits(std)
    decimals = _decimals(values)
    # A band is resolved as its line, or to a thousandth of its own range if that is finer.
    return values.round(decimals), None if std is None else std.round(max(decimals, _decimals(std) - 2))


def round_to_digits(values: FloatArray) -> FloatArray:
    """Return (n,) values with five significant digits."""
    return np.array([float(f"{value:.5g}") for value in values])


def round_poses(poses: FloatArray) -> FloatArray:
    """Return (..., 7) poses with 0.1 mm of their origins, and of their quaternions 0.001 deg."""
    return np.concatenate([poses[..., :3].round(4), poses[..., 3:].round(5)], axis=-1)


def poses_to_keep(t_s: FloatArray) -> IntArray:
    """Return the indices of no more than a hundred poses a second: first and last stay, and both sides of every gap."""
    kept: list[int] = []
    for i, t in enumerate(t_s):
        # Without this pose the next one would be more than a step away: near side of a gap.
        is_gap = i + 1 == len(t_s) or not kept or t_s[i + 1] - t_s[kept[-1]] > _REPLAY_STEP_S
        if is_gap or t - t_s[kept[-1]] >= _REPLAY_STEP_S:
            kept.append(i)
    return np.array(kept, dtype=np.int64)


def _decimals(values: FloatArray) -> int:
    """Return the decimal places that divide the range of the values into fifty thousand steps or more."""
    finite = values[np.isfinite(values)]
    # A constant line has no range: resolve its value instead.
    step = (np.ptp(finite) or np.abs(finite).max()) / _STEPS_PER_SPAN if finite.size else 0.0
    return math.ceil(-math.log10(step)) if step > 0 else 0


def clean(part: Any) -> Any:
    """Convert a value to what JSON can hold.

    Numbers get Python's own types, NaN and infinity become None, and long strings are cut.
    """
    if type(part) is float:  # nearly all of it, and the quickest check
        return part if math.isfinite(part) else None
    if part is None or isinstance(part, int):
        return part
    if isinstance(part, Mapping):
        return {str(key): clean(value) for key, value in part.items()}
    if isinstance(part, str):
        # Strings of a damaged log may be of any length.
        clipped_text = part[:_MAX_STRING_CHARACTERS]
        return part if clipped_text == part else f"{clipped_text}… ({len(part)} characters)"
    if isinstance(part, Sequence):
        return [clean(item) for item in part]
    return clean(part.item()) if isinstance(part, np.generic) else part
