"""Servo settings as JSON and as words for people."""

from __future__ import annotations

from typing import Any

from tfsat_host.protocol.enums import Origin
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings import ServoSettings
from tfsat_host.servo_settings.rules import limits_text


def settings_as_dict(settings: ServoSettings) -> dict[str, Any]:
    """The keys of the settings' file."""
    return {
        "frame_ms": settings.frame_us / 1000,
        "servos": [
            {
                "joint": joint,
                "zero_us": servo.zero_us,
                "us_per_deg": servo.ns_per_deg / 1000,
                "reversed": bool(servo.reversed),
                "limits_deg": [servo.min_cdeg / 100, servo.max_cdeg / 100],
            }
            for joint, servo in enumerate(settings.servos, 1)
        ],
    }


def origin_words(origin: Origin) -> str:
    """Where the settings on a board come from."""
    return "factory settings" if origin == Origin.FACTORY else "uploaded settings"


def servo_words(servo: ServoSetting) -> str:
    """One line for one joint."""
    sign = "-" if servo.reversed else "+"
    return (
        f"{servo.zero_us} us at 0°, {sign}{servo.ns_per_deg / 1000:g} us/deg, limits {limits_text(servo)} deg"
    )


def comparison(
    new: ServoSettings, old: ServoSettings | None
) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Columns and rows of a table: what is new beside what was there (None: nothing to compare with).

    A value that stays is marked by `=`.
    """
    if old is None:
        return ("setting", "value"), _rows(new)
    rows = [
        (name, before, "=" if before == after else after)
        for (name, before), (_, after) in zip(_rows(old), _rows(new), strict=True)
    ]
    return ("setting", "on the board", "new"), list(rows)


def _rows(settings: ServoSettings) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = [("pulse to pulse / ms", f"{settings.frame_us / 1000:g}")]
    for joint, servo in enumerate(settings.servos, 1):
        rows += [
            (f"joint {joint}: pulse at 0 deg / us", str(servo.zero_us)),
            (f"joint {joint}: change / us per deg", f"{servo.ns_per_deg / 1000:g}"),
            (f"joint {joint}: opens by", "shorter pulses" if servo.reversed else "longer pulses"),
            (f"joint {joint}: limits / deg", limits_text(servo)),
        ]
    return rows
