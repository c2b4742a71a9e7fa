"""The angle at which a servo comes to rest for a pulse, and the settings that follow from it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import degrees
from typing import Final

import numpy as np
from numpy.typing import NDArray

from tfsat_host.calibration.errors import CalibrationError
from tfsat_host.protocol.limits import SERVO_PULSE_MAX_US, SERVO_PULSE_MIN_US
from tfsat_host.protocol.messages import ServoSetting
from tfsat_host.servo_settings import ServoSettings, SettingsDefect, find_defect
from tfsat_host.servo_settings.rules import Finding
from tfsat_host.servo_settings.settings import NS_PER_US
from tfsat_host.units import CDEG_PER_DEG

FloatArray = NDArray[np.float64]

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

    @property
    def backlash_std_rad(self) -> float:
        """Standard deviation of the backlash."""
        return float(np.sqrt(self.covariance[2, 2]))

    def reached_rad(self, pulse_us: float, direction: int) -> float:
        """Where the joint comes to rest on average.

        Args:
            pulse_us: Width of the pulse.
            direction: Of the last motion: +1 opening, -1 closing, 0 for the average of both.
        """
        centred_rad = self.middle_rad + self.slope_rad_per_us * (pulse_us - self.middle_us)
        return centred_rad - direction * self.backlash_rad / 2


def matching_setting(servo_map: ServoMap, current: ServoSetting) -> ServoSetting:
    """With this the joint reaches the commanded angles on average of both directions; limits stay as they are.

    Whether a board takes it is not asked here.
    """
    zero_us = servo_map.middle_us - servo_map.middle_rad / servo_map.slope_rad_per_us
    us_per_deg = 1.0 / abs(degrees(servo_map.slope_rad_per_us))
    return replace(
        current,
        zero_us=min(max(round(zero_us), 0), _TOO_LARGE),
        ns_per_deg=min(round(us_per_deg * NS_PER_US), _TOO_LARGE),
        reversed=int(servo_map.slope_rad_per_us < 0),
    )


def settings_from_map(servo_map: ServoMap, current: ServoSettings) -> ServoSettings:
    """The board's settings with those of the map's joint corrected.

    Raises:
        CalibrationError: the board would refuse them: with these pulses the servo does not reach its whole range.
    """
    index = servo_map.joint - 1
    setting = matching_setting(servo_map, current.of(servo_map.joint))
    servos = (*current.servos[:index], setting, *current.servos[index + 1 :])
    settings = replace(current, servos=servos)
    finding = find_defect(settings)
    if finding is None:
        return settings
    if finding.index != index:
        raise CalibrationError(
            what=f"The board's present settings are not valid: {finding.key}: {finding.problem}.",
            meaning="No settings could be derived from them; the board keeps what it has.",
            next_step=f"{finding.cure} Upload the corrected file with tfsat-host upload-servos.",
        )
    raise CalibrationError(
        what=f"Joint {servo_map.joint} cannot have the settings that it needs: {finding.problem}.",
        meaning="The servo does not reach every angle that may be commanded; the board keeps what it has.",
        next_step=_cure(servo_map.joint, setting, finding),
    )


def _cure(joint: int, setting: ServoSetting, finding: Finding) -> str:
    again = f"measure it again: tfsat-host calibrate servo --joint {joint}"
    if finding.code != SettingsDefect.PULSE_RANGE:
        return (
            f"Look whether the horn of servo {joint} slips, or it is another servo than the others; {again}"
        )
    most_cdeg = _most_reachable_cdeg(setting)
    if most_cdeg > 0:
        return (
            f"Narrow limits_deg of joint {joint} to [0, {most_cdeg / CDEG_PER_DEG:g}] in the settings' "
            f"file and "
            f"upload it (tfsat-host upload-servos), or mount the servo's horn some teeth further and {again}"
        )
    return f"Mount the horn of servo {joint} so that 0 deg lies well within its range, and {again}"


def _most_reachable_cdeg(setting: ServoSetting) -> int:
    """The widest upper limit whose pulse a servo takes, to a whole degree below; 0 or less: there is none."""
    zero_us, ends_us = setting.zero_us, (SERVO_PULSE_MIN_US, SERVO_PULSE_MAX_US)
    room_us = zero_us - ends_us[0] if setting.reversed else ends_us[1] - zero_us
    if not ends_us[0] <= zero_us <= ends_us[1]:
        return 0
    return room_us * NS_PER_US // setting.ns_per_deg * CDEG_PER_DEG
