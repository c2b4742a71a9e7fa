"""What the sequencer has stored, its maneuver and its servo settings: as JSON and as words for people."""

from __future__ import annotations

from fractions import Fraction

from tfsat_host.devices.sequencer import StoredManeuver
from tfsat_host.protocol.enums import Origin
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.quantity import Column, Columns, columns_of, fields
from tfsat_host.servo_settings import ServoSettings, limits_text
from tfsat_host.units import US_PER_S

_STROKES: Columns = (
    Column("t_s", of=lambda stroke: stroke[2] / US_PER_S),
    Column("joint", of=lambda stroke: stroke[0]),
    Column("angle_deg", of=lambda stroke: stroke[1] / 100),
)
MANEUVER: Columns = (
    Column("origin"),
    Column("strokes", columns=_STROKES),
    # Round an exact fraction: a binary quotient may fall on the wrong side of a half.
    Column("end_s", of=lambda stored: round(Fraction(stored.end_us, US_PER_S) * 100) / 100),
    Column("end_us"),
    Column("crc", of=lambda stored: f"{stored.crc:04x}"),
)
"""Every stroke and the end of a `StoredManeuver`, with its origin and CRC to tell it from another."""
_SERVO: Columns = (
    Column("joint", of=lambda row: row[0]),
    Column("zero_us", of=lambda row: row[1].zero_us),
    Column("us_per_deg", of=lambda row: row[1].ns_per_deg / 1000),
    Column("reversed", of=lambda row: bool(row[1].reversed)),
    Column("limits_deg", of=lambda row: [row[1].min_cdeg / 100, row[1].max_cdeg / 100]),
)
SERVO_SETTINGS: Columns = (
    Column("frame_ms", of=lambda settings: settings.frame_us / 1000),
    Column("moving_at_once"),
    Column("servos", of=lambda settings: list(enumerate(settings.servos, 1)), columns=_SERVO),
)
"""Of `ServoSettings`, under the keys of the settings' file."""
STORED_SETTINGS: Columns = (*fields("origin generation"), *columns_of("settings", SERVO_SETTINGS))
"""Of settings that a board stores, with their origin and how many it has stored."""


def maneuver_words(stored: StoredManeuver) -> str:
    """Format the maneuver in one line."""
    return f"{', '.join(_strokes(stored))} ({stored.origin.name.lower()}, CRC {stored.crc:04x})"


def flight_words(stored: StoredManeuver) -> str:
    """Describe the maneuver that would fly, a line for each stroke."""
    count = len(stored.strokes)
    title = (
        f"Maneuver to fly: {count} stroke{'' if count == 1 else 's'}, {stored.origin.name.lower()}, "
        f"CRC {stored.crc:04x}, over {stored.end_us / US_PER_S:.2f} s after the release."
    )
    return "\n  ".join([title, *_strokes(stored)])


def _strokes(stored: StoredManeuver) -> list[str]:
    return [
        f"{start_us / US_PER_S:.2f} s joint {joint} {angle_cdeg / 100:+g} deg"
        for joint, angle_cdeg, start_us in stored.strokes
    ]


def origin_words(origin: Origin) -> str:
    """Name the origin of the settings on a board."""
    return "factory settings" if origin == Origin.FACTORY else "uploaded settings"


def servo_words(servo: ServoSetting) -> str:
    """Format the settings of one joint's servo in one line."""
    sign = "-" if servo.reversed else "+"
    return f"{servo.zero_us} us at 0 deg, {sign}{servo.ns_per_deg / 1000:g} us/deg, limits {limits_text(servo)} deg"


def comparison(
    new: ServoSettings, old: ServoSettings | None
) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Columns and rows of a table: new values and those that were there (None: nothing to compare with).

    A value that stays is marked by `=`.
    """
    if old is None:
        return ("setting", "value"), _rows(new)
    rows = zip(_rows(old), _rows(new), strict=True)
    marked = [(name, before, "=" if before == after else after) for (name, before), (_, after) in rows]
    return ("setting", "on the board", "new"), list(marked)


def _rows(settings: ServoSettings) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = [
        ("pulse to pulse / ms", f"{settings.frame_us / 1000:g}"),
        ("joints that move at once", str(settings.moving_at_once)),
    ]
    for joint, servo in enumerate(settings.servos, 1):
        rows += [
            (f"joint {joint}: pulse at 0 deg / us", str(servo.zero_us)),
            (f"joint {joint}: change / us per deg", f"{servo.ns_per_deg / 1000:g}"),
            (f"joint {joint}: opens by", "shorter pulses" if servo.reversed else "longer pulses"),
            (f"joint {joint}: limits / deg", limits_text(servo)),
        ]
    return rows
