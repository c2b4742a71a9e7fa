"""What the logger says of itself, as JSON and as lines for people."""

from __future__ import annotations

import time
from datetime import datetime
from typing import TYPE_CHECKING, Any

from tfsat_host.devices.logger import drop_in_danger, file_was_full, recording_in_danger, state_words
from tfsat_host.json_values import error_as_dict
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.sequencer_state import Rows, switch_words, switches_closed
from tfsat_host.protocol.enums import CardState, DropPhase, LoggerState, Origin
from tfsat_host.protocol.imus import IMU_PARTS
from tfsat_host.quantity import Column, Columns, fields, record
from tfsat_host.units import US_PER_S

if TYPE_CHECKING:
    from tfsat_host.devices.logger import LoggerClient
    from tfsat_host.protocol.messages import LoggerStatusReply


_PHASES = {
    DropPhase.WAITING: "not released",
    DropPhase.FALLING: "RELEASED",
    DropPhase.LANDED: "landed",
}
RAM_HOLDS_DROP = Advice(
    "HOLDS A DROP THAT NO CARD HAS: keep the power on, and: ", NextStep("log fetch", ("ram",))
)


def _present(status: LoggerStatusReply) -> list[bool]:
    return [bool(status.imu_present >> bit & 1) for bit in range(len(status.who_am_i))]


def logger_state(board: LoggerClient) -> tuple[dict[str, Any], Rows]:
    """State, card, sensors, switches, the recording, the clock. Raises what its requests raise."""
    status = board.status()
    # A clock that was never set reads 0: that is no error of decades.
    clock_error_s = status.unix_us / US_PER_S - time.time() if status.unix_us else None
    refusal = recording_in_danger(status)
    state = {
        **record(_STATE, status),
        "arm_refusal": None if refusal is None else error_as_dict(refusal),
        "unix_s": status.unix_us / US_PER_S if status.unix_us else None,
        "clock_error_s": clock_error_s,
    }
    return state, _rows(status, clock_error_s)


def _rows(status: LoggerStatusReply, clock_error_s: float | None) -> Rows:
    settings = "factory" if status.settings_origin == Origin.FACTORY else "changed"
    rows = [
        ("  state", state_words(status)),
        *(("  ATTENTION", text) for text in attention(status)),
        ("  card", card_words(status)),
        ("  IMUs", _imu_words(status)),
        ("  switches", switch_words(status.switches_open)),
        ("  sampling", f"{status.rate_hz} Hz, {settings} settings, {status.late_ticks} ticks late"),
        ("  recording", _recording_words(status)),
        ("  clock", _clock_words(status.unix_us, clock_error_s)),
    ]
    if status.ram_holds_drop:
        # Right below the state: with the power this drop is lost.
        rows.insert(1, ("  RAM", RAM_HOLDS_DROP))
    return rows


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


def _clock_words(unix_us: int, error_s: float | None) -> str:
    if error_s is None:
        return "not set; record start sets it"
    return f"{clock_words(unix_us)} ({error_s:+.1f} s from this computer's)"


LOGGER: Columns = (
    *fields("state error card phase samples samples_dropped rate_hz"),
    Column("file_full", of=file_was_full),
    Column("attention", of=attention),
    Column("ram_holds_drop", of=lambda status: bool(status.ram_holds_drop)),
    Column("switches_closed", of=lambda status: switches_closed(status.switches_open)),
    Column("session", of=lambda status: f"{status.session:08x}"),
)
"""Of a status, for JSON."""
_STATE: Columns = (
    *LOGGER,
    *fields("card_free_mib who_am_i blocks_written ring_blocks ring_peak_blocks late_ticks settings_origin"),
    Column("imu_present", of=_present),
    Column("uptime_s", of="uptime_ms"),
)
