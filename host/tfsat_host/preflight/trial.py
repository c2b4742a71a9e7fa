"""A short recording for its own sake: made, read back block by block, judged, and removed again."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tfsat_host.devices.log_transfer import RAM
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.ports import PortError
from tfsat_host.errors import TfsatError
from tfsat_host.preflight.evidence import Failed, LiveSamples, Missing, Trial
from tfsat_host.protocol.enums import LoggerState
from tfsat_host.protocol.limits import BLOCK_BYTES, RING_BLOCKS
from tfsat_host.protocol.messages import LogEntry, LoggerStatusReply, RecordStopReply
from tfsat_host.sdlog import LogError, load

UNREADABLE = "unreadable"
"""A verdict beside the decoder's."""


@dataclass
class Trace:
    """What of a recording could not be removed again: a sentence, empty if nothing."""

    left: str = ""


def trial_recording(
    logger: LoggerClient,
    before: LoggerStatusReply,
    trace: Trace,
    meanwhile: Callable[[], LiveSamples | Missing],
) -> tuple[Trial | Missing, LiveSamples | Missing]:
    """Records while `meanwhile` runs, reads the recording back, and removes it whatever happens.

    The logger's clock is left as it is, and its next recording gets the number that it would have got.

    Args:
        logger: Neither recording nor in use.
        before: Its status.
        trace: Gets what is left.
        meanwhile: What takes the recording's time.

    Raises:
        NoAnswer, PortError: the link broke; then also the recording may be left.
    """
    live: LiveSamples | Missing | None = None
    trial: Trial | Missing
    try:
        try:
            logger.start_recording()
            logger.wait_for_card()
            live = meanwhile()
            trial = _judged(logger, logger.stop_recording())
        except PortError:
            raise
        except TfsatError as error:
            trial = Failed(f"A recording failed. {error.what} {error.meaning}".strip(), error.next_step)
    finally:
        trace.left = (
            "A recording of this preflight is still on the logger: the link broke before it was removed."
        )
        trace.left = _remove(logger, before.session)
    return trial, meanwhile() if live is None else live


def _judged(logger: LoggerClient, stopped: RecordStopReply) -> Trial:
    """What of the recording is on the card. Raises TfsatError: it is not there, or cannot be fetched."""
    entry = _entry_of(logger, stopped.session)
    if entry is None:
        raise TfsatError(
            what="The card's list does not name the recording that was just closed.",
            meaning="The card forgets what it was given.",
            next_step="Put in another card.",
        )
    image = bytearray(entry.blocks * BLOCK_BYTES)

    def put(index: int, block: bytes) -> None:
        image[index * BLOCK_BYTES : (index + 1) * BLOCK_BYTES] = block

    logger.fetch_blocks(entry, [(0, entry.blocks)], put)
    with tempfile.TemporaryDirectory(prefix="tfsat-preflight-") as folder:
        file = Path(folder) / "trial.bin"
        file.write_bytes(image)
        try:
            log = load(file)
        except LogError:
            return Trial(
                UNREADABLE,
                stopped.samples,
                stopped.samples_dropped,
                stopped.samples,
                entry.blocks,
                0.0,
                0,
                0,
                1,
            )
    footer = log.footer
    return Trial(
        log.verdict,
        stopped.samples,
        stopped.samples_dropped,
        log.samples_lost,
        log.blocks_lost,
        log.duration_s,
        0 if footer is None else footer.card_stall_max_ms,
        0 if footer is None else footer.ring_peak_blocks,
        RING_BLOCKS if footer is None else footer.ring_blocks,
    )


def _remove(logger: LoggerClient, session_before: int) -> str:
    """Ends and erases whatever recording is younger than `session_before`; what is left, or empty.

    Raises NoAnswer, PortError.
    """
    try:
        status = logger.status()
        if status.session == session_before:
            return ""  # it never began
        if status.state == LoggerState.FAILED:
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


def _entry_of(logger: LoggerClient, session: int) -> LogEntry | None:
    return next((one for one in logger.logs() if one.session == session and one.number != RAM), None)
