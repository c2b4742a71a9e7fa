"""Which edge of the stroke line is which stroke: edges carry no name, may be missing, and some may be too many."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

MOST_EDGES = 64
"""More than four times what a maneuver can have: a line that chatters, of which nothing is believed."""
NEAR_S = 1e-3
"""An edge as near as this to where a line expects it is that stroke's."""
ASTRAY_S = 0.15
"""Within this an edge that is left is a stroke that is left, only early or late: strokes lie further apart."""
_STEEPEST = 0.03
"""Clocks that differ by more than 3 % are not tried."""


@dataclass(frozen=True, slots=True)
class Matched:
    """Edges by stroke.

    Attributes:
        edge_of_stroke: For each stroke that has one the index of its edge; both ascend.
        unseen: Strokes without an edge, from 0.
        extra: Edges without a stroke.
    """

    edge_of_stroke: dict[int, int]
    unseen: tuple[int, ...]
    extra: tuple[int, ...]


def match_strokes(scheduled_s: FloatArray, edge_s: FloatArray, release_s: float | None) -> Matched:
    """The assignment that puts the most events on one line of time, the release among them.

    Args:
        scheduled_s: (m,) ascending, above zero, after the release.
        edge_s: (k,) ascending, `MOST_EDGES` at most, on the logger's clock.
        release_s: The release on the logger's clock; None if it is unknown. Two edges tell without it.
    """
    lines = _lines(scheduled_s, edge_s, release_s)
    assignments = [_near(slope, start, scheduled_s, edge_s, NEAR_S) for start, slope in lines]
    if not assignments:
        return Matched({}, tuple(range(len(scheduled_s))), tuple(range(len(edge_s))))

    def merit(index: int) -> tuple[int, float]:
        start, slope = lines[index]
        at_release = release_s is not None and abs(start - release_s) <= NEAR_S
        return len(assignments[index]) + at_release, -abs(slope - 1.0)

    best = max(range(len(lines)), key=merit)
    start, slope = lines[best]
    chosen = dict(assignments[best])
    late = _astray(scheduled_s * slope + start, edge_s, chosen)
    chosen.update(late)
    return Matched(
        dict(sorted(chosen.items())),
        tuple(i for i in range(len(scheduled_s)) if i not in chosen),
        tuple(k for k in range(len(edge_s)) if k not in chosen.values()),
    )


def _lines(scheduled_s: FloatArray, edge_s: FloatArray, release_s: float | None) -> list[tuple[float, float]]:
    """Start and slope of every line worth a try."""
    lines = []
    if release_s is not None:
        slopes = (edge_s[None, :] - release_s) / scheduled_s[:, None]
        lines = [(release_s, 1.0)] + [
            (release_s, float(slope)) for slope in slopes[np.abs(slopes - 1.0) <= _STEEPEST]
        ]
    for i, k in combinations(range(len(scheduled_s)), 2):
        planned = float(scheduled_s[k] - scheduled_s[i])
        slopes = (edge_s[None, :] - edge_s[:, None]) / planned
        for first, last in np.argwhere(np.abs(slopes - 1.0) <= _STEEPEST).tolist():
            slope = float(slopes[first, last])
            lines.append((float(edge_s[first] - slope * scheduled_s[i]), slope))
    return lines


def _near(
    slope: float, start: float, scheduled_s: FloatArray, edge_s: FloatArray, reach_s: float
) -> dict[int, int]:
    """The nearest edge of each stroke, if within `reach_s`; no edge twice."""
    if not len(edge_s):
        return {}
    apart = np.abs(start + slope * scheduled_s[:, None] - edge_s[None, :])
    nearest = apart.argmin(axis=1)
    found: dict[int, int] = {}
    for stroke, edge in enumerate(nearest.tolist()):
        if apart[stroke, edge] <= reach_s and edge not in found.values():
            found[stroke] = edge
    return found


def _astray(expected_s: FloatArray, edge_s: FloatArray, chosen: dict[int, int]) -> dict[int, int]:
    """Of what is left, the nearest edge and stroke first, so long as the order of strokes stays."""
    found: dict[int, int] = {}
    apart = np.abs(expected_s[:, None] - edge_s[None, :])
    nearest = np.column_stack(np.unravel_index(np.argsort(apart, axis=None, kind="stable"), apart.shape))
    for stroke, edge in nearest.tolist():
        taken = {**chosen, **found}
        if apart[stroke, edge] > ASTRAY_S:
            break
        if stroke in taken or edge in taken.values():
            continue
        if all((stroke < other) == (edge < at) for other, at in taken.items()):
            found[stroke] = edge
    return found
