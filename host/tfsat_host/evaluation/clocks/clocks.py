"""The clocks of sequencer and video on the logger's scale of time.

The sequencer counts its strokes from the release, which it takes from the same two switches by the same rule as the
logger does; a stroke begins within half a microsecond of its time, by the sequencer's own clock
(docs/sequencer-proof.md). The logger sees the rise of the stroke line. What is left between the two is the rate of
one crystal against the other, and whatever went wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tfsat_host.evaluation.clocks.clock_fit import ClockFit, Pair, fit_clock
from tfsat_host.evaluation.clocks.stroke_matching import MOST_EDGES, Matched, match_strokes
from tfsat_host.evaluation.clocks.video import Mark
from tfsat_host.maneuver import Schedule
from tfsat_host.protocol.limits import FALL_US
from tfsat_host.sdlog import DropLog

FloatArray = NDArray[np.float64]

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
FRAME_RATE_PPM = 2_000.0
"""A video of 60 frames a second that is really one of 59.94 is off by 1000 ppm."""


@dataclass(frozen=True, eq=False)
class Clocks:
    """The clocks of one drop.

    Attributes:
        sequencer: None if neither the release nor two strokes are known.
        video: None without a video, or if it shares no event with the log.
        stroke_s: (m,) when each stroke of the schedule began as the logger saw it, `DropLog.t_s`; NaN if it did not.
        notes: What could not be aligned, and why.
    """

    sequencer: ClockFit | None
    video: ClockFit | None
    stroke_s: tuple[float, ...]
    notes: tuple[str, ...]


def align_clocks(log: DropLog, schedule: Schedule, video: Sequence[Mark] = ()) -> Clocks:
    """The sequencer's clock and the video's, by release, strokes and landing.

    Args:
        log: A decoded drop.
        schedule: What the sequencer was told to fly.
        video: See `video.read_video_marks`.
    """
    edges_s = stroke_edges(log)
    release = _release(log)
    scheduled_s = np.array([stroke.t_s for stroke in schedule.strokes])
    notes: list[str] = []
    if len(edges_s) > MOST_EDGES:
        notes.append(
            f"The stroke line rose {len(edges_s)} times in the drop: it chatters, and no stroke can be told from it."
        )
        edges_s = np.zeros(0)
    matched = match_strokes(scheduled_s, edges_s, None if release is None else release.t_s)
    seen = [
        Mark(f"stroke {stroke + 1}", float(edges_s[edge]), EDGE_STD_S)
        for stroke, edge in matched.edge_of_stroke.items()
    ]
    known = [*([release] if release else []), *seen]
    pairs = [
        Pair(mark.event, float(scheduled_s[int(mark.event.split()[1]) - 1]), mark.t_s, mark.std_s)
        for mark in seen
    ]
    if release is not None:
        pairs.append(Pair("release", 0.0, release.t_s, release.std_s))
    sequencer = None
    if pairs:
        sequencer = _sequencer_fit(pairs, _of_matching(matched, edges_s))
    else:
        notes.append(
            "The sequencer's clock is unknown: the log holds neither a release nor strokes that fit."
        )
    video_fit = _video_fit(video, [*known, *_landing(log)], notes) if video else None
    by_stroke = {mark.event: mark.t_s for mark in seen}
    stroke_s = tuple(by_stroke.get(f"stroke {n}", float("nan")) for n in range(1, len(scheduled_s) + 1))
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
    """The logger's release; where blocks are lost, anywhere between the earliest and the latest."""
    if log.release is None:
        return None
    middle_us = (log.release.earliest_us + log.release.latest_us) / 2
    half_s = (log.release.latest_us - log.release.earliest_us) / 2e6
    return Mark("release", (middle_us - log.release.t_us) / 1e6, float(np.hypot(EDGE_STD_S, half_s / 3**0.5)))


def _landing(log: DropLog) -> list[Mark]:
    """The landing, if the logger felt it; one that it only counted off says nothing of a clock."""
    shocks = [event for event in log.events if event.name == "landing" and event.arg == 1]
    felt = [event for event in shocks if log.release is None or event.t_us > log.release.t_us]
    return [Mark("landing", log.seconds(event.t_us), LANDING_STD_S) for event in felt[:1]]


def _of_matching(matched: Matched, edges_s: FloatArray) -> list[str]:
    found = [f"Stroke {stroke + 1} was not seen by the logger." for stroke in matched.unseen]
    return found + [
        f"The stroke line rose at {edges_s[edge]:.4f} s, where no stroke was scheduled."
        for edge in matched.extra
    ]


def _sequencer_fit(pairs: list[Pair], of_matching: list[str]) -> ClockFit:
    fit = fit_clock("sequencer", pairs)
    found = [*fit.findings, *of_matching]
    off, sure = abs(fit.rate_ppm), abs(fit.rate_ppm) - 2.0 * fit.rate_ppm_std
    last = max(pairs, key=lambda pair: pair.clock_s)
    how = "fast" if fit.rate_ppm > 0.0 else "slow"
    if sure > RESONATOR_PPM:
        found.append(
            f"The sequencer's clock seems to run {off / 1e4:.2f} % {how}, as no oscillator does: "
            "the schedule is not the one that was flown."
        )
    elif sure > CRYSTAL_PPM:
        found.append(
            f"The sequencer's clock runs {off / 1e4:.3f} % {how} against the logger's, "
            f"more than two crystals differ ({CRYSTAL_PPM / 1e4:g} %): {last.event} came "
            f"{1e3 * abs(last.clock_s * (fit.slope - 1.0)):.2g} ms {'early' if how == 'fast' else 'late'}."
        )
    return replace(fit, findings=tuple(found))


def _video_fit(video: Sequence[Mark], logged: Sequence[Mark], notes: list[str]) -> ClockFit | None:
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
    fit = fit_clock("video", pairs)
    found = list(fit.findings)
    if abs(fit.rate_ppm) - 2.0 * fit.rate_ppm_std > FRAME_RATE_PPM:
        found.append(
            f"The video's clock differs by {fit.rate_ppm / 1e4:+.2f} % from the logger's: "
            "its times were made with another frame rate than it was taken with."
        )
    return replace(fit, findings=tuple(found))
