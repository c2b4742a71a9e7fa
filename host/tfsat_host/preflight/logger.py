"""What a preflight asks of the logger. What is switched on is switched off again."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime

import numpy as np

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.devices.client import BoardError
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.preflight.checks.calibration import landed_unnoted
from tfsat_host.preflight.evidence import (
    Clock,
    LiveSamples,
    LoggerAnswers,
    Missing,
    Running,
    Trial,
    pace_between,
    status_at,
)
from tfsat_host.preflight.trial import Trace, trial_recording
from tfsat_host.protocol.enums import CardState, DropPhase, LoggerState
from tfsat_host.protocol.limits import PARTIAL_BLOCK_MS, RING_BLOCKS, SAMPLES_PER_BLOCK
from tfsat_host.protocol.messages import LiveSampleStream, LoggerSettings, LoggerStatusReply
from tfsat_host.units import US_PER_S

WATCH_S = 6.0
"""Of live samples, and of the recording: a pace to 0.1 %, twenty syncs of the card, a mean of 1700 samples."""
STEP_S = 0.25

Advance = Callable[[float], None]


def ask_logger(
    logger: LoggerClient,
    now_s: Clock,
    unix_s: Clock,
    calibration: Calibration | Missing,
    trace: Trace,
    advance: Advance = lambda _seconds: None,
) -> LoggerAnswers:
    """Asks for everything; takes `WATCH_S` and what a recording takes to be opened, closed and read back.

    Args:
        logger: Connected.
        now_s: The transport's clock.
        unix_s: The computer's time of day.
        calibration: The certificate, with its landings.
        trace: Gets what of the recording could not be removed again, even when this is interrupted.
        advance: Called with how many seconds of `WATCH_S` went by.

    Raises:
        BoardError, NoAnswer, PortError: of the requests; the recording was removed, or `trace` says that not.
    """
    first = status_at(logger.status, now_s)
    computer_unix_s = unix_s() - (first.had_s - first.asked_s) / 2
    status, settings = first.status, logger.settings().settings
    since = _recording_since(logger, status)
    unnoted = landed_unnoted(status, since, computer_unix_s, calibration)
    card: Trial | Running | Missing
    if status.state == LoggerState.RECORDING:
        live = _live(logger, advance)
        card = _watched(status, logger.status(), settings)
    elif (reason := _no_trial(status, unnoted)) is not None:
        card, live = reason, _live(logger, advance)
    else:
        card, live = trial_recording(logger, status, trace, lambda: _live(logger, advance))
    last = status_at(logger.status, now_s)
    return LoggerAnswers(
        status,
        last.status,
        computer_unix_s,
        settings,
        live,
        card,
        since,
        pace_between(first, last),
        trace.left,
    )


def _no_trial(status: LoggerStatusReply, unnoted_landing: bool) -> Missing | None:
    """Why no recording may be made now; None: one may."""
    if status.ram_holds_drop:
        return Missing("No recording was made: it would cost the drop in RAM.", "tfsat-host log fetch ram")
    if status.state == LoggerState.FAILED:
        return Missing(
            "No recording was made: the last one failed, and RAM still has its newest seconds.",
            "tfsat-host log fetch ram if they matter; then switch the logger off and on.",
        )
    if status.state == LoggerState.STOPPING:
        return Missing("The logger still closes its last recording.", "Wait, then run this preflight again.")
    if unnoted_landing:
        return Missing(
            "No recording was made: the logger would forget the landing of its last one, which is not in the "
            "certificate yet.",
            "tfsat-host log fetch all, then tfsat-host decode of it beside the certificate.",
        )
    if status.card != CardState.READY:
        return Missing("No recording was made: the card takes none.", "See card and card-room.")
    return None


def _recording_since(logger: LoggerClient, status: LoggerStatusReply) -> datetime | None:
    """When the last recording began, by the card's list; None: it runs, or the logger's clock was not set."""
    if not status.session or status.state in (LoggerState.RECORDING, LoggerState.STOPPING):
        return None
    try:
        entries = logger.logs()
    except BoardError:
        return None
    began_us = [one.wall_clock_us for one in entries if one.session == status.session and one.wall_clock_us]
    try:
        return datetime.fromtimestamp(began_us[0] / US_PER_S, UTC) if began_us else None
    except (OverflowError, ValueError, OSError):
        return None  # a time beyond all calendars


def _live(logger: LoggerClient, advance: Advance) -> LiveSamples | Missing:
    """`WATCH_S` of live samples; Missing: none came. Raises PortError."""
    samples: list[LiveSampleStream] = []
    with logger.live() as reply:
        for _ in range(round(WATCH_S / STEP_S)):
            samples += logger.samples_of(STEP_S)
            advance(STEP_S)
    if not samples:
        return Missing(
            f"The logger sent no live sample in {WATCH_S:g} s.",
            "tfsat-host status; switch the logger off and on, then run this preflight again.",
        )
    return LiveSamples(
        Counts.from_live(samples, reply), np.array([sample.index for sample in samples], dtype=np.int64)
    )


def _watched(
    before: LoggerStatusReply, after: LoggerStatusReply, settings: LoggerSettings
) -> Running | Missing:
    if after.state != LoggerState.RECORDING or after.session != before.session:
        return Missing("The recording that ran ended meanwhile.", "Run this preflight again.")
    if after.phase != DropPhase.WAITING:
        return Missing(
            "The recording that runs holds a drop already, and closes by itself.",
            "tfsat-host record stop, then run this preflight again.",
        )
    return Running(
        after.session,
        (after.uptime_ms - before.uptime_ms) / 1000,
        after.blocks_written - before.blocks_written,
        after.samples_dropped,
        after.ring_peak_blocks,
        RING_BLOCKS,
        min(SAMPLES_PER_BLOCK / settings.rate_hz, PARTIAL_BLOCK_MS / 1000),
    )
