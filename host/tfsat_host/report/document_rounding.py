"""A document without the digits and poses that no reader can see: a drop is a megabyte otherwise.

A line is drawn a few hundred pixels high and read to four or five digits; the replay moves on screens that show
60 pictures a second. Full precision is in `tfsat-host evaluate --json`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

_REPLAY_STEP_S = 1 / 100
_STEPS_PER_SPAN = 1e5
_MAX_STRING_CHARACTERS = 2000


def shorten_document(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document with its numbers rounded for display and its longest strings cut.

    NaN and infinity become None.

    Raises:
        KeyError: No drops, or a drop without plots.
    """
    cleaned: dict[str, Any] = _clean({**document, "drops": [_drop(drop) for drop in document["drops"]]})
    return cleaned


def _drop(drop: Mapping[str, Any]) -> dict[str, Any]:
    replay = drop.get("replay")
    return {
        **drop,
        "t_s": _round_values(drop["t_s"], 6),
        "plots": [_plot(plot) for plot in drop["plots"]],
        "replay": None if replay is None else _replay(replay),
    }


def _plot(plot: Mapping[str, Any]) -> dict[str, Any]:
    return {
        **plot,
        "x": None if plot["x"] is None else [_significant(x) for x in plot["x"]],
        "series": [_series(series, log=bool(plot["log_y"])) for series in plot["series"]],
    }


def _series(series: Mapping[str, Any], *, log: bool) -> dict[str, Any]:
    values, std = series["values"], series["std"]
    # A logarithmic axis shows ratios: significant digits instead of decimals.
    if log:
        return {
            **series,
            "values": [_significant(value) for value in values],
            "std": None if std is None else [_significant(value) for value in std],
        }
    digits = _digits(values)
    return {
        **series,
        "values": _round_values(values, digits),
        # A band is resolved as its line, or to a thousandth of its own range if that is finer.
        "std": None if std is None else _round_values(std, max(digits, _digits(std) - 2)),
    }


def _replay(replay: Mapping[str, Any]) -> dict[str, Any]:
    """Poses to 0.1 mm and 0.001 deg, no more than a hundred a second; first and last stay."""
    t_s = replay["t_s"]
    pose_indices = _poses_to_keep(t_s)
    model = replay["model"]
    return {
        **replay,
        "t_s": _round_values([t_s[i] for i in pose_indices], 4),
        "measured": [[_pose(pose) for pose in replay["measured"][i]] for i in pose_indices],
        "model": None if model is None else [[_pose(pose) for pose in model[i]] for i in pose_indices],
    }


def _poses_to_keep(t_s: Sequence[float]) -> list[int]:
    """Indices of the poses to keep: one where a step has passed since the last, and both sides of every gap."""
    pose_indices: list[int] = []
    for i, t in enumerate(t_s):
        last = i + 1 == len(t_s)
        if (
            not pose_indices
            or last
            # Without this pose the next one would be more than a step away: near side of a gap.
            or t_s[i + 1] - t_s[pose_indices[-1]] > _REPLAY_STEP_S
            or t - t_s[pose_indices[-1]] >= _REPLAY_STEP_S
        ):
            pose_indices.append(i)
    return pose_indices


def _pose(pose: Sequence[float | None]) -> list[float | None]:
    return _round_values(pose[:3], 4) + _round_values(pose[3:], 5)


def _digits(values: Sequence[float | None]) -> int:
    """Decimal places that divide the range of the values into about a hundred thousand steps."""
    finite = [value for value in values if value is not None and math.isfinite(value)]
    span = max(finite, default=0.0) - min(finite, default=0.0)
    largest = max((abs(value) for value in finite), default=0.0)
    # A constant line has no range: resolve its value instead.
    step = (span or largest) / _STEPS_PER_SPAN
    return math.ceil(-math.log10(step)) if step > 0 else 0


def _round_values(values: Sequence[float | None], digits: int) -> list[float | None]:
    return [
        None if value is None or not math.isfinite(value) else round(float(value), digits) for value in values
    ]


def _significant(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(f"{value:.5g}")


def _clean(part: Any) -> Any:
    """Convert a value to what JSON can hold.

    Numbers get Python's own types, NaN and infinity become None, and long strings are cut.
    """
    if type(part) is float:  # nearly all of it, and the quickest check
        return part if math.isfinite(part) else None
    if part is None or isinstance(part, int):
        return part
    if isinstance(part, Mapping):
        return {str(key): _clean(value) for key, value in part.items()}
    if isinstance(part, str):
        # Strings of a damaged log may be of any length.
        clipped_text = part[:_MAX_STRING_CHARACTERS]
        return part if clipped_text == part else f"{clipped_text}… ({len(part)} characters)"
    if isinstance(part, Sequence):
        return [_clean(item) for item in part]
    return _clean(part.item()) if isinstance(part, np.generic) else part
