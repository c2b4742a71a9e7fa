"""The maneuver on the board, as JSON and as words for people."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from tfsat_host.units import US_PER_S

if TYPE_CHECKING:
    from tfsat_host.devices.sequencer import StoredManeuver


def maneuver_as_dict(stored: StoredManeuver) -> dict[str, Any]:
    """Every stroke, the end, and what tells one maneuver from another."""
    return {
        "origin": stored.origin.name.lower(),
        "strokes": [
            {"t_s": start_us / US_PER_S, "joint": joint, "angle_deg": angle_cdeg / 100}
            for joint, angle_cdeg, start_us in stored.strokes
        ],
        "end_s": round(Fraction(stored.end_us, US_PER_S) * 100) / 100,
        "end_us": stored.end_us,
        "crc": f"{stored.crc:04x}",
    }


def maneuver_words(stored: StoredManeuver) -> str:
    """One line."""
    return f"{', '.join(_strokes(stored))} ({stored.origin.name.lower()}, CRC {stored.crc:04x})"


def flight_words(stored: StoredManeuver) -> str:
    """What would fly, a line for each stroke."""
    count = len(stored.strokes)
    title = (
        f"This maneuver will fly: {count} stroke{'' if count == 1 else 's'}, {stored.origin.name.lower()}, "
        f"CRC {stored.crc:04x}, over {stored.end_us / US_PER_S:.2f} s after the release."
    )
    return "\n  ".join([title, *_strokes(stored)])


def _strokes(stored: StoredManeuver) -> list[str]:
    return [
        f"{start_us / US_PER_S:.2f} s joint {joint} {angle_cdeg / 100:+g}°"
        for joint, angle_cdeg, start_us in stored.strokes
    ]
