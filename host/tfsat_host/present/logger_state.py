"""What the logger reports of itself: its columns for JSON and for people."""

from __future__ import annotations

import time
from dataclasses import dataclass
from datetime import datetime

from tfsat_host.devices.board_identity import DEVICE, Device
from tfsat_host.devices.logger import (
    LoggerClient,
    NotOnCard,
    drop_in_danger,
    file_was_full,
    recording_in_danger,
    state_words,
)
from tfsat_host.error_columns import error_columns
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.sequencer_state import switch_words, switches_closed
from tfsat_host.protocol.enums import CardState, DropPhase, LoggerState, Origin
from tfsat_host.protocol.imus import IMU_PARTS
from tfsat_host.protocol.messages import LoggerStatusReply
from tfsat_host.quantity import Column, Columns, fields
from tfsat_host.units import US_PER_S

_PHASES = {
    DropPhase.WAITING: "not released",
    DropPhase.FALLING: "RELEASED",
    DropPhase.LANDED: "landed",
}
RAM_HOLDS_DROP = Advice(
    "HOLDS A DROP THAT NO CARD HAS: keep the power on, and: ", NextStep("log fetch", ("ram",))
)


@dataclass(frozen=True, slots=True)
class LoggerReport:
    """All that the logger says of itself at one time.

    Attributes:
        device: Port and identity.
        status: Its state.
        clock_error_s: Its time of day less the computer's; None: it was never set.
        refusal: Why a drop now would not be on the card; None: it would be, or nothing was started.
    """

    device: Device
    status: LoggerStatusReply
    clock_error_s: float | None
    refusal: NotOnCard | None

    @classmethod
    def ask(cls, board: LoggerClient) -> LoggerReport:
        """Ask for everything. Raises what the requests raise."""
        status = board.status()
        # A clock that was never set reads 0: that is no error of decades.
        clock_error_s = status.unix_us / US_PER_S - time.time() if status.unix_us else None
        return cls(board.device(), status, clock_error_s, recording_in_danger(status))


def attention(status: LoggerStatusReply) -> list[str]:
    """Return the urgent warnings about a recording and its card, one text each.

    RAM_HOLDS_DROP is another.
    """
    # What was dropped comes before what might be recorded next.
    drop = drop_in_danger(status)
    if drop is not None:
        return [Advice(f"{drop.meaning} ", drop.next_step)]
    refusal = None if status.ram_holds_drop else recording_in_danger(status)
    return [] if refusal is None else [" ".join((refusal.what, refusal.meaning))]


def card_words(status: LoggerStatusReply) -> str:
    """Describe the card, in capitals if it allows no recording."""
    if status.card == CardState.READY:
        return f"ready, {status.card_free_mib} MiB free"
    name = status.card.name.replace("_", " ")
    if status.card == CardState.UNKNOWN:
        return "not looked at yet, or its free room is being counted"
    return f"{name}, {status.card_free_mib} MiB free" if status.card == CardState.FULL else name


def idle_part(status: LoggerStatusReply, index: int) -> str | None:
    """Name of the part at an IMU's place that answers and does not measure; None of any other."""
    part = IMU_PARTS.get(status.who_am_i[index])
    return None if part is None or status.imu_present >> index & 1 else part.name


def _imu_words(status: LoggerStatusReply) -> str:
    words = []
    for body, who_am_i in enumerate(status.who_am_i, 1):
        # Bit by body: the logger has found the part and measures with it.
        if status.imu_present >> (body - 1) & 1:
            words.append(f"{body} {IMU_PARTS[who_am_i].name}" if who_am_i in IMU_PARTS else f"{body} ok")
        elif who_am_i and who_am_i not in IMU_PARTS:
            # Something answers at this address, with an identity that is none of the known parts'.
            words.append(f"{body} FOREIGN (WHO_AM_I 0x{who_am_i:02x}: no part that the logger knows)")
        elif part := idle_part(status, body - 1):
            words.append(f"{body} NOT MEASURING ({part})")
        else:
            words.append(f"{body} MISSING")
    return ", ".join(words)


def _recording_words(status: LoggerStatusReply) -> str:
    if not status.session:
        return "none since the start"
    closes = status.state == LoggerState.RECORDING and status.phase == DropPhase.LANDED
    return (
        f"session {status.session:08x}, {status.samples} samples, {status.samples_dropped} dropped, "
        f"{_PHASES[status.phase]}{': it closes automatically' if closes else ''}"
    )


def clock_words(unix_us: int) -> str:
    """Format a time of day in this computer's time zone; a dash if it was never set."""
    if not unix_us:
        return "–"
    return f"{datetime.fromtimestamp(unix_us // US_PER_S).astimezone():%Y-%m-%d %H:%M:%S}"


def _clock_words(report: LoggerReport) -> str:
    if report.clock_error_s is None:
        return "not set; record start sets it"
    return f"{clock_words(report.status.unix_us)} ({report.clock_error_s:+.1f} s from this computer's)"


def _sampling_words(report: LoggerReport) -> str:
    status = report.status
    settings = "factory" if status.settings_origin == Origin.FACTORY else "changed"
    return f"{status.rate_hz} Hz, {settings} settings, {status.late_ticks} ticks late"


LOGGER: Columns = (
    *fields(
        "state=status.state error=status.error card=status.card phase=status.phase samples=status.samples "
        "samples_dropped=status.samples_dropped rate_hz=status.rate_hz"
    ),
    Column("file_full", of=lambda board: file_was_full(board.status)),
    Column("attention", of=lambda board: attention(board.status)),
    Column("ram_holds_drop", of=lambda board: bool(board.status.ram_holds_drop)),
    Column("switches_closed", of=lambda board: switches_closed(board.status.switches_open)),
    Column("session", of=lambda board: f"{board.status.session:08x}"),
    Column(
        "maneuver_crc",
        of=lambda board: f"{board.status.maneuver_crc:04x}" if board.status.maneuver_known else None,
    ),
)
"""For JSON, of whatever has a logger's `status`."""
LOGGER_JSON: Columns = (
    *LOGGER,
    *fields(
        "clock_error_s card_free_mib=status.card_free_mib "
        "blocks_written=status.blocks_written ring_blocks=status.ring_blocks "
        "ring_peak_blocks=status.ring_peak_blocks late_ticks=status.late_ticks "
        "settings_origin=status.settings_origin uptime_s=status.uptime_ms"
    ),
    Column("device", columns=DEVICE),
    Column("who_am_i", of=lambda report: list(report.status.who_am_i)),
    Column("arm_refusal", of="refusal", columns=error_columns),
    Column("unix_s", of=lambda report: report.status.unix_us / US_PER_S if report.status.unix_us else None),
    Column(
        "imu_present",
        of=lambda report: [
            bool(report.status.imu_present >> bit & 1) for bit in range(len(report.status.who_am_i))
        ],
    ),
)
"""A whole report for JSON."""
LOGGER_FACTS: Columns = (
    Column(
        "",
        "Logger",
        words=lambda report: (
            f"{state_words(report.status)}, release switches: {switch_words(report.status.switches_open)}"
        ),
    ),
    Column("", "Card", words=lambda report: card_words(report.status)),
    Column("", "IMUs", words=lambda report: _imu_words(report.status)),
    Column("", "Recording", words=lambda report: _recording_words(report.status)),
    Column("", "Clock", words=_clock_words),
)
"""What a person reads first."""
LOGGER_DETAILS: Columns = (
    Column("", "Logger port", words=lambda report: report.device.describe()),
    Column("", "Sampling", words=_sampling_words),
)
"""The rest."""
