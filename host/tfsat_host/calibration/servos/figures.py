"""What a servo's map says in the figures that people compare: gain, offset, places, and what settings leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees

import numpy as np

from tfsat_host.calibration.servos.points import ServoPoint, servo_plan
from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.calibration.servos.stroke_error import board_pulse_us
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings.settings import NS_PER_US
from tfsat_host.units import CDEG_PER_DEG


@dataclass(frozen=True, slots=True)
class Figure:
    """A number and its standard deviation, in one unit."""

    value: float
    std: float


@dataclass(frozen=True, slots=True)
class Place:
    """The visits to one pulse.

    Attributes:
        pulse_us: Width of the pulse.
        commanded_deg: What the board was told, by its setting.
        opening_deg, closing_deg: Where the joint came to rest on average, from either side; None: never from there.
    """

    pulse_us: float
    commanded_deg: float
    opening_deg: float | None
    closing_deg: float | None


@dataclass(frozen=True, slots=True)
class Left:
    """How far a joint with given settings misses the angles that are commanded, deg.

    Attributes:
        mean_deg: At the worst place, on average of both directions: what rounding and old settings do.
        side_deg: Half the backlash: it stops so far short, from either side.
        scatter_deg: Standard deviation of one arrival, with the bends of the servo.
    """

    mean_deg: float
    side_deg: float
    scatter_deg: float


def gain_of(servo_map: ServoMap) -> Figure:
    """Reached per commanded change, by the setting that was in force; 1 is exact."""
    setting = servo_map.setting
    us_per_deg = setting.ns_per_deg / NS_PER_US * (-1.0 if setting.reversed else 1.0)
    std = float(np.sqrt(servo_map.covariance[1, 1])) * abs(us_per_deg)
    return Figure(degrees(servo_map.slope_rad_per_us * us_per_deg), degrees(std))


def offset_of(servo_map: ServoMap) -> Figure:
    """Where it comes to rest when 0 deg is commanded, deg, on average of both directions; likewise."""
    zero_us = float(servo_map.setting.zero_us)
    change = np.array([1.0, zero_us - servo_map.middle_us, 0.0])
    std = float(np.sqrt(change @ servo_map.covariance @ change))
    return Figure(degrees(servo_map.reached_rad(zero_us, 0)), degrees(std))


def places_of(points: Sequence[ServoPoint], setting: ServoSetting) -> tuple[Place, ...]:
    """In order of the commanded angle."""
    places = []
    for pulse_us in {point.pulse_us for point in points}:
        change_us = (pulse_us - setting.zero_us) * (-1.0 if setting.reversed else 1.0)
        means = [
            np.rad2deg(
                [one.reached_rad for one in points if (one.pulse_us, one.direction) == (pulse_us, way)]
            )
            for way in (1, -1)
        ]
        opening, closing = (float(side.mean()) if len(side) else None for side in means)
        places.append(Place(pulse_us, change_us * NS_PER_US / setting.ns_per_deg, opening, closing))
    return tuple(sorted(places, key=lambda place: place.commanded_deg))


def left_by(servo_map: ServoMap, setting: ServoSetting) -> Left:
    """What is left of the errors with a setting, over its limits."""
    off_deg = [
        degrees(servo_map.reached_rad(board_pulse_us(setting, angle_cdeg), 0)) - angle_cdeg / CDEG_PER_DEG
        for angle_cdeg in servo_plan(setting)
    ]
    scatter = float(np.hypot(servo_map.repeatability_rad, servo_map.nonlinearity_rad))
    return Left(max(map(abs, off_deg)), degrees(abs(servo_map.backlash_rad)) / 2, degrees(scatter))
