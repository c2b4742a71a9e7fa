"""The clocks of sequencer and video on the logger's scale of time.

The sequencer counts its strokes from the release, which it takes from the same two switches by the same rule as the
logger does; a stroke begins within half a microsecond of its time, by the sequencer's own clock
(docs/sequencer-proof.md). The logger sees the rise of the stroke line. What is left between the two is the rate of
one crystal against the other, and whatever went wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.evaluation.camera import Mark
from tfsat_host.evaluation.clock_fit import GATE_STDS, UNKNOWN_SLOPE, ClockFit, Pair, SlopePrior, fit_clock
from tfsat_host.maneuver import Schedule
from tfsat_host.protocol.limits import FALL_US
from tfsat_host.sdlog import DropLog

EDGE_STD_S = 10e-6
"""Of an edge that the logger's interrupt notes: its clock counts microseconds, and other interrupts make it wait."""
LANDING_STD_S = 0.01
"""Of the landing: the shock takes a sample or two to be one, and longer on a soft cushion."""
BEFORE_S = 0.1
AFTER_S = 0.5
"""Edges of the stroke line count this long before the release and after the longest fall."""
CRYSTAL_PPM = 300.0
"""Two crystals differ by less: three times 100 ppm."""
RESONATOR_PPM = 15_000.0
"""No ceramic resonator is off by more: three times 0.5 %."""
STATED_RATE_STD = 1e-3
"""Relative, of a video's rate that somebody knows: 60 frames a second may really be 59.94."""


@dataclass(frozen=True, eq=False)
class Clocks:
    """The clocks of one drop.

    Attributes:
        sequencer: None if neither the release nor two strokes are known.
        video: None without a video, or if it shares no event with the log, or if its rate cannot be told.
        stroke_s: (m,) when each stroke of the schedule began as the logger saw it, `DropLog.t_s`; NaN if it did not.
        notes: What could not be aligned, and why.
    """

    sequencer: ClockFit | None
    video: ClockFit | None
    stroke_s: tuple[float, ...]
    notes: tuple[str, ...]


def align_clocks(
    log: DropLog, schedule: Schedule, video: Sequence[Mark] = (), video_rate: float | None = None
) -> Clocks:
    """Align the sequencer's and the video's clocks with the logger's by release, strokes and landing.

    `video_rate`: seconds of the video's clock per real second: 1 in real time, 4 in slow motion of a quarter;
    None if unknown, to be found from the events.
    """
    edges_s = stroke_edges(log)
    release = _release(log)
    # Strokes that begin together raise the line once: one start, one edge.
    starts_s, start_of_stroke = np.unique([stroke.t_s for stroke in schedule.strokes], return_inverse=True)
    notes: list[str] = []
    # Among so many edges any schedule fits somewhere by chance: use none of them.
    if len(edges_s) > MAX_EDGES:
        notes.append(
            f"The stroke line rose {len(edges_s)} times in the drop: it chatters, and no stroke can be told from it."
        )
        edges_s = np.zeros(0)
    matched = match_starts(starts_s, edges_s, None if release is None else release.t_s)
    # A start is named after its first stroke.
    names = [f"stroke {np.flatnonzero(start_of_stroke == start)[0] + 1}" for start in range(len(starts_s))]
    # The sequencer begins each stroke within half a microsecond of its time: its reading is the schedule.
    pairs = [
        Pair(names[start], float(starts_s[start]), float(edges_s[edge]), EDGE_STD_S)
        for start, edge in matched.edge_of_start.items()
    ]
    stroke_s = tuple(
        float(edges_s[matched.edge_of_start[start]]) if start in matched.edge_of_start else float("nan")
        for start in start_of_stroke.tolist()
    )
    if release is not None:
        # The sequencer counts from the release: there it reads zero.
        pairs.append(Pair("release", 0.0, release.t_s, release.std_s))
    sequencer = None
    if pairs:
        unseen = [n for n, start in enumerate(start_of_stroke.tolist(), 1) if start in matched.unseen]
        sequencer = _sequencer_fit(pairs, _of_matching(unseen, edges_s[list(matched.extra)]))
    else:
        notes.append(
            "The sequencer's clock is unknown: the log holds neither a release nor strokes that fit."
        )
    marks = [
        *([release] if release else []),
        *(Mark(f"stroke {n}", t_s, EDGE_STD_S) for n, t_s in enumerate(stroke_s, 1) if np.isfinite(t_s)),
    ]
    # The landing is no event of the sequencer's, but a video shows it: use it there only.
    video_fit = _video_fit(video, [*marks, *_landing_marks(log)], video_rate, notes) if video else None
    return Clocks(sequencer, video_fit, stroke_s, tuple(notes))


def stroke_edges(log: DropLog) -> FloatArray:
    """(k,) rises of the stroke line in the drop; in all of the recording where no release bounds it."""
    edges = np.array(
        sorted(log.seconds(event.t_us) for event in log.events if event.name == "stroke"), dtype=np.float64
    )
    if log.release is None:
        return edges
    return edges[(edges >= -BEFORE_S) & (edges <= FALL_US / 1e6 + AFTER_S)]


def _release(log: DropLog) -> Mark | None:
    """Return the logger's release; if blocks are lost, the middle of its earliest and latest times."""
    if log.release is None:
        return None
    # With lost blocks the release lies evenly between two times: half the width over sqrt(3).
    middle_us = (log.release.earliest_us + log.release.latest_us) / 2
    half_s = (log.release.latest_us - log.release.earliest_us) / 2e6
    return Mark("release", (middle_us - log.release.t_us) / 1e6, float(np.hypot(EDGE_STD_S, half_s / 3**0.5)))


def _landing_marks(log: DropLog) -> list[Mark]:
    """Return the landing if the logger felt it; a landing that was only timed out is no use for a clock."""
    shocks = [event for event in log.events if event.name == "landing" and event.arg == 1]
    felt = [event for event in shocks if log.release is None or event.t_us > log.release.t_us]
    return [Mark("landing", log.seconds(event.t_us), LANDING_STD_S) for event in felt[:1]]


def _of_matching(unseen: Sequence[int], extra_edges_s: FloatArray) -> list[str]:
    findings = [f"Stroke {number} was not seen by the logger." for number in unseen]
    return findings + [
        f"The stroke line rose at {edge_s:.4f} s, where no stroke was scheduled." for edge_s in extra_edges_s
    ]


def _sequencer_fit(pairs: list[Pair], of_matching: list[str]) -> ClockFit:
    fit = fit_clock("sequencer", pairs)
    findings = [*fit.findings, *of_matching]
    off, sure = abs(fit.rate_ppm), abs(fit.rate_ppm) - 2.0 * fit.rate_ppm_std
    last = max(pairs, key=lambda pair: pair.clock_s)
    how = "fast" if fit.rate_ppm > 0.0 else "slow"
    # No oscillator is off so far: it is the schedule that does not belong to the recording.
    if sure > RESONATOR_PPM:
        findings.append(
            f"The sequencer's clock seems to run {off / 1e4:.2f} % {how}, as no oscillator does: "
            "the schedule is not the one that was flown."
        )
    # More than two sound crystals differ: say what it makes at the last stroke, where it is greatest.
    elif sure > CRYSTAL_PPM:
        findings.append(
            f"The sequencer's clock runs {off / 1e4:.3f} % {how} against the logger's, "
            f"more than two crystals differ ({CRYSTAL_PPM / 1e4:g} %): {last.event} came "
            f"{1e3 * abs(last.clock_s * (fit.slope - 1.0)):.2g} ms {'early' if how == 'fast' else 'late'}."
        )
    return replace(fit, findings=tuple(findings))


def _video_fit(
    video: Sequence[Mark], logged: Sequence[Mark], rate: float | None, notes: list[str]
) -> ClockFit | None:
    by_event = {mark.event: mark for mark in logged}
    pairs = [
        Pair(
            mark.event,
            mark.t_s,
            by_event[mark.event].t_s,
            float(np.hypot(mark.std_s, by_event[mark.event].std_s)),
        )
        for mark in video
        if mark.event in by_event
    ]
    missing = [mark.event for mark in video if mark.event not in by_event]
    if missing:
        notes.append(f"The video's {', '.join(missing)} could not be used: the log does not hold it.")
    if not pairs:
        notes.append("The video's clock is unknown: it shares no event with the log.")
        return None
    # One event fixes an offset only, and slow motion leaves the rate free.
    if rate is None and len(pairs) == 1:
        notes.append(
            f"The video's clock is unknown: of one event, {pairs[0].event}, no rate follows, and it may be slow "
            "motion. Read off another event, or say how fast its times run: --video-rate 1 in real time."
        )
        return None
    # Fit without a prior even where a rate is stated, to hold the statement against the events.
    by_events = fit_clock("video", pairs, UNKNOWN_SLOPE)
    if rate is None:
        if not by_events.ambiguous:
            return by_events
        notes.append(
            "The video's clock is unknown: its events contradict each other, and more than one rate suits as many of "
            "them. Read them off again, or say how fast its times run: --video-rate 1 in real time."
        )
        return None
    # Relative deviation of the slope: that of the events' fit, and that of the statement.
    sure = GATE_STDS * np.hypot(1e-6 * by_events.rate_ppm_std * by_events.slope, STATED_RATE_STD)
    if len(pairs) > 1 and not by_events.ambiguous and abs(np.log(by_events.slope * rate)) > sure:
        notes.append(
            f"The video's clock is unknown: --video-rate says {rate:g}, and its events {1.0 / by_events.slope:.4g}."
        )
        return None
    return fit_clock("video", pairs, SlopePrior(1.0 / rate, STATED_RATE_STD / rate))


MAX_EDGES = 64
"""More than four times what a maneuver can have: a line that chatters, of which nothing is believed."""
NEAR_S = 1e-3
"""An edge as near as this to where a line expects it is that start's."""
ASTRAY_S = 0.15
"""Within this an edge that is left is a start that is left, only early or late."""
_STEEPEST = 0.03
"""Clocks that differ by more than 3 % are not tried."""


@dataclass(frozen=True, slots=True)
class MatchedEdges:
    """Edges by start.

    Attributes:
        edge_of_start: For each start that has one the index of its edge; both ascend.
        unseen: Starts without an edge, from 0.
        extra: Edges without a start.
    """

    edge_of_start: dict[int, int]
    unseen: tuple[int, ...]
    extra: tuple[int, ...]


def match_starts(starts_s: FloatArray, edge_s: FloatArray, release_s: float | None) -> MatchedEdges:
    """Match the strokes' starts to edges such that most events, the release among them, lie on one line of time.

    Args:
        starts_s: (m,) each later than the one before, above zero, after the release.
        edge_s: (k,) ascending, `MAX_EDGES` at most, on the logger's clock.
        release_s: The release on the logger's clock; None if unknown, then two edges suffice without it.
    """
    # Exhaustive consensus: try each line through two events and count what else lies on it.
    lines = _lines(starts_s, edge_s, release_s)
    assignments = [_near(slope, start, starts_s, edge_s) for start, slope in lines]
    if not assignments:
        return MatchedEdges({}, tuple(range(len(starts_s))), tuple(range(len(edge_s))))

    def merit(index: int) -> tuple[int, float]:
        start, slope = lines[index]
        # The release counts as one more inlier; of as many, the clock nearest to the logger's rate wins.
        at_release = release_s is not None and abs(start - release_s) <= NEAR_S
        return len(assignments[index]) + at_release, -abs(slope - 1.0)

    best = max(range(len(lines)), key=merit)
    start, slope = lines[best]
    chosen = dict(assignments[best])
    late = _astray(starts_s * slope + start, edge_s, chosen)
    chosen.update(late)
    return MatchedEdges(
        dict(sorted(chosen.items())),
        tuple(i for i in range(len(starts_s)) if i not in chosen),
        tuple(k for k in range(len(edge_s)) if k not in chosen.values()),
    )


def _lines(starts_s: FloatArray, edge_s: FloatArray, release_s: float | None) -> list[tuple[float, float]]:
    """Start and slope of every line worth a try."""
    lines = []
    if release_s is not None:
        # (m, k) slope of the line from the release to start i at edge j.
        slopes = (edge_s[None, :] - release_s) / starts_s[:, None]
        lines = [(release_s, 1.0)] + [
            (release_s, float(slope)) for slope in slopes[np.abs(slopes - 1.0) <= _STEEPEST]
        ]
    # Lines through two starts need no release: it may be lost, or wrong itself.
    for i, k in combinations(range(len(starts_s)), 2):
        planned = float(starts_s[k] - starts_s[i])
        # (k, k) slope if the row's edge is the earlier start and the column's the later one.
        slopes = (edge_s[None, :] - edge_s[:, None]) / planned
        for first, last in np.argwhere(np.abs(slopes - 1.0) <= _STEEPEST).tolist():
            slope = float(slopes[first, last])
            lines.append((float(edge_s[first] - slope * starts_s[i]), slope))
    return lines


def _near(slope: float, start: float, starts_s: FloatArray, edge_s: FloatArray) -> dict[int, int]:
    """Find the nearest edge of each start within `NEAR_S`; no edge is used twice."""
    if not len(edge_s):
        return {}
    apart = np.abs(start + slope * starts_s[:, None] - edge_s[None, :])
    nearest = apart.argmin(axis=1)
    edge_of_start: dict[int, int] = {}
    for start_index, edge in enumerate(nearest.tolist()):
        if apart[start_index, edge] <= NEAR_S and edge not in edge_of_start.values():
            edge_of_start[start_index] = edge
    return edge_of_start


def _astray(expected_s: FloatArray, edge_s: FloatArray, chosen: dict[int, int]) -> dict[int, int]:
    """Match the remaining starts and edges, nearest pair first, as long as their order is kept."""
    edge_of_start: dict[int, int] = {}
    apart = np.abs(expected_s[:, None] - edge_s[None, :])
    # All pairs of start and edge, the nearest first; a stable sort makes ties reproducible.
    nearest = np.column_stack(np.unravel_index(np.argsort(apart, axis=None, kind="stable"), apart.shape))
    for start, edge in nearest.tolist():
        assigned_edges = {**chosen, **edge_of_start}
        # Sorted by distance: all that follow are farther still.
        if apart[start, edge] > ASTRAY_S:
            break
        if start in assigned_edges or edge in assigned_edges.values():
            continue
        # The sequencer flies its strokes in order: a pair that would cross another is wrong.
        if all((start < other) == (edge < at) for other, at in assigned_edges.items()):
            edge_of_start[start] = edge
    return edge_of_start
