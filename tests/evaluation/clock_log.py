"""A log whose release and stroke edges lie wherever a test wants them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from tests.sdlog.motion import moving_log
from tfsat_host.sdlog import DropEvent, DropLog


def log_with(path: Path, strokes_s: Sequence[float], *, landing_s: float | None = None) -> DropLog:
    """Times after the release, kept to a microsecond as the logger does."""
    # moving_log has a release and strokes of its own: only its release is kept.
    log = moving_log(path)
    times = [("stroke", t_s, 0) for t_s in strokes_s]
    times += [] if landing_s is None else [("landing", landing_s, 1)]
    added_events = [
        # Rounded to a microsecond, the resolution of the logger's clock.
        DropEvent(log.origin_us + round(1e6 * t_s), name, index, arg, 0)
        for index, (name, t_s, arg) in enumerate(times)
    ]
    other_events = [event for event in log.events if event.name not in ("stroke", "landing")]
    return replace(log, events=tuple(sorted([*other_events, *added_events], key=lambda event: event.t_us)))
