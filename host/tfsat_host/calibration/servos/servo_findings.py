"""What the measurement of a servo has found, for JSON and for people."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees
from typing import Any

import numpy as np

from tfsat_host.calibration.servos.servo_map import ServoMap, ServoPoint, board_pulse_us, servo_plan
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.quantity import Column, Columns, Quantity, Table, fields, plus_minus, record
from tfsat_host.servo_settings import NS_PER_US
from tfsat_host.units import CDEG_PER_DEG

_MAP = fields("backlash_deg backlash_std_deg repeatability_deg nonlinearity_deg places")
_PLACES: Columns = (
    Column("commanded_deg", "commanded", form=".1f"),
    Column("pulse_us", "pulse", form="g"),
    Column("opening_deg", "reached opening", form=".2f"),
    Column("closing_deg", "reached closing", form=".2f"),
)


def servo_outcome(
    servo_map: ServoMap, points: Sequence[ServoPoint], stopped: Sequence[bool]
) -> tuple[dict[str, Any], tuple[Table | str, ...]]:
    """Build the results of a servo's measurement, for JSON and for people.

    They are the visits in order of time, and the map in figures that people compare; `stopped` marks the visits
    that the map leaves out.
    """
    gain, offset, places = gain_of(servo_map), offset_of(servo_map), places_of(points, servo_map.setting)
    commanded = {row["pulse_us"]: row["commanded_deg"] for row in places}
    visits = [
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
    figures = {
        "gain": gain.value,
        "gain_std": gain.std,
        "offset_deg": offset.value,
        "offset_std_deg": offset.std,
    }
    left_out = (
        "Within half a degree of the ends of its range the joint may lie against its stop: those visits are left out.",
    )
    backlash = plus_minus(degrees(servo_map.backlash_rad), degrees(servo_map.backlash_std_rad))
    parts = (
        Table(f"Servo of joint {servo_map.joint}", _PLACES, places),
        *(left_out if any(stopped) else ()),
        f"gain            {gain.text()}",
        f"offset          {offset.text()} deg at 0 deg",
        f"backlash        {backlash} deg",
        f"repeatability   {degrees(servo_map.repeatability_rad):.2f} deg, standard deviation of an arrival",
        f"nonlinearity    {degrees(servo_map.nonlinearity_rad):.2f} deg, standard deviation of the places",
    )
    return {"points": visits, "map": {**record(_MAP, servo_map), **figures}}, parts


def gain_of(servo_map: ServoMap) -> Quantity:
    """Reached per commanded change, by the setting that was in force; 1 is exact."""
    setting = servo_map.setting
    # Signed by the setting: a servo that does as told has gain +1, reversed or not.
    us_per_deg = setting.ns_per_deg / NS_PER_US * (-1.0 if setting.reversed else 1.0)
    std = float(np.sqrt(servo_map.covariance[1, 1])) * abs(us_per_deg)
    return Quantity(degrees(servo_map.slope_rad_per_us * us_per_deg), degrees(std))


def offset_of(servo_map: ServoMap) -> Quantity:
    """Compute the joint angle at rest when 0 deg is commanded, deg, on average of both directions.

    It is by the setting that was in force.
    """
    zero_us = float(servo_map.setting.zero_us)
    return Quantity(
        degrees(servo_map.reached_rad(zero_us, 0)), degrees(servo_map.std_rad(zero_us)), form="+.3f"
    )


def places_of(points: Sequence[ServoPoint], setting: ServoSetting) -> list[dict[str, Any]]:
    """Build a row for each pulse, in order of the commanded angle.

    `commanded_deg` is by the board's setting; `opening_deg` and `closing_deg` are the joint's mean angles at
    rest after arriving from either side; None: never from there.
    """
    places = []
    for pulse_us in {point.pulse_us for point in points}:
        # Invert the board's line to get the angle that this pulse was commanded for.
        change_us = (pulse_us - setting.zero_us) * (-1.0 if setting.reversed else 1.0)
        row: dict[str, Any] = {
            "pulse_us": pulse_us,
            "commanded_deg": change_us * NS_PER_US / setting.ns_per_deg,
        }
        for name, way in (("opening_deg", 1), ("closing_deg", -1)):
            # Means of either side apart: their difference at one pulse is the backlash there.
            side = [
                point.reached_rad for point in points if (point.pulse_us, point.direction) == (pulse_us, way)
            ]
            row[name] = degrees(np.mean(side)) if side else None
        places.append(row)
    return sorted(places, key=lambda row: float(row["commanded_deg"]))


def left_by(servo_map: ServoMap, setting: ServoSetting) -> dict[str, float]:
    """Compute the joint's deviations from commanded angles with a setting, over its limits.

    `mean_deg` is the largest, on average of both directions: the effect of rounding and old settings;
    `side_deg` half the backlash, by which it stops short from either side; `scatter_deg` the standard
    deviation of one arrival, including the bends of the servo.
    """
    # Through the board's own rounding, at the places where the servo is measured.
    off_deg = [
        degrees(servo_map.reached_rad(board_pulse_us(setting, angle_cdeg), 0)) - angle_cdeg / CDEG_PER_DEG
        for angle_cdeg in servo_plan(setting)
    ]
    return {
        "mean_deg": max(map(abs, off_deg)),
        "side_deg": degrees(abs(servo_map.backlash_rad)) / 2,
        "scatter_deg": degrees(np.hypot(servo_map.repeatability_rad, servo_map.nonlinearity_rad)),
    }
