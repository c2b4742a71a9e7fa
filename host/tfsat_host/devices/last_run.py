"""The last run as the sequencer measured it, against the schedule that it flew."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from tfsat_host.devices.sequencer import StoredManeuver
from tfsat_host.protocol.enums import ErrorCode, ResetCause, SequencerState
from tfsat_host.protocol.limits import SCHEDULE_GRID_US, STROKE_NOT_BEGUN_US, STROKE_TIME_UNKNOWN_US
from tfsat_host.protocol.messages import RunReportReply, SequencerStatusReply

# After a reset the board is in neither: a run reported in them is of the present start.
_OF_THIS_START = (SequencerState.RUNNING, SequencerState.DONE)
# Faults that end a run and hold until a disarm, so that nothing was uploaded since.
_FAULTS_OF_A_RUN = (
    ErrorCode.STROKE_MISSED,
    ErrorCode.RESET_WHILE_RUNNING,
    ErrorCode.CLOSED_WHILE_RUNNING,
)
_US_PER_MS = 1000


class StrokeStatus(Enum):
    """What the board knows of a stroke."""

    BEGUN = "begun"
    BEGUN_UNTIMED = "begun_untimed"
    """A reset came before its time was stored."""
    NOT_BEGUN = "not_begun"
    """The run has not come to it, or ended before."""
    MISSED = "missed"
    """Its time came, and no pulse of it came out on its servo's pin."""


@dataclass(frozen=True, slots=True)
class Onset:
    """The start of one stroke, or that there was none.

    Attributes:
        booking: Whether it began.
        start_us: Rise of its first whole pulse on the servo's pin, after the release edge, 0.5 us rounded down;
            None where it did not begin, or the time is not known.
        scheduled_us: What the maneuver says; None where the one on the board is not known to have flown.
    """

    booking: StrokeStatus
    start_us: int | None
    scheduled_us: int | None

    @property
    def error_us(self) -> int | None:
        """Measured less scheduled."""
        if self.scheduled_us is None or self.start_us is None:
            return None
        return self.start_us - self.scheduled_us


@dataclass(frozen=True, slots=True)
class LastRun:
    """A run since power was switched on.

    Attributes:
        released_us: The release edge on the board's clock, since the start in which it was released.
        since_release_s: How long ago that is, to 1 ms; None where the board may have been reset since.
        bounces: Edges of both switches from the release's first edge to its confirmation.
        earlier_us: The robot may have left so long before the release edge; 0 unless the edges, or lost ones, fit two.
        later_us: And so long after it.
        onsets: Of all strokes of the maneuver that flew, in its order.
    """

    released_us: int
    since_release_s: float | None
    bounces: int
    earlier_us: int
    later_us: int
    onsets: tuple[Onset, ...]

    @property
    def begun(self) -> int:
        """Strokes that began."""
        return sum(onset.booking in (StrokeStatus.BEGUN, StrokeStatus.BEGUN_UNTIMED) for onset in self.onsets)

    @property
    def missed(self) -> int:
        """Strokes that were due and did not begin."""
        return sum(onset.booking == StrokeStatus.MISSED for onset in self.onsets)


def last_run(
    report: RunReportReply, status: SequencerStatusReply, maneuver: StoredManeuver
) -> LastRun | None:
    """Match the report with the maneuver's strokes; None if there was no run since power was switched on.

    If another maneuver may have been uploaded since the run, the one on the board is taken for the one that
    flew only if it has as many strokes and every stroke that began did so within half a step of the schedule's
    grid of its time; a run that was ended before its first stroke shows nothing to tell by.
    """
    if not report.released:
        return None
    reported_us = report.start_us[: report.stroke_count]
    scheduled_us = [start_us for _, _, start_us in maneuver.strokes]
    # Scheduled times belong to the report only where the maneuver on the board is the one that flew.
    has_flown = holds_what_flew(status) or _began_on_schedule(reported_us, scheduled_us)
    # The report outlives resets, after which the board is neither RUNNING nor DONE.
    in_this_start = status.reset_cause == ResetCause.POWER_ON or status.state in _OF_THIS_START
    return LastRun(
        released_us=report.release_ms * _US_PER_MS + report.release_us,
        since_release_s=(status.uptime_ms - report.release_ms) / 1000 if in_this_start else None,
        bounces=report.bounces,
        earlier_us=report.earlier_us,
        later_us=report.later_us,
        onsets=tuple(
            Onset(
                booking,
                reported_us[index] if booking == StrokeStatus.BEGUN else None,
                scheduled_us[index] if has_flown and index < len(scheduled_us) else None,
            )
            for index, booking in enumerate(_bookings(reported_us, status))
        ),
    )


def _bookings(reported_us: Sequence[int], status: SequencerStatusReply) -> list[StrokeStatus]:
    """Classify each stroke of the run as begun, begun without a time, not begun or missed.

    A stroke that did not begin was missed if the run came to its end, or a later stroke began.
    """
    to_the_end = status.fault == ErrorCode.STROKE_MISSED
    bookings = []
    for index, start_us in enumerate(reported_us):
        # A stroke is missed only if its time has come: the run's end, or a later onset, shows that.
        came_by = to_the_end or any(later_us != STROKE_NOT_BEGUN_US for later_us in reported_us[index + 1 :])
        if start_us == STROKE_NOT_BEGUN_US:
            bookings.append(StrokeStatus.MISSED if came_by else StrokeStatus.NOT_BEGUN)
        else:
            bookings.append(
                StrokeStatus.BEGUN_UNTIMED if start_us == STROKE_TIME_UNKNOWN_US else StrokeStatus.BEGUN
            )
    return bookings


def holds_what_flew(status: SequencerStatusReply) -> bool:
    """Return whether the board still holds the maneuver that it flew.

    A board takes an upload only when SAFE: until it is so again, it holds the maneuver that it flew.
    """
    return status.state in _OF_THIS_START or status.fault in _FAULTS_OF_A_RUN


def _began_on_schedule(reported_us: Sequence[int], scheduled_us: Sequence[int]) -> bool:
    # Stroke times lie on the grid: within half a step, no other time of the schedule is meant.
    timed = [
        abs(start_us - wanted_us) < SCHEDULE_GRID_US / 2
        for start_us, wanted_us in zip(reported_us, scheduled_us, strict=False)
        if start_us not in (STROKE_NOT_BEGUN_US, STROKE_TIME_UNKNOWN_US)
    ]
    return len(reported_us) == len(scheduled_us) and bool(timed) and all(timed)
