"""A servo's map and what follows from it, as JSON and as words for people."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from math import degrees
from typing import Any

from tfsat_host.calibration.servos.figures import Left, Place, gain_of, left_by, offset_of, places_of
from tfsat_host.calibration.servos.points import ServoPoint
from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.cli.output import Output
from tfsat_host.cli.servo_words import comparison
from tfsat_host.protocol.messages import ServoSetting
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


def map_as_dict(servo_map: ServoMap) -> dict[str, Any]:
    """The map in figures that people compare."""
    gain, offset = gain_of(servo_map), offset_of(servo_map)
    return {
        "gain": gain.value,
        "gain_std": gain.std,
        "offset_deg": offset.value,
        "offset_std_deg": offset.std,
        "backlash_deg": degrees(servo_map.backlash_rad),
        "backlash_std_deg": degrees(servo_map.backlash_std_rad),
        "repeatability_deg": degrees(servo_map.repeatability_rad),
        "nonlinearity_deg": degrees(servo_map.nonlinearity_rad),
        "places": servo_map.places,
    }


def left_as_dict(left: Left) -> dict[str, Any]:
    """What error is left."""
    return asdict(left)


def show_map(servo_map: ServoMap, points: Sequence[ServoPoint], stopped: Sequence[bool], out: Output) -> None:
    """The places, and the figures below them."""
    rows = [
        (f"{place.commanded_deg:.1f}", f"{place.pulse_us:g}", *_reached(place))
        for place in places_of(points, servo_map.setting)
    ]
    columns = ("commanded / deg", "pulse / us", "reached opening / deg", "reached closing / deg")
    out.table(columns, rows, title=f"Servo of joint {servo_map.joint}")
    if any(stopped):
        out.line(
            "Within half a degree of the ends of its range the joint may lie against its stop: those visits do not"
        )
        out.line("count for what follows.")
    gain, offset = gain_of(servo_map), offset_of(servo_map)
    out.line(f"gain            {gain.value:.4f} ± {gain.std:.4f}")
    out.line(f"offset          {offset.value:+.2f} ± {offset.std:.2f} deg at 0 deg")
    backlash_deg, std_deg = degrees(servo_map.backlash_rad), degrees(servo_map.backlash_std_rad)
    out.line(f"backlash        {backlash_deg:.2f} ± {std_deg:.2f} deg")
    out.line(
        f"repeatability   {degrees(servo_map.repeatability_rad):.2f} deg, standard deviation of an arrival"
    )
    out.line(
        f"nonlinearity    {degrees(servo_map.nonlinearity_rad):.2f} deg, standard deviation over the places"
    )


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


def _reached(place: Place) -> tuple[str, str]:
    opening, closing = (
        "–" if angle_deg is None else f"{angle_deg:.2f}"
        for angle_deg in (place.opening_deg, place.closing_deg)
    )
    return opening, closing
