"""A decoded recording on a terminal: verdict, timing, sensors, events, files."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from tfsat_host.notices import utc
from tfsat_host.present.output import Output
from tfsat_host.protocol.enums import ErrorCode, StopReason
from tfsat_host.protocol.remedies import REMEDIES

Facts = Mapping[str, Any]
_STOPPED = {
    StopReason.HOST: "by a stop over the cable",
    StopReason.LANDING: "automatically, after the landing",
    StopReason.FILE_FULL: "because its file was full",
    StopReason.CARD_GONE: "because the card was gone",
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
    "rewritten": "the seconds around the fall were written a second time: {value} blocks",
    "sampling_late": "{value} µs without a sample",
}
_FILLS = {1: "more than a quarter", 2: "more than half", 3: "more than 3 quarters"}
"""By whole quarters of the ring."""


def show_recording(facts: Facts, out: Output) -> None:
    """Show the facts from `sdlog.summary.summary`, and the files written, under `files`."""
    for label, text in _rows(facts):
        out.line(f"{label:<11}{text}")
    out.line()
    columns = ("sensor", "valid", "invalid", "clipped")
    out.table(columns, [[row[name] for name in columns] for row in facts["sensors"]])
    if (clipping := facts["clipping"]) is not None:
        when = f"Clipped     {clipping['first_s']:.3f} to {clipping['last_s']:.3f} s"
        if clipping["in_fall"]:
            out.line(f"{when}: {clipping['in_fall']} samples of them IN THE FALL; they are lower bounds.")
        else:
            out.line(f"{when}: none within {clipping['fall_s']:g} s after the release.")
        out.line()
    if facts["release_us"] is None:
        out.line("No release was recorded: times count from the first sample.")
    else:
        doubtful = "" if facts["t_s_origin"] == "release" else ", which is doubtful"
        out.line(f"Times count from the release{doubtful}.")
    events = facts["events"]
    if events:
        rows = [(f"{event['t_s']:.6f}", event_words(event)) for event in events[:_EVENTS_SHOWN]]
        out.table(("t / s", "event"), rows)
    if len(events) > _EVENTS_SHOWN:
        out.line(f"… and {len(events) - _EVENTS_SHOWN} more events (all of them with --json).")
    for path in facts.get("files", {}).values():
        out.line(f"Written    {path}")


def _rows(facts: Facts) -> Iterator[tuple[str, str]]:
    """Yield pairs of label and text; the last ones are the logger's own account of the recording."""
    header, footer = facts["header"], facts["footer"]
    yield "Recording", facts["session"]
    yield "Verdict", _verdict_words(facts)
    if facts["unix_offset_us"] is not None:
        yield "Started", utc(header["wall_clock_us"])
    rate = "unknown" if facts["rate_hz"] is None else f"{facts['rate_hz']:.2f} Hz"
    samples = f"{facts['samples']} in {facts['duration_s']:.3f} s"
    yield "Samples", f"{samples}, {rate} ({header['rate_hz']:g} Hz commanded)"
    if footer is not None:
        yield (
            "Timing",
            f"jitter {footer['jitter_rms_us']:.1f} µs rms, steps of {footer['interval_min_us'] / 1e3:.3f} to "
            f"{footer['interval_max_us'] / 1e3:.3f} ms, {footer['late_ticks']} late ticks",
        )
        yield (
            "Card",
            f"longest stall {footer['card_stall_max_ms']} ms, at most {footer['ring_peak_blocks']} of "
            f"{footer['ring_blocks']} blocks waited, {footer['blocks_rewritten']} written a second time",
        )
        yield "Ended", _STOPPED[StopReason(footer["stop_reason"])]
    aside = [
        f"{count} {_ASIDE.get(name, name.replace('_', ' '))}"
        for name, count in facts["set_aside"].items()
        if count
    ]
    if aside:
        yield "Set aside", f"{', '.join(aside)} (blocks)"


def _verdict_words(facts: Facts) -> str:
    """Describe the verdict and the extent of the recording."""
    if facts["verdict"] == "complete":
        return "complete: nothing is missing"
    if facts["verdict"] == "damaged":
        return "damaged: something inside is missing or contradictory; every value that is given is right"
    # A recording may lack its beginning, its end (which its footer marks), or both.
    starts_late = any(gap["late_start"] for gap in facts["gaps"])
    missing = [word for word, is_so in (("before", starts_late), ("after", facts["footer"] is None)) if is_so]
    return (
        f"truncated: complete from {facts['first_s']:.1f} s to {facts['last_s']:.1f} s; "
        f"what came {' and '.join(missing)} is not in the file"
    )


def event_words(event: Facts) -> str:
    """Describe an event of a recording's metadata; the bare name if this release does not know it."""
    name, arg, value = str(event["name"]), event["arg"], event["value"]
    if name == "release":
        return "RELEASE" if arg else "both switches closed again: that release was none"
    if name == "landing":
        return f"LANDING, a shock of {value / 1000:.1f} g" if arg else "landed, by the time since the release"
    # A code that this release does not know, of newer firmware, is shown by its number.
    cause = REMEDIES[ErrorCode(arg)][0].rstrip(".") if arg in set(ErrorCode) else f"error {arg}"
    if arg == ErrorCode.SENSOR_FOREIGN and value:
        cause += f" (WHO_AM_I 0x{value:02x})"
    number, state = event["index"] + 1, "opened" if arg else "closed"
    text = _EVENTS.get(name, name)
    # Each text takes the fields that it names.
    return text.format(number=number, state=state, fill=_FILLS.get(arg, "all"), value=value, cause=cause)
