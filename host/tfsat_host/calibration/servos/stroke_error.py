"""How far a maneuver's strokes will miss the angles that were commanded, by the servos' maps.

The paper's first stroke reached 54.8 deg where 59.0 were commanded (section "Result"): this tells so beforehand.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from tfsat_host.calibration.servos.servo_map import ServoMap
from tfsat_host.calibration.statistics import few
from tfsat_host.protocol.limits import SERVO_PULSE_MAX_US, SERVO_PULSE_MIN_US
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings import ServoSettings
from tfsat_host.servo_settings.settings import NS_PER_US, pulse_ns
from tfsat_host.units import CDEG_PER_DEG

TICK_NS: Final = 500
"""The sequencer's timer, which pulses are rounded to (firmware/arduino_sequencer/src/core/ticks.h)."""
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


def board_pulse_us(setting: ServoSetting, angle_cdeg: int) -> float:
    """The pulse that the board sends for an angle: whole ticks, and never outside what a servo takes."""
    ticks = (pulse_ns(setting, angle_cdeg) + TICK_NS // 2) // TICK_NS
    pulse_us = ticks * TICK_NS / NS_PER_US
    return min(max(pulse_us, float(SERVO_PULSE_MIN_US)), float(SERVO_PULSE_MAX_US))


def setting_error_rad(servo_map: ServoMap, setting: ServoSetting) -> float | None:
    """By how much a setting misses at worst, at the ends of the joint's limits, on average of both directions.

    Reached minus commanded; None where that is less than `NOTICEABLE_RAD` beyond what the map's own uncertainty
    (two standard deviations) explains: the setting is as good as the map's own.
    """
    worst_rad = None
    for angle_cdeg in (setting.min_cdeg, setting.max_cdeg):
        pulse_us = board_pulse_us(setting, angle_cdeg)
        off_rad = servo_map.reached_rad(pulse_us, 0) - float(np.deg2rad(angle_cdeg / CDEG_PER_DEG))
        change = np.array([1.0, pulse_us - servo_map.middle_us, 0.0])
        std_rad = float(np.sqrt(change @ servo_map.covariance @ change))
        if abs(off_rad) > max(NOTICEABLE_RAD + 2 * std_rad, abs(worst_rad or 0.0)):
            worst_rad = off_rad
    return worst_rad
