"""What a preflight asks of the logger; what is switched on is switched off again.

With a short recording of its own: made, read back block by block, judged, and removed.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeVar

import numpy as np

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.devices.board_errors import BoardError
from tfsat_host.devices.log_transfer import RAM
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.serial_ports import PortError
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.preflight.checks.calibration import landed_unnoted
from tfsat_host.preflight.preflight_evidence import (
    Clock,
    Failed,
    LiveSamples,
    LoggerAnswers,
    Missing,
    Moment,
    RunningRecording,
    Trial,
)
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import CardState, DropPhase, LoggerState
from tfsat_host.protocol.limits import PARTIAL_BLOCK_MS, RING_BLOCKS, SAMPLES_PER_BLOCK
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.sdlog import DropLog, LogError, load
from tfsat_host.units import US_PER_S

WATCH_S = 6.0
"""Of live samples, and of the recording: a pace to 0.1 %, twenty syncs of the card, a mean of 1700 samples."""
STEP_S = 0.25

UNREADABLE = "unreadable"
"""A verdict next to the decoder's."""

Advance = Callable[[float], None]
Read = TypeVar("Read")


@dataclass
class Trace:
    """What of a recording could not be removed again: a sentence, empty if nothing."""

    left: str = ""


def ask_logger(
    logger: LoggerClient,
    unix_s: Clock,
    calibration: Calibration | Missing,
    trace: Trace,
    advance: Advance = lambda _seconds: None,
) -> LoggerAnswers:
    """Asks for everything; takes `WATCH_S` and what a recording takes to be opened, closed and read back.

    `calibration` is the certificate, with its landings. `trace` gets what of the recording could not be
    removed again, even when this is interrupted. `advance` is called with how many seconds of `WATCH_S` went
    by.

    Raises:
        BoardError, NoAnswer, PortError: of the requests; the recording was removed, or `trace` says that not.
    """
    first = Moment.of(logger.status, logger.now_s)
    # Half a round trip back: the status is of some moment between request and answer.
    computer_unix_s = unix_s() - (first.had_s - first.asked_s) / 2
    status, settings = first.status, logger.settings().settings
    since = _recording_since(logger, status)
    card: Trial | RunningRecording | Missing
    # A recording that runs already is watched and never ended.
    if status.state == LoggerState.RECORDING:
        live = _live(logger, advance)
        card = _running_logger(status, logger.status(), settings)
    elif reason := _no_trial(status, landed_unnoted(status, since, computer_unix_s, calibration)):
        card, live = reason, _live(logger, advance)
    else:
        card, live = trial_recording(logger, status, trace, lambda: _live(logger, advance))
    # After the trial: late ticks and clock pace then cover the whole preflight.
    last = Moment.of(logger.status, logger.now_s)
    return LoggerAnswers(first, last, computer_unix_s, settings, live, card, since, trace.left)


def _no_trial(status: msg.LoggerStatusReply, unnoted_landing: bool) -> Missing | None:
    """Why no recording may be made now; None: one may."""
    if status.ram_holds_drop:
        return Missing(
            "No recording was made: it would cost the drop in RAM.", Advice(NextStep("log fetch", ("ram",)))
        )
    if status.state == LoggerState.FAILED:
        return Missing(
            "No recording was made: the last one failed, and RAM still has its newest seconds.",
            Advice(NextStep("log fetch", ("ram",)), " if they matter; then switch the logger off and on."),
        )
    if status.state == LoggerState.STOPPING:
        return Missing("The logger still closes its last recording.", "Wait, then run this preflight again.")
    # The logger remembers the landing of its last recording only.
    if unnoted_landing:
        return Missing(
            "No recording was made: the logger would forget the landing of its last one, which is not in the "
            "certificate yet.",
            Advice(
                NextStep("log fetch", ("all",)),
                ", then next to the certificate ",
                NextStep("decode", ("FILE",)),
                " with the fetched recording.",
            ),
        )
    if status.card != CardState.READY:
        return Missing("No recording was made: the card takes none.", "See card and card-room.")
    return None


def _recording_since(logger: LoggerClient, status: msg.LoggerStatusReply) -> datetime | None:
    """Find when the last recording began, by the card's list.

    Returns None if it is still running, or if the logger's clock was not set.
    """
    if not status.session or status.state in (LoggerState.RECORDING, LoggerState.STOPPING):
        return None
    try:
        entries = logger.logs()
    except BoardError:
        # No list, no date: the caller then assumes any time since the power came on.
        return None
    began_us = [
        entry.wall_clock_us for entry in entries if entry.session == status.session and entry.wall_clock_us
    ]
    try:
        return datetime.fromtimestamp(began_us[0] / US_PER_S, UTC) if began_us else None
    except (OverflowError, ValueError, OSError):
        return None  # a time beyond all calendars


def _live(logger: LoggerClient, advance: Advance) -> LiveSamples | Missing:
    """`WATCH_S` of live samples; Missing: none came. Raises PortError."""
    samples: list[LiveSample] = []
    with logger.live() as reply:
        for _ in range(round(WATCH_S / STEP_S)):
            samples += logger.samples_of(STEP_S)
            advance(STEP_S)
    if not samples:
        return Missing(
            f"The logger sent no live sample in {WATCH_S:g} s.",
            Advice(NextStep("status"), "; switch the logger off and on, then run this preflight again."),
        )
    return LiveSamples(
        Counts.from_live(samples, reply), np.array([sample.index for sample in samples], dtype=np.int64)
    )


def _running_logger(
    before: msg.LoggerStatusReply, after: msg.LoggerStatusReply, settings: msg.LoggerSettings
) -> RunningRecording | Missing:
    if after.state != LoggerState.RECORDING or after.session != before.session:
        return Missing("The recording that ran ended meanwhile.", "Run this preflight again.")
    if after.phase != DropPhase.WAITING:
        return Missing(
            "The recording that runs holds a drop already, and closes automatically.",
            Advice(NextStep("record stop"), ", then run this preflight again."),
        )
    return RunningRecording(
        after.session,
        (after.uptime_ms - before.uptime_ms) / 1000,
        after.blocks_written - before.blocks_written,
        after.samples_dropped,
        after.ring_peak_blocks,
        RING_BLOCKS,
        min(SAMPLES_PER_BLOCK / settings.rate_hz, PARTIAL_BLOCK_MS / 1000),
    )


def trial_recording(
    logger: LoggerClient,
    before: msg.LoggerStatusReply,
    trace: Trace,
    meanwhile: Callable[[], LiveSamples | Missing],
) -> tuple[Trial | Missing, LiveSamples | Missing]:
    """Record while `meanwhile` runs and judge what the card kept of it; see `record_and_remove`."""
    live: LiveSamples | Missing | None = None

    def watch() -> None:
        nonlocal live
        live = meanwhile()

    trial: Trial | Missing
    try:
        trial = record_and_remove(logger, before, trace, watch, judge_trial)
    except PortError:
        raise
    except TfsatError as error:
        trial = Failed(f"A recording failed. {error.what} {error.meaning}".strip(), error.next_step)
    # The recording failed before any live samples: take them now, as other checks need them.
    return trial, meanwhile() if live is None else live


def record_and_remove(
    logger: LoggerClient,
    before: msg.LoggerStatusReply,
    trace: Trace,
    meanwhile: Callable[[], object],
    read: Callable[[LoggerClient, msg.RecordStopReply], Read],
) -> Read:
    """Records while `meanwhile` runs, reads the recording back, and removes it whatever happens.

    The logger, of status `before`, neither records nor is in use. Its clock is left as it is, and its next
    recording gets the number that it would have got. What `read` makes of the logger and the recording's end
    is returned; `trace` gets what is left.

    Raises:
        NoAnswer, PortError: the link broke; then also the recording may be left.
        TfsatError: the card refused, or what `meanwhile` and `read` raise.
    """
    try:
        logger.start_recording()
        # Fails where the card takes no block at all, before seconds of samples are waited for.
        logger.wait_for_card()
        meanwhile()
        return read(logger, logger.stop_recording())
    finally:
        # Assume the worst first: this stays if the removal itself raises.
        trace.left = "A recording made for this is still on the logger: the link broke before it was removed."
        trace.left = _remove(logger, before.session)


def judge_trial(logger: LoggerClient, stopped: msg.RecordStopReply) -> Trial:
    """Fetch the trial recording from the card and assess how much of it was written.

    Raises TfsatError: it is not there, or cannot be fetched.
    """
    entry = _require_entry(logger, stopped.session)
    try:
        log = _load(logger, entry)
    except LogError:
        # Nothing can be decoded: every sample and every block counts as lost.
        return Trial(
            UNREADABLE, stopped.samples, stopped.samples_dropped, stopped.samples, entry.blocks, ring_blocks=1
        )
    trial = Trial(
        log.verdict,
        stopped.samples,
        stopped.samples_dropped,
        log.samples_lost,
        log.blocks_lost,
        log.duration_s,
    )
    # Stalls and the ring's peak stand in the footer only.
    if (footer := log.footer) is None:
        return trial
    return replace(
        trial,
        stall_max_ms=footer.card_stall_max_ms,
        ring_peak_blocks=footer.ring_peak_blocks,
        ring_blocks=footer.ring_blocks,
    )


def fetch_recording(logger: LoggerClient, stopped: msg.RecordStopReply) -> DropLog:
    """Fetch a closed recording and decode it. Raises TfsatError: it is not there, or LogError."""
    return _load(logger, _require_entry(logger, stopped.session))


def _load(logger: LoggerClient, entry: msg.LogEntry) -> DropLog:
    # Read back from the card: a counterfeit one acknowledges blocks that it does not keep.
    image = logger.fetch_whole(entry)
    with tempfile.TemporaryDirectory(prefix="tfsat-recording-") as folder:
        file = Path(folder) / "trial.bin"
        file.write_bytes(image)
        return load(file)


def _remove(logger: LoggerClient, session_before: int) -> str:
    """Ends and erases whatever recording is younger than `session_before`; what is left, or empty.

    Raises NoAnswer, PortError.
    """
    try:
        status = logger.status()
        if status.session == session_before:
            return ""  # it never began
        if status.state == LoggerState.FAILED:
            # The card has failed and RAM goes on: end that without waiting for the card.
            logger.end_capture()
        elif status.state in (LoggerState.RECORDING, LoggerState.STOPPING):
            logger.stop_recording()
        entry = _entry_of(logger, status.session)
        if entry is not None:
            logger.erase_log(entry)
        if status.state == LoggerState.FAILED:
            return "The logger's state is failed since the recording of this preflight: switch it off and on."
    except PortError:
        raise
    except TfsatError as error:
        return f"The recording of this preflight is still on the card: {error.what}"
    return ""


def _require_entry(logger: LoggerClient, session: int) -> msg.LogEntry:
    entry = _entry_of(logger, session)
    if entry is None:
        raise TfsatError(
            what="The card's list does not name the recording that was just closed.",
            meaning="The card forgets what it was given.",
            next_step="Put in another card.",
        )
    return entry


def _entry_of(logger: LoggerClient, session: int) -> msg.LogEntry | None:
    return next((entry for entry in logger.logs() if entry.session == session and entry.number != RAM), None)
