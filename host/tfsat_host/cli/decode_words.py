"""What `decode` says about a recording besides its numbers: sentences from the decoded facts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from typing import Any

from tfsat_host.protocol.enums import StopReason

Facts = Mapping[str, Any]
_LISTED = 20
_STOPPED = {
    StopReason.HOST: "by a stop over the cable",
    StopReason.LANDING: "by itself, after the landing",
    StopReason.FILE_FULL: "because its file was full",
    StopReason.CARD_GONE: "because the card was gone",
}
_CHOSEN = {
    "asked for": "which was asked for",
    "time of day": "the newest by the time of day in the headers",
    "place": "the first in the file, because not every one of them tells its time of day",
}
_ASIDE = {"stale": "of other recordings"}


def verdict_words(facts: Facts) -> str:
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


def aside_words(facts: Facts) -> str:
    """The blocks that were left out, by reason; empty if none were."""
    aside = {name: count for name, count in facts["set_aside"].items() if count}
    return ", ".join(f"{count} {_ASIDE.get(name, name.replace('_', ' '))}" for name, count in aside.items())


def footer_rows(footer: Facts | None) -> Iterator[tuple[str, str]]:
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


def recordings_lines(
    facts: Facts, file: object, command: str = "decode", done: str = "Decoded"
) -> Iterator[str]:
    """That a file holds several recordings, which one the command took and how to get another."""
    recordings = facts["recordings"]
    others = len(facts["other_sessions"])
    if not others:
        return
    yield f"{file} holds {others + 1} recordings. {done}: {facts['session']}, {_CHOSEN[facts['chosen_by']]}."
    for one in recordings[:_LISTED]:
        started = "-" if one["started_unix_us"] is None else utc(one["started_unix_us"])
        yield (
            f"  {one['session']}  {started:<23}  about {one['samples']} samples in {one['blocks']} blocks, "
            f"{_state(one)}"
        )
    if others + 1 > min(len(recordings), _LISTED):
        yield f"  … and {others + 1 - min(len(recordings), _LISTED)} more (--json names them)."
    yield f"Another one: tfsat-host {command} {file} --session ID"


def utc(unix_us: int) -> str:
    """A time of day to the second, or that it is none."""
    try:
        moment = datetime.fromtimestamp(unix_us / 1e6, UTC)
    except (OverflowError, ValueError, OSError):
        return f"at an impossible time of day ({unix_us} µs since 1970)"
    return moment.isoformat(sep=" ", timespec="seconds").replace("+00:00", " UTC")


def _state(recording: Facts) -> str:
    if not recording["is_unbroken"]:
        return "parts of it"
    return "whole" if recording["has_end"] else "without an end"
