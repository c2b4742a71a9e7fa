"""The last run as the sequencer measured it, beside the schedule that it flew."""

from __future__ import annotations

from dataclasses import dataclass

from tfsat_host.devices.maneuver_transfer import StoredManeuver
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.protocol.limits import SCHEDULE_GRID_US
from tfsat_host.protocol.messages import RunReportReply, SequencerStatusReply

_SAME_MANEUVER = (SequencerState.RUNNING, SequencerState.DONE, SequencerState.FAULT)
"""A board takes an upload only when SAFE: in these states it still holds the maneuver that it flew."""
_US_PER_MS = 1000


@dataclass(frozen=True, slots=True)
class Onset:
    """The start of one stroke's first new pulse.

    Attributes:
        start_us: Measured, after the release edge, 0.5 us rounded down.
        scheduled_us: What the maneuver says; None where the one on the board is not known to have flown.
    """

    start_us: int
    scheduled_us: int | None

    @property
    def error_us(self) -> int | None:
        """Measured less scheduled."""
        return None if self.scheduled_us is None else self.start_us - self.scheduled_us


@dataclass(frozen=True, slots=True)
class LastRun:
    """A run since the board started.

    Attributes:
        released_us: The release edge on the board's clock, since it started.
        since_release_s: How long ago that is, to 1 ms.
        bounces: Edges of both switches from the release's first edge to its confirmation.
        onsets: Of the strokes that have begun, in order.
    """

    released_us: int
    since_release_s: float
    bounces: int
    onsets: tuple[Onset, ...]


def last_run(
    report: RunReportReply, status: SequencerStatusReply, maneuver: StoredManeuver
) -> LastRun | None:
    """The report in words of the maneuver; None when there was no run since the board started.

    In SAFE and ARMED another maneuver may have been uploaded since the run. There the schedule on the board is
    taken for the one that flew only if each stroke began within half a step of the schedule's grid of its time.
    """
    if not report.released:
        return None
    starts_us = report.start_us[: report.stroke_count]
    scheduled_us = [start_us for _, _, start_us in maneuver.strokes]
    flown = status.state in _SAME_MANEUVER or (
        len(starts_us) == len(scheduled_us)
        and all(abs(a - b) < SCHEDULE_GRID_US / 2 for a, b in zip(starts_us, scheduled_us, strict=True))
    )
    onsets = tuple(
        Onset(start_us, scheduled_us[index] if flown and index < len(scheduled_us) else None)
        for index, start_us in enumerate(starts_us)
    )
    return LastRun(
        released_us=report.release_ms * _US_PER_MS + report.release_us,
        since_release_s=(status.uptime_ms - report.release_ms) / 1000,
        bounces=report.bounces,
        onsets=onsets,
    )
