"""How far a joint will miss the angles that are commanded, by its servo's map, over its range and in a maneuver.

The paper's first stroke reached 54.8 deg where 59.0 were commanded (section "Result"): this says so beforehand.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import degrees
from typing import Any, Final

import numpy as np

from tfsat_host.calibration.servos.servo_map import ServoMap, ServoPoint, board_pulse_us, servo_plan
from tfsat_host.calibration.statistics import few
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.quantity import Quantity
from tfsat_host.servo_settings import NS_PER_US, ServoSettings
from tfsat_host.units import CDEG_PER_DEG

NOTICEABLE_RAD: Final = np.deg2rad(0.1)
"""More than the rounding of a setting and of a pulse, and than a count of the angle sensors."""


@dataclass(frozen=True, slots=True)
class StrokeError:
    """What to expect of one stroke.

    Attributes:
        stroke: Its number in the maneuver, from 1.
        joint: 1 to 3.
        commanded_cdeg: Change of the joint angle that is commanded, 0.01 deg.
        error_rad: Change that will be reached minus the one commanded, on average.
        std_rad: Standard deviation of that difference in a single drop.
    """

    stroke: int
    joint: int
    commanded_cdeg: int
    error_rad: float
    std_rad: float


@dataclass(frozen=True, slots=True)
class _Rest:
    """Where a joint rests between strokes, and how it came there."""

    angle_cdeg: int = 0
    direction: int = 0


def expected_stroke_errors(
    moves: Iterable[tuple[int, int]], maps: Sequence[ServoMap], settings: ServoSettings
) -> tuple[StrokeError, ...]:
    """What to expect of each stroke whose joint has a map; the others are left out.

    Every joint starts at 0 deg. A servo that is armed comes there from wherever its limp joint hung, so the
    direction of that motion is unknown: the first stroke starts from the middle of the backlash, and half of it
    either way is part of the uncertainty. Gravity is not: the maps are measured on the bench, strokes fly in free fall.

    Args:
        moves: (joint, angle_cdeg) of each stroke, in order.
        maps: At most one for each joint.
        settings: On the board: they turn angles into pulses, whether they fit the maps or not.
    """
    by_joint = {servo_map.joint: servo_map for servo_map in maps}
    rests = dict.fromkeys(by_joint, _Rest())
    errors = []
    for number, (joint, angle_cdeg) in enumerate(moves, 1):
        if joint not in by_joint:
            continue
        start = rests[joint]
        end = _Rest(start.angle_cdeg + angle_cdeg, 1 if angle_cdeg > 0 else -1)
        rests[joint] = end
        error_rad, std_rad = _difference(by_joint[joint], settings.of(joint), start, end)
        errors.append(StrokeError(number, joint, angle_cdeg, error_rad, std_rad))
    return tuple(errors)


def _difference(servo_map: ServoMap, setting: ServoSetting, start: _Rest, end: _Rest) -> tuple[float, float]:
    """Mean and standard deviation of the stroke reached minus the stroke commanded, rad."""
    start_us, end_us = (board_pulse_us(setting, rest.angle_cdeg) for rest in (start, end))
    from_rad, to_rad = (
        servo_map.reached_rad(pulse_us, rest.direction)
        for pulse_us, rest in ((start_us, start), (end_us, end))
    )
    commanded_rad = np.deg2rad((end.angle_cdeg - start.angle_cdeg) / CDEG_PER_DEG)
    change = np.array([0.0, end_us - start_us, (start.direction - end.direction) / 2])
    variance = float(change @ servo_map.covariance @ change)
    # Both ends scatter, and both lie off the straight line.
    variance += 2 * few(servo_map.repeats) * servo_map.repeatability_rad**2
    variance += 2 * few(servo_map.places - 2) * servo_map.nonlinearity_rad**2
    if start.direction == 0:
        variance += (servo_map.backlash_rad / 2) ** 2
    return float(to_rad - from_rad - commanded_rad), float(np.sqrt(variance))


def setting_error_rad(servo_map: ServoMap, setting: ServoSetting) -> float | None:
    """By how much a setting misses at worst, at the ends of the joint's limits, on average of both directions.

    Reached minus commanded; None where that is less than `NOTICEABLE_RAD` beyond what the map's own uncertainty
    (two standard deviations) explains: the setting is as good as the map's own.
    """
    worst_rad = None
    for angle_cdeg in (setting.min_cdeg, setting.max_cdeg):
        pulse_us = board_pulse_us(setting, angle_cdeg)
        off_rad = servo_map.reached_rad(pulse_us, 0) - float(np.deg2rad(angle_cdeg / CDEG_PER_DEG))
        if abs(off_rad) > max(NOTICEABLE_RAD + 2 * servo_map.std_rad(pulse_us), abs(worst_rad or 0.0)):
            worst_rad = off_rad
    return worst_rad


def gain_of(servo_map: ServoMap) -> Quantity:
    """Reached per commanded change, by the setting that was in force; 1 is exact."""
    setting = servo_map.setting
    us_per_deg = setting.ns_per_deg / NS_PER_US * (-1.0 if setting.reversed else 1.0)
    std = float(np.sqrt(servo_map.covariance[1, 1])) * abs(us_per_deg)
    return Quantity(degrees(servo_map.slope_rad_per_us * us_per_deg), degrees(std))


def offset_of(servo_map: ServoMap) -> Quantity:
    """Where it comes to rest when 0 deg is commanded, deg, on average of both directions; likewise."""
    zero_us = float(servo_map.setting.zero_us)
    return Quantity(
        degrees(servo_map.reached_rad(zero_us, 0)), degrees(servo_map.std_rad(zero_us)), form="+.3f"
    )


def places_of(points: Sequence[ServoPoint], setting: ServoSetting) -> list[dict[str, Any]]:
    """A row for each pulse, in order of the commanded angle.

    `commanded_deg` is by the board's setting; `opening_deg` and `closing_deg` are where the joint came to rest on
    average, from either side; None: never from there.
    """
    places = []
    for pulse_us in {point.pulse_us for point in points}:
        change_us = (pulse_us - setting.zero_us) * (-1.0 if setting.reversed else 1.0)
        row: dict[str, Any] = {
            "pulse_us": pulse_us,
            "commanded_deg": change_us * NS_PER_US / setting.ns_per_deg,
        }
        for name, way in (("opening_deg", 1), ("closing_deg", -1)):
            side = [one.reached_rad for one in points if (one.pulse_us, one.direction) == (pulse_us, way)]
            row[name] = degrees(np.mean(side)) if side else None
        places.append(row)
    return sorted(places, key=lambda row: float(row["commanded_deg"]))


def left_by(servo_map: ServoMap, setting: ServoSetting) -> dict[str, float]:
    """How far the joint misses the angles that are commanded with a setting, over its limits.

    `mean_deg` is at the worst place, on average of both directions: what rounding and old settings do; `side_deg` half
    the backlash: it stops so far short, from either side; `scatter_deg` the standard deviation of one arrival, with the
    bends of the servo.
    """
    off_deg = [
        degrees(servo_map.reached_rad(board_pulse_us(setting, angle_cdeg), 0)) - angle_cdeg / CDEG_PER_DEG
        for angle_cdeg in servo_plan(setting)
    ]
    return {
        "mean_deg": max(map(abs, off_deg)),
        "side_deg": degrees(abs(servo_map.backlash_rad)) / 2,
        "scatter_deg": degrees(np.hypot(servo_map.repeatability_rad, servo_map.nonlinearity_rad)),
    }
