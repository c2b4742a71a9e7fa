"""The log's events in words."""

from __future__ import annotations

from typing import Any

from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.remedies import REMEDIES

_TEXTS = {
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


def event_words(event: dict[str, Any]) -> str:
    """What an event of a recording's metadata says; the bare name of one that this release does not know."""
    name: str = event["name"]
    arg: int = event["arg"]
    value: int = event["value"]
    if name == "release":
        return "RELEASE" if arg else "both switches closed again: that release was none"
    if name == "landing":
        return f"LANDING, a shock of {value / 1000:.1f} g" if arg else "landed, by the time since the release"
    return _TEXTS.get(name, name).format(
        number=event["index"] + 1,
        state="opened" if arg else "closed",
        fill=_FILLS.get(arg, "all"),
        value=value,
        cause=_cause(arg)
        + (f" (WHO_AM_I 0x{value:02x})" if arg == ErrorCode.SENSOR_FOREIGN and value else ""),
    )


def _cause(code: int) -> str:
    try:
        return REMEDIES[ErrorCode(code)][0].rstrip(".")
    except ValueError:
        return f"error {code}"
