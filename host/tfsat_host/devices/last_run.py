"""The last run as the sequencer measured it, beside the schedule that it flew."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tfsat_host.devices.maneuver_transfer import StoredManeuver
from tfsat_host.protocol.enums import ErrorCode, ResetCause, SequencerState
from tfsat_host.protocol.limits import SCHEDULE_GRID_US
from tfsat_host.protocol.messages import RunReportReply, SequencerStatusReply

_OF_THIS_START = (SequencerState.RUNNING, SequencerState.DONE)
_FAULTS_OF_A_RUN = (
    ErrorCode.STROKE_MISSED,
    ErrorCode.RESET_WHILE_RUNNING,
    ErrorCode.CLOSED_WHILE_RUNNING,
)
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
    """A run since power was switched on.

    Attributes:
        released_us: The release edge on the board's clock, since the start in which it was released.
        since_release_s: How long ago that is, to 1 ms; None where the board may have been reset since.
        bounces: Edges of both switches from the release's first edge to its confirmation.
        earlier_us: The robot may have left so long before the release edge; 0 unless the edges fit two releases.
        later_us: And so long after it.
        planned: Strokes of the maneuver that was flown; None where that on the board is not known to be it.
        onsets: Of the strokes that have begun, in order.
    """

    released_us: int
    since_release_s: float | None
    bounces: int
    earlier_us: int
    later_us: int
    planned: int | None
    onsets: tuple[Onset, ...]


def last_run(
    report: RunReportReply, status: SequencerStatusReply, maneuver: StoredManeuver
) -> LastRun | None:
    """The report in words of the maneuver; None when there was no run since power was switched on.

    Where another maneuver may have been uploaded since the run, the one on the board is taken for the one that
    flew only if every stroke that began did so within half a step of the schedule's grid of its time; a run
    that was ended before its first stroke shows nothing to tell by.
    """
    if not report.released:
        return None
    starts_us = report.start_us[: report.stroke_count]
    scheduled_us = [start_us for _, _, start_us in maneuver.strokes]
    flown = _holds_what_flew(status) or _began_on_schedule(starts_us, scheduled_us)
    onsets = tuple(
        Onset(start_us, scheduled_us[index] if flown and index < len(scheduled_us) else None)
        for index, start_us in enumerate(starts_us)
    )
    return LastRun(
        released_us=report.release_ms * _US_PER_MS + report.release_us,
        since_release_s=(status.uptime_ms - report.release_ms) / 1000 if _in_this_start(status) else None,
        bounces=report.bounces,
        earlier_us=report.earlier_us,
        later_us=report.later_us,
        planned=len(scheduled_us) if flown else None,
        onsets=onsets,
    )


def _holds_what_flew(status: SequencerStatusReply) -> bool:
    """A board takes an upload only when SAFE: until it is so again, it holds the maneuver that it flew."""
    return status.state in _OF_THIS_START or status.fault in _FAULTS_OF_A_RUN


def _began_on_schedule(starts_us: Sequence[int], scheduled_us: Sequence[int]) -> bool:
    return 0 < len(starts_us) <= len(scheduled_us) and all(
        abs(start_us - wanted_us) < SCHEDULE_GRID_US / 2
        for start_us, wanted_us in zip(starts_us, scheduled_us, strict=False)
    )


def _in_this_start(status: SequencerStatusReply) -> bool:
    """The report outlives resets, after which the board is neither RUNNING nor DONE."""
    return status.reset_cause == ResetCause.POWER_ON or status.state in _OF_THIS_START
