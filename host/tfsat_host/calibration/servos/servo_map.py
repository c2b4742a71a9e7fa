"""The angle at which a servo comes to rest for a pulse: how it is measured, settings and strokes that follow from it.

The paper's first stroke reached 54.8 deg where 59.0 were commanded (section "Result"): this says so beforehand.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import pairwise
from math import ceil, degrees
from typing import Final

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.statistics import student_t_factor
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol.limits import SERVO_PULSE_MAX_US, SERVO_PULSE_MIN_US
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings import NS_PER_US, Finding, ServoSettings, SettingsDefect, find_defect, pulse_ns
from tfsat_host.units import CDEG_PER_DEG

TICK_NS: Final = 500
"""The sequencer's timer, which pulses are rounded to (firmware/arduino_sequencer/src/core/ticks.h)."""
STEP_CDEG: Final = 1500
"""About so far from place to place."""
MIN_STEPS: Final = 5
"""Closer together where the limits are narrow: so many places separate a bend from scatter."""
ROUNDS: Final = 2
"""Each place is visited so often from either side: repeated visits give its repeatability."""
HOLD_S: Final = 1.0
"""How long each visit is held."""


@dataclass(frozen=True, slots=True)
class ServoPoint:
    """One visit: the servo was given a pulse and came to rest.

    Attributes:
        pulse_us: Width of the pulse that held it.
        direction: How the joint came there: +1 opening, -1 closing, 0 where that is unknown.
        reached_rad: Joint angle at rest.
        std_rad: Standard deviation of that by the sensors' noise alone; the servo's own scatter is found from the
            visits, and an error that all visits share (zero point, scale) is the sensors' calibration's.
    """

    pulse_us: float
    direction: int
    reached_rad: float
    std_rad: float


def servo_plan(servo: ServoSetting) -> tuple[int, ...]:
    """Angles to command one after the other (0.01 deg): up and down over the joint's limits, `ROUNDS` times.

    It begins and ends at the lower limit, and each place is held for `HOLD_S`.
    """
    span_cdeg = servo.max_cdeg - servo.min_cdeg
    steps = max(ceil(span_cdeg / STEP_CDEG), MIN_STEPS)
    # Up and down: each place is reached from either side, which separates backlash from the line.
    up = [servo.min_cdeg + round(span_cdeg * step / steps) for step in range(steps + 1)]
    return (up[0], *(up[1:] + up[-2::-1]) * ROUNDS)


def arrivals(angles: Sequence[float]) -> tuple[int, ...]:
    """Find the side from which each commanded angle is reached, as `ServoPoint.direction`.

    It is unknown until the joint moves.
    """
    directions = [0]
    for before, after in pairwise(angles):
        # A repeated angle does not move the joint: it keeps the side of the last motion.
        directions.append((after > before) - (after < before) or directions[-1])
    return tuple(directions[: len(angles)])


_TOO_LARGE: Final = 65_535
"""No setting of the board is larger; its rules refuse that one, too."""


@dataclass(frozen=True, eq=False)
class ServoMap:
    """A joint's servo as measured.

    It comes to rest at middle_rad + slope_rad_per_us * (pulse - middle_us) - direction * backlash_rad / 2, where
    direction is +1 if the joint opened last and -1 if it closed.

    Attributes:
        joint: 1 to 3.
        middle_us: Pulse in the middle of those that were measured: there offset and slope are nearly independent.
        middle_rad: Joint angle that it leads to, on average of both directions.
        slope_rad_per_us: Change of the angle for each microsecond; negative if shorter pulses open the joint.
        backlash_rad: Angle reached closing minus angle reached opening, at the same pulse.
        covariance: (3, 3) of middle_rad, slope_rad_per_us, backlash_rad.
        repeatability_rad: Standard deviation of a single arrival at the same pulse from the same side.
        repeats: Degrees of freedom that the repeatability was estimated from.
        nonlinearity_rad: Standard deviation, from place to place, of what the straight line leaves; scatter removed.
        places: At how many pulses the servo was measured.
        pulse_range_us: Shortest and longest of them.
        setting: In force on the board when it was measured.
        recorded_at: When that was.
    """

    joint: int
    middle_us: float
    middle_rad: float
    slope_rad_per_us: float
    backlash_rad: float
    covariance: FloatArray
    repeatability_rad: float
    repeats: int
    nonlinearity_rad: float
    places: int
    pulse_range_us: tuple[float, float]
    setting: ServoSetting
    recorded_at: datetime

    @property
    def backlash_std_rad(self) -> float:
        """Standard deviation of the backlash."""
        return float(np.sqrt(self.covariance[2, 2]))

    @property
    def stop_std_rad(self) -> float:
        """Standard deviation of where a single stroke ends, as a prediction does not know it."""
        middle, backlash = np.sqrt(self.covariance[[0, 2], [0, 2]])
        scatter = [middle, 0.5 * backlash, self._single_std_rad]
        return float(np.linalg.norm(scatter))

    @property
    def _single_std_rad(self) -> float:
        """Of a single arrival about the line: by scatter, and because places lie off the line."""
        variance = student_t_factor(self.repeats) * self.repeatability_rad**2
        variance += student_t_factor(self.places - 2) * self.nonlinearity_rad**2
        return float(np.sqrt(variance))

    def std_rad(self, pulse_us: float) -> float:
        """Standard deviation of where it comes to rest on average of both directions."""
        # Gradient by middle, slope and backlash; on average of both directions the backlash drops out.
        change = np.array([1.0, pulse_us - self.middle_us, 0.0])
        return float(np.sqrt(change @ self.covariance @ change))

    def reached_rad(self, pulse_us: float, direction: int) -> float:
        """Compute the joint's mean angle at rest.

        Args:
            pulse_us: Width of the pulse.
            direction: Direction of the last motion: +1 opening, -1 closing, 0 for the average of both.
        """
        centred_rad = self.middle_rad + self.slope_rad_per_us * (pulse_us - self.middle_us)
        return centred_rad - direction * self.backlash_rad / 2


def matching_setting(servo_map: ServoMap, current: ServoSetting) -> ServoSetting:
    """Compute the setting with which the joint reaches commanded angles on average of both directions.

    Limits stay as they are. It is not checked whether a board accepts the setting.
    """
    # Invert the line at angle zero; half the backlash is left to either side.
    zero_us = servo_map.middle_us - servo_map.middle_rad / servo_map.slope_rad_per_us
    us_per_deg = 1.0 / abs(degrees(servo_map.slope_rad_per_us))
    # Clamp to what a field of the board holds; the board's rules refuse the clamped value.
    return replace(
        current,
        zero_us=min(max(round(zero_us), 0), _TOO_LARGE),
        ns_per_deg=min(round(us_per_deg * NS_PER_US), _TOO_LARGE),
        reversed=int(servo_map.slope_rad_per_us < 0),
    )


def settings_from_map(servo_map: ServoMap, current: ServoSettings) -> ServoSettings:
    """Correct the setting of the map's joint in the board's settings.

    Raises:
        CalibrationError: the board would refuse them: with these pulses the servo does not reach its whole
            range.
    """
    index = servo_map.joint - 1
    setting = matching_setting(servo_map, current.of(servo_map.joint))
    servos = (*current.servos[:index], setting, *current.servos[index + 1 :])
    settings = replace(current, servos=servos)
    # Judge the whole set: a defect may be an old one of another joint, which has another cure.
    finding = find_defect(settings)
    if finding is None:
        return settings
    if finding.index != index:
        raise CalibrationError(
            what=f"The board's present settings are not valid: {finding.key}: {finding.problem}.",
            meaning="No settings could be derived from them; the board keeps what it has.",
            next_step=Advice(
                finding.cure, " Upload the corrected file with ", NextStep("upload-servos"), "."
            ),
        )
    raise CalibrationError(
        what=f"Joint {servo_map.joint} cannot have the settings that it needs: {finding.problem}.",
        meaning="The servo does not reach every angle that may be commanded; the board keeps what it has.",
        next_step=_cure(servo_map.joint, setting, finding),
    )


def _cure(joint: int, setting: ServoSetting, finding: Finding) -> str:
    again = Advice("measure it again: ", NextStep("calibrate servo", ("--joint", str(joint))))
    if finding.code != SettingsDefect.PULSE_RANGE:
        return Advice(
            f"Look whether the horn of servo {joint} slips, or it is another servo than the others; ", again
        )
    most_cdeg = _most_reachable_cdeg(setting)
    if most_cdeg > 0:
        return Advice(
            f"Narrow limits_deg of joint {joint} to [0, {most_cdeg / CDEG_PER_DEG:g}] in the settings' file and "
            "upload it (",
            NextStep("upload-servos"),
            "), or mount the servo's horn some teeth further and ",
            again,
        )
    return Advice(f"Mount the horn of servo {joint} so that 0 deg lies well within its range, and ", again)


def _most_reachable_cdeg(setting: ServoSetting) -> int:
    """Compute the largest upper limit whose pulse a servo accepts, rounded down to a whole degree.

    0 or less: there is none.
    """
    zero_us, ends_us = setting.zero_us, (SERVO_PULSE_MIN_US, SERVO_PULSE_MAX_US)
    # Opening lengthens the pulses, or shortens them where the servo is reversed.
    room_us = zero_us - ends_us[0] if setting.reversed else ends_us[1] - zero_us
    if not ends_us[0] <= zero_us <= ends_us[1]:
        return 0
    return room_us * NS_PER_US // setting.ns_per_deg * CDEG_PER_DEG


def board_pulse_us(setting: ServoSetting, angle_cdeg: int) -> float:
    """Compute the pulse that the board sends for an angle: whole ticks, clamped to the servo's range."""
    # Half a tick before the integer division rounds to the nearest.
    ticks = (pulse_ns(setting, angle_cdeg) + TICK_NS // 2) // TICK_NS
    pulse_us = ticks * TICK_NS / NS_PER_US
    return min(max(pulse_us, float(SERVO_PULSE_MIN_US)), float(SERVO_PULSE_MAX_US))


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
    """Predict the error of each stroke whose joint has a map; others are left out.

    Every joint starts at 0 deg. An armed servo comes there from wherever its limp joint hung, so the
    direction of that motion is unknown: the first stroke starts from the middle of the backlash, and half of
    it either way is part of the uncertainty. Gravity is not: the maps are measured on the bench, strokes fly
    in free fall.

    Args:
        moves: (joint, angle_cdeg) of each stroke, in order.
        maps: At most one for each joint.
        settings: On the board: they turn angles into pulses, whether they fit the maps or not.
    """
    by_joint = {servo_map.joint: servo_map for servo_map in maps}
    # Carry each joint's last rest along: the side of arrival decides where in the backlash a stroke starts.
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
    # Gradient by middle, slope and backlash: the middle is common to both ends and cancels.
    change = np.array([0.0, end_us - start_us, (start.direction - end.direction) / 2])
    variance = float(change @ servo_map.covariance @ change)
    # Both ends scatter, and both lie off the straight line.
    variance += 2 * servo_map._single_std_rad**2
    # The side of the first arrival is unknown: half the backlash counts as a deviation.
    if start.direction == 0:
        variance += (servo_map.backlash_rad / 2) ** 2
    return float(to_rad - from_rad - commanded_rad), float(np.sqrt(variance))


def setting_error_rad(servo_map: ServoMap, setting: ServoSetting) -> float | None:
    """Compute a setting's largest error at the ends of the joint's limits, on average of both directions.

    Reached minus commanded; None if it is less than `NOTICEABLE_RAD` beyond what the map's own uncertainty (two
    standard deviations) explains: the setting is as good as the map's own.
    """
    worst_rad = None
    # The difference of two lines is largest at an end of the range.
    for angle_cdeg in (setting.min_cdeg, setting.max_cdeg):
        pulse_us = board_pulse_us(setting, angle_cdeg)
        off_rad = servo_map.reached_rad(pulse_us, 0) - float(np.deg2rad(angle_cdeg / CDEG_PER_DEG))
        if abs(off_rad) > max(NOTICEABLE_RAD + 2 * servo_map.std_rad(pulse_us), abs(worst_rad or 0.0)):
            worst_rad = off_rad
    return worst_rad
