"""What `decode` shows of a recording, from the decoded facts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from tfsat_host.cli.event_words import event_words
from tfsat_host.notices import utc
from tfsat_host.present.output import Output
from tfsat_host.protocol.enums import StopReason

Facts = Mapping[str, Any]
_STOPPED = {
    StopReason.HOST: "by a stop over the cable",
    StopReason.LANDING: "by itself, after the landing",
    StopReason.FILE_FULL: "because its file was full",
    StopReason.CARD_GONE: "because the card was gone",
}
_EVENTS_SHOWN = 40
_ASIDE = {"stale": "of other recordings"}


def show(facts: Facts, out: Output) -> None:
    """The recording in numbers: verdict, timing, sensors, events, files."""
    out.line(f"Recording  {facts['session']}")
    out.line(f"Verdict    {_verdict_words(facts)}")
    if facts["unix_offset_us"] is not None:
        out.line(f"Started    {utc(facts['header']['wall_clock_us'])}")
    rate = "unknown" if facts["rate_hz"] is None else f"{facts['rate_hz']:.2f} Hz"
    commanded = f"{facts['header']['rate_hz']:g} Hz commanded"
    out.line(f"Samples    {facts['samples']} in {facts['duration_s']:.3f} s, {rate} ({commanded})")
    for label, text in _footer_rows(facts["footer"]):
        out.line(f"{label:<11}{text}")
    if aside := _aside_words(facts):
        out.line(f"Set aside  {aside} (blocks)")
    out.line()
    columns = ("sensor", "valid", "invalid", "clipped")
    out.table(columns, [[row[name] for name in columns] for row in facts["sensors"]])
    _show_clipping(facts, out)
    _show_events(facts, out)
    for path in facts.get("files", {}).values():
        out.line(f"Written    {path}")


def _show_clipping(facts: Facts, out: Output) -> None:
    clipping = facts["clipping"]
    if clipping is None:
        return
    when = f"{clipping['first_s']:.3f} to {clipping['last_s']:.3f} s"
    if clipping["in_fall"]:
        out.line(
            f"Clipped     {when}: {clipping['in_fall']} samples of them IN THE FALL; they are lower bounds."
        )
    else:
        out.line(f"Clipped     {when}: none within {clipping['fall_s']:g} s after the release.")
    out.line()


def _show_events(facts: Facts, out: Output) -> None:
    if facts["release_us"] is None:
        out.line("No release was recorded: times count from the first sample.")
    else:
        doubtful = "" if facts["t_s_origin"] == "release" else ", which is doubtful"
        out.line(f"Times count from the release{doubtful}.")
    rows = [(f"{event['t_s']:.6f}", event_words(event)) for event in facts["events"][:_EVENTS_SHOWN]]
    if rows:
        out.table(("t / s", "event"), rows)
    if len(facts["events"]) > _EVENTS_SHOWN:
        out.line(f"… and {len(facts['events']) - _EVENTS_SHOWN} more events (all of them with --json).")


def _verdict_words(facts: Facts) -> str:
    """The verdict, and what there is of the recording."""
    if facts["verdict"] == "complete":
        return "complete: nothing is missing"
    if facts["verdict"] == "damaged":
        return "damaged: something inside is missing or contradictory; every value that is given is right"
    starts_late = any(gap["late_start"] for gap in facts["gaps"])
    missing = [word for word, is_so in (("before", starts_late), ("after", facts["footer"] is None)) if is_so]
    return (
        f"truncated: complete from {facts['first_s']:.1f} s to {facts['last_s']:.1f} s; "
        f"what came {' and '.join(missing)} is not in the file"
    )


def _aside_words(facts: Facts) -> str:
    """The blocks that were left out, by reason; empty if none were."""
    aside = {name: count for name, count in facts["set_aside"].items() if count}
    return ", ".join(f"{count} {_ASIDE.get(name, name.replace('_', ' '))}" for name, count in aside.items())


def _footer_rows(footer: Facts | None) -> Iterator[tuple[str, str]]:
    """What the logger itself says of how it went: a label and a text each; nothing without a footer."""
    if footer is None:
        return
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
