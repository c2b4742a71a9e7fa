"""Many rehearsed drops on a terminal: how many were good, and how their numbers are distributed."""

from __future__ import annotations

from tfsat_host.present.output import Output
from tfsat_host.present.terminal import printable, show_facts, show_rows
from tfsat_host.quantity import Column, Columns
from tfsat_host.rehearsal.judgement import DETECTORS
from tfsat_host.rehearsal.series_result import DISTRIBUTION, DetectionCount, SeriesResult

_MAX_REFUSALS = 3
"""Show the pattern; the table has all."""


def show_series(result: SeriesResult, out: Output) -> None:
    """Show how many drops were good, what went wrong, the distributions, and the first line again."""
    show_facts((_DROPS,), result, out)
    show_facts(_FACTS, result, out)
    if result.distributions:
        out.line()
        evaluations = sum(bool(outcome.compared) for outcome in result.outcomes)
        show_rows(DISTRIBUTION, result.distributions, out, title=f"Errors of {evaluations} evaluations")
    show_facts(_FILES, result, out)
    show_facts((_DROPS,), result, out)


def _drops_text(result: SeriesResult) -> str:
    verdicts, dropped = result.verdicts, result.runs - len(result.refused)
    return (
        f"{dropped} of {result.runs} dropped, {verdicts['good']} good, {verdicts['doubtful']} doubtful, "
        f"{verdicts['failed'] + verdicts['none']} not evaluated; {result.samples_lost} samples lost"
    )


def _robots_text(result: SeriesResult) -> str:
    imu = result.outcomes[0].imu
    described = f"IMUs {imu}" if imu else "exactly as its file says"
    return f"seeds from {result.series.seed} of {printable(result.series.filed.path.name)}, {described}"


def _fault_text(count: DetectionCount) -> str:
    by = ", ".join(f"{DETECTORS[who]} {times}" for who, times in count.detected_by.items())
    return (
        f"{count.name}: injected in {count.injected}, detected in {count.detected}{f' ({by})' if by else ''}"
    )


def _missed_text(result: SeriesResult) -> str:
    if not result.missed_outcomes:
        return ""
    return f"NOT as expected with these faults (truth): drop {', '.join(map(str, result.missed_outcomes))}"


def _timing_text(result: SeriesResult) -> str:
    timing = result.stroke_timing
    if timing.rms is None or timing.largest is None:
        return ""
    return f"{timing.rms:.0f} us rms from the schedule, largest {timing.largest:.0f} us (logger's clock)"


def _no_go_text(result: SeriesResult) -> str:
    return ", ".join(f"{name} {times} times" for name, times in result.no_go.items())


def _refused_text(result: SeriesResult) -> str:
    listed = [f"drop {drop.number} ({drop.refused.rstrip('.')})" for drop in result.refused[:_MAX_REFUSALS]]
    more = len(result.refused) - len(listed)
    return "; ".join([*listed, *([f"{more} more"] if more else [])])


_DROPS = Column("", "Drops", words=_drops_text)
_FACTS: Columns = (
    Column("", "Robots", words=_robots_text),
    Column("", "Faults", words=lambda result: "; ".join(map(_fault_text, result.detections))),
    Column("", "Outcome", words=_missed_text),
    Column("", "NO-GO", words=_no_go_text),
    Column("", "Not dropped", words=_refused_text),
    Column("", "Stroke times", words=_timing_text),
)
_FILES: Columns = (
    Column("", "Each drop", words=lambda result: str(result.table)),
    Column("", "To repeat one", words=lambda result: result.command_of_one),
)
