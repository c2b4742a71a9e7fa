"""The sequencer's last run, as JSON and as lines of `status`."""

from __future__ import annotations

from tfsat_host.cli.board_state import Rows
from tfsat_host.devices.last_run import Booking, LastRun, Onset
from tfsat_host.protocol.enums import SequencerState
from tfsat_host.quantity import Column, Columns, fields
from tfsat_host.units import US_PER_S

RUN: Columns = (
    *fields("released_uptime_s=released_us since_release_s bounces strokes_missed=missed"),
    Column("release_interval_us", of=lambda run: [-run.earlier_us, run.later_us]),
    Column("strokes_planned", of=lambda run: len(run.onsets)),
    Column("strokes", of="onsets", columns=fields("state=booking.value start_us scheduled_us error_us")),
)
"""For JSON: the release, and each stroke with its schedule; null where that is not known."""


def run_rows(run: LastRun | None, state: SequencerState) -> Rows:
    """The run in a line, and a line for each stroke."""
    if run is None:
        return [("  last run", "none since power was switched on")]
    rows = [
        ("  last run", "; ".join([_released(run), *_extent(run, state), f"{run.bounces} edges of bounce"]))
    ]
    if run.earlier_us or run.later_us:
        rows.append(
            (
                "    ATTENTION",
                "the switches' edges fit two releases: the robot may have left up to "
                f"{run.earlier_us / 1000:.1f} ms before or {run.later_us / 1000:.1f} ms after it",
            )
        )
    return rows + [
        (f"    stroke {number}", _stroke(onset, state)) for number, onset in enumerate(run.onsets, 1)
    ]


def _stroke(onset: Onset, state: SequencerState) -> str:
    if onset.booking == Booking.MISSED:
        return "MISSED: no pulse of it came out on its servo's pin; the joint stayed where it was"
    if onset.booking == Booking.NOT_BEGUN:
        return "not yet" if state == SequencerState.RUNNING else "did not begin: the run ended before"
    if onset.start_us is None:
        return "began; a reset came before its time was noted"
    error = (
        "no stroke of the maneuver on the board is known to be this one"
        if onset.error_us is None
        else f"{onset.error_us:+d} us from the schedule"
    )
    return f"began at {onset.start_us / US_PER_S:.6f} s, {error}"


def _released(run: LastRun) -> str:
    edge = f"released {run.released_us / US_PER_S:.6f} s after the start"
    if run.since_release_s is None:
        return f"{edge} before the last reset, or since"
    return f"{edge}, {run.since_release_s:.1f} s ago"


def _extent(run: LastRun, state: SequencerState) -> list[str]:
    """How far the run came, unless it came to its end."""
    begun, planned = run.begun, len(run.onsets)
    missed = [f"{run.missed} of {planned} strokes MISSED"] if run.missed else []
    if state == SequencerState.RUNNING:
        return [f"{begun} of {planned} strokes so far", *missed]
    if begun + run.missed == planned:
        return missed
    if begun == 0:
        return ["it ended before its first stroke"]
    return [f"it ended after {begun} of {planned} strokes", *missed]
