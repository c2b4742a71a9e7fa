"""A decoded recording on a terminal: verdict, timing, sensors, events, files."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

from tfsat_host.notices import utc
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_facts, show_rows
from tfsat_host.protocol.enums import ErrorCode, StopReason
from tfsat_host.protocol.remedies import REMEDIES
from tfsat_host.quantity import Column, Columns
from tfsat_host.sdlog import DropEvent, DropLog
from tfsat_host.sdlog.log_summary import SENSORS, count_clipped, count_sensors

_STOPPED = {
    StopReason.HOST: "stopped via USB",
    StopReason.LANDING: "stopped automatically after the landing",
    StopReason.FILE_FULL: "file full",
    StopReason.CARD_GONE: "card lost",
}
_EVENTS_SHOWN = 40
_ASIDE = {"stale": "of other recordings"}
_EVENTS = {
    "switch_edge": "release switch {number} {state}",
    "stroke": "stroke {number}",
    "sensor_fault": "IMU of body {number}: {cause}",
    "sensor_missed": "IMU of body {number} missed a reading: {cause}",
    "sensor_recovered": "IMU of body {number} measures again",
    "card_stall": "the card took nothing for {value} ms",
    "samples_dropped": "{value} samples dropped: the ring was full",
    "ring_high_water": "{value} blocks wait for the card: {fill} of the ring",
    "card_lost": "the card was lost: {cause}",
    "card_back": "the card takes blocks again, after {value} ms",
    "rewritten": "the seconds around the fall were rewritten: {value} blocks",
    "sampling_late": "{value} µs without a sample",
}
_FILLS = {1: "more than a quarter", 2: "more than half", 3: "more than 3 quarters"}
"""By whole quarters of the ring."""


def _verdict_words(log: DropLog) -> str:
    """Describe the verdict and the extent of the recording."""
    if log.verdict == "complete":
        return "complete: no samples lost"
    if log.verdict == "damaged":
        return "damaged: parts missing or contradictory, decoded values valid"
    # A recording may lack its beginning, its end (which its footer marks), or both.
    missing = [
        word
        for word, is_missing in (("start", log.late_start is not None), ("end", log.footer is None))
        if is_missing
    ]
    first_s, last_s = (log.seconds(int(t_us)) for t_us in log.t_us[[0, -1]])
    return (
        f"truncated: complete from {first_s:.1f} to {last_s:.1f} s; {' and '.join(missing)} not in the file"
    )


def _sampling(log: DropLog) -> str:
    rate = f"{log.rate_hz:.2f} Hz" if log.duration_s > 0 else "rate unknown"
    return f"{len(log)} in {log.duration_s:.3f} s, {rate} (commanded: {log.header.rate_hz:g} Hz)"


def _timing(log: DropLog) -> str:
    if (footer := log.footer) is None:
        return ""
    return (
        f"jitter {footer.jitter_rms_us:.1f} µs rms, steps {footer.interval_min_us / 1e3:.3f} to "
        f"{footer.interval_max_us / 1e3:.3f} ms, {footer.late_ticks} late ticks"
    )


def _card(log: DropLog) -> str:
    if (footer := log.footer) is None:
        return ""
    return (
        f"longest stall {footer.card_stall_max_ms} ms, max. {footer.ring_peak_blocks} of {footer.ring_blocks} "
        f"blocks buffered, {footer.blocks_rewritten} rewritten"
    )


def _ignored_blocks(log: DropLog) -> str:
    counts = asdict(log.set_aside).items()
    return ", ".join(f"{count} {_ASIDE.get(name, name.replace('_', ' '))}" for name, count in counts if count)


def _clipping(log: DropLog) -> str:
    clipping = count_clipped(log)
    if clipping is None:
        return ""
    when = f"{clipping.first_s:.3f} to {clipping.last_s:.3f} s"
    if clipping.in_fall:
        return f"{when}: {clipping.in_fall} samples IN THE FALL (lower bounds)"
    return f"{when}: none within {clipping.fall_s:g} s after the release"


def _time_zero(log: DropLog) -> str:
    return {"release": "release", "first sample": "first sample (no release recorded)"}.get(
        log.t_s_origin, "release, doubtful"
    )


_VERDICT = Column("verdict", "Verdict", words=_verdict_words)
_FACTS: Columns = (
    _VERDICT,
    Column("session", "Recording", of=lambda log: f"{log.session:08x}"),
    Column(
        "", "Started", words=lambda log: "" if log.unix_offset_us is None else utc(log.header.wall_clock_us)
    ),
    Column(
        "",
        "Maneuver",
        words=lambda log: "" if log.maneuver_crc is None else f"CRC {log.maneuver_crc:04x} on the sequencer",
    ),
    Column("", "Samples", words=_sampling),
    Column("", "Timing", words=_timing),
    Column("", "Card", words=_card),
    Column(
        "", "Ended", words=lambda log: (log.footer and _STOPPED[StopReason(log.footer.stop_reason)]) or ""
    ),
    Column("", "Ignored blocks", words=_ignored_blocks),
    Column("", "Clipped", words=_clipping),
    Column("", "t = 0", words=_time_zero),
)


def show_recording(log: DropLog, files: Iterable[Path], out: Output) -> None:
    """Show what was recorded and what is missing from it, and the files written."""
    show_facts(_FACTS, log, out)
    out.line()
    show_rows(SENSORS, count_sensors(log), out)
    events = log.events
    if events:
        rows = [(f"{log.seconds(event.t_us):.6f}", event_words(event)) for event in events[:_EVENTS_SHOWN]]
        out.table(("t / s", "event"), rows)
    if len(events) > _EVENTS_SHOWN:
        out.line(f"… and {len(events) - _EVENTS_SHOWN} more events (all of them with --json).")
    for path in files:
        out.line(f"Written: {path}")
    # The last line on the screen is the one that is read.
    show_facts((_VERDICT,), log, out)


def event_words(event: DropEvent) -> str:
    """Describe an event of a recording; the bare name if this release does not know it."""
    arg, value = event.arg, event.value
    if event.name == "release":
        return "RELEASE" if arg else "false release revoked: both switches closed again"
    if event.name == "landing":
        return f"LANDING, shock {value / 1000:.1f} g" if arg else "LANDING, by the time since the release"
    # A code that this release does not know, of newer firmware, is shown by its number.
    cause = REMEDIES[ErrorCode(arg)][0].rstrip(".") if arg in set(ErrorCode) else f"error {arg}"
    if arg == ErrorCode.SENSOR_FOREIGN and value:
        cause += f" (WHO_AM_I 0x{value:02x})"
    text = _EVENTS.get(event.name, event.name)
    # Each text takes the fields that it names.
    return text.format(
        number=event.index + 1,
        state="opened" if arg else "closed",
        fill=_FILLS.get(arg, "all"),
        value=value,
        cause=cause,
    )
