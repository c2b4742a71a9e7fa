"""A servo's map and what follows from it, as JSON and as words for people."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees
from typing import Any

from tfsat_host.calibration.servos.figures import gain_of, left_by, offset_of, places_of
from tfsat_host.calibration.servos.points import ServoPoint
from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.cli.servo_words import comparison
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_rows
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.quantity import Column, Columns, fields, plus_minus, record
from tfsat_host.servo_settings import ServoSettings


def points_as_dicts(
    points: Sequence[ServoPoint], stopped: Sequence[bool], setting: ServoSetting
) -> list[dict[str, Any]]:
    """Each visit, in order of time; `stopped` are those that the map leaves out."""
    commanded = {place.pulse_us: place.commanded_deg for place in places_of(points, setting)}
    return [
        {
            "commanded_deg": round(commanded[point.pulse_us], 3),
            "pulse_us": point.pulse_us,
            "direction": "opening" if point.direction > 0 else "closing",
            "reached_deg": degrees(point.reached_rad),
            "std_deg": degrees(point.std_rad),
            "at_stop": met,
        }
        for point, met in zip(points, stopped, strict=True)
    ]


_MAP = fields("backlash_deg backlash_std_deg repeatability_deg nonlinearity_deg places")
_PLACES: Columns = (
    Column("commanded_deg", "commanded", form=".1f"),
    Column("pulse_us", "pulse", form="g"),
    Column("opening_deg", "reached opening", form=".2f"),
    Column("closing_deg", "reached closing", form=".2f"),
)


def map_as_dict(servo_map: ServoMap) -> dict[str, Any]:
    """The map in figures that people compare."""
    gain, offset = gain_of(servo_map), offset_of(servo_map)
    return {
        **record(_MAP, servo_map),
        "gain": gain.value,
        "gain_std": gain.std,
        "offset_deg": offset.value,
        "offset_std_deg": offset.std,
    }


def show_map(servo_map: ServoMap, points: Sequence[ServoPoint], stopped: Sequence[bool], out: Output) -> None:
    """The places, and the figures below them."""
    places = places_of(points, servo_map.setting)
    show_rows(_PLACES, places, out, title=f"Servo of joint {servo_map.joint}")
    if any(stopped):
        out.line(
            "Within half a degree of the ends of its range the joint may lie against its stop: those visits do not"
        )
        out.line("count for what follows.")
    gain, offset = gain_of(servo_map), offset_of(servo_map)
    out.line(f"gain            {plus_minus(gain.value, gain.std)}")
    out.line(f"offset          {plus_minus(offset.value, offset.std, sign=True)} deg at 0 deg")
    backlash_deg, std_deg = degrees(servo_map.backlash_rad), degrees(servo_map.backlash_std_rad)
    out.line(f"backlash        {plus_minus(backlash_deg, std_deg)} deg")
    for name, of, what in (
        ("repeatability", servo_map.repeatability_rad, "an arrival"),
        ("nonlinearity", servo_map.nonlinearity_rad, "the places"),
    ):
        out.line(f"{name:<16}{degrees(of):.2f} deg, standard deviation of {what}")


def show_settings(before: ServoSettings, after: ServoSettings, out: Output) -> None:
    """The new settings beside the old."""
    out.table(*comparison(after, before), title="Servo settings")


def left_words(servo_map: ServoMap, setting: ServoSetting) -> str:
    """How far the joint will miss with a setting."""
    left = left_by(servo_map, setting)
    return (
        f"joint {servo_map.joint} misses commanded angles by at most {left.mean_deg:.2f} deg on average of both "
        f"directions, stops {left.side_deg:.2f} deg short by its backlash, and scatters by {left.scatter_deg:.2f} deg."
    )
