"""Whether the robot may fly a maneuver's strokes: joints, angles, speed and times against the board's limits.

The board repeats the checks on what it received; here they name the cure.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from tfsat_host.config.table import shorten_value
from tfsat_host.maneuver.maneuver import Defect, Maneuver, ManeuverError
from tfsat_host.protocol.limits import (
    FALL_US,
    JOINT_ANGLE_MAX_CDEG,
    JOINT_ANGLE_MIN_CDEG,
    JOINT_COUNT,
    MAX_STROKES,
    PAUSE_MIN_US,
    SCHEDULE_GRID_US,
    SPEED_MAX_CDEG_S,
    SPEED_MIN_CDEG_S,
)
from tfsat_host.units import CDEG_PER_DEG, US_PER_S, cdeg_from_deg, deg_from_cdeg, exact


@dataclass(frozen=True, slots=True)
class Limits:
    """What a maneuver is checked against.

    Attributes:
        joint_ranges_cdeg: Least and greatest angle of each joint, 0.01 deg.
        start_cdeg: Angle of each joint at the start, 0.01 deg.
        speed_range_cdeg_s: Least and greatest joint speed, 0.01 deg/s.
        strokes_min: Fewest strokes.
        strokes_max: Most strokes; None: as many as one likes.
        pause_min_us: Earliest start of a stroke after the release.
        end_max_us: Latest end of a stroke after the release; None: whenever.
        numbering: How joints are numbered; half a sentence for errors.
    """

    joint_ranges_cdeg: tuple[tuple[int, int], ...]
    start_cdeg: tuple[int, ...]
    speed_range_cdeg_s: tuple[int, int]
    strokes_min: int
    strokes_max: int | None
    pause_min_us: int
    end_max_us: int | None
    numbering: str

    @property
    def joint_count(self) -> int:
        """Number of joints."""
        return len(self.joint_ranges_cdeg)


SEQUENCER = Limits(
    joint_ranges_cdeg=((JOINT_ANGLE_MIN_CDEG, JOINT_ANGLE_MAX_CDEG),) * JOINT_COUNT,
    start_cdeg=(0,) * JOINT_COUNT,
    speed_range_cdeg_s=(SPEED_MIN_CDEG_S, SPEED_MAX_CDEG_S),
    strokes_min=1,
    strokes_max=MAX_STROKES,
    pause_min_us=PAUSE_MIN_US,
    end_max_us=FALL_US,
    numbering="joint i joins body i and body i+1",
)
"""The numbers that the board holds, from the protocol specification."""


@dataclass(frozen=True, slots=True)
class CheckedStrokes:
    """Strokes in the board's units, each of which can be flown on its own."""

    joints: tuple[int, ...]
    angles_cdeg: tuple[int, ...]
    speed_cdeg_s: int
    notices: tuple[str, ...]


def check_strokes(maneuver: Maneuver, limits: Limits) -> CheckedStrokes:
    """Check each stroke and the speed on their own.

    Raises:
        ManeuverError: no-strokes, too-many-strokes, unknown-joint, angle-not-finite, zero-stroke,
            speed-range.
    """
    count = len(maneuver.strokes)
    if count < limits.strokes_min:
        raise ManeuverError(
            Defect.NO_STROKES,
            what="The maneuver has no strokes.",
            next_step="Give at least one stroke, such as joint = 1, angle_deg = 59.",
        )
    if limits.strokes_max is not None and count > limits.strokes_max:
        raise ManeuverError(
            Defect.TOO_MANY_STROKES,
            what=f"The maneuver has {count} strokes; at most {limits.strokes_max} are possible here.",
            next_step=f"Shorten the maneuver to {limits.strokes_max} strokes.",
        )
    notices: list[str] = []
    speed_cdeg_s = _speed_cdeg_s(maneuver.speed_deg_s, limits, notices)
    for number, stroke in enumerate(maneuver.strokes, 1):
        if not 1 <= stroke.joint <= limits.joint_count:
            joint_range = {0: "no joints", 1: "joint 1 only"}.get(
                limits.joint_count, f"joints 1 to {limits.joint_count}"
            )
            raise ManeuverError(
                Defect.UNKNOWN_JOINT,
                what=f"Stroke {number} moves joint {shorten_value(stroke.joint)}; the robot has {joint_range}.",
                next_step=f"Correct the joint's number; {limits.numbering}.",
                stroke=number,
            )
    angles = tuple(_angle_cdeg(n, s.angle_deg, notices) for n, s in enumerate(maneuver.strokes, 1))
    joints = tuple(stroke.joint for stroke in maneuver.strokes)
    return CheckedStrokes(joints, angles, speed_cdeg_s, tuple(notices))


def _speed_cdeg_s(speed_deg_s: float, limits: Limits, notices: list[str]) -> int:
    speed_deg_s = _readable(speed_deg_s)
    speed_min, speed_max = map(deg_from_cdeg, limits.speed_range_cdeg_s)
    if not math.isfinite(speed_deg_s) or not speed_min <= speed_deg_s <= speed_max:
        raise ManeuverError(
            Defect.SPEED_RANGE,
            what=f"The joint speed is {speed_deg_s} deg/s; it must be {speed_min:g} to {speed_max:g} deg/s.",
            next_step="Give the average speed that the servos reach; the drop experiment used 170 deg/s.",
        )
    speed_cdeg_s = cdeg_from_deg(speed_deg_s)
    # Compare decimals exactly: only a speed with more than two of them was rounded.
    if speed_cdeg_s != exact(speed_deg_s) * CDEG_PER_DEG:
        notices.append(
            f"The speed was rounded from {speed_deg_s} to {speed_cdeg_s / CDEG_PER_DEG:.2f} deg/s."
        )
    return speed_cdeg_s


def _angle_cdeg(number: int, angle_deg: float, notices: list[str]) -> int:
    if not math.isfinite(angle_deg):
        raise ManeuverError(
            Defect.ANGLE_NOT_FINITE,
            what=f"The angle of stroke {number} is {angle_deg}, which is not an angle.",
            next_step="Give degrees as a number, such as 59 or 58.75.",
            stroke=number,
        )
    angle_deg = _readable(angle_deg)
    angle_cdeg = cdeg_from_deg(angle_deg)
    # What counts is the angle that the board would get, after rounding.
    if angle_cdeg == 0:
        raise ManeuverError(
            Defect.ZERO_STROKE,
            what=f"The angle of stroke {number} is {angle_deg} deg: it would move nothing.",
            next_step="Leave the stroke out, or give an angle of at least 0.01 deg.",
            stroke=number,
        )
    if angle_cdeg != exact(angle_deg) * CDEG_PER_DEG:
        notices.append(
            f"The angle of stroke {number} was rounded from {angle_deg} to "
            f"{angle_cdeg / CDEG_PER_DEG:.2f} deg: the sequencer resolves 0.01 deg."
        )
    return angle_cdeg


def _readable(number_deg: float) -> float:
    """Without binary noise: 29.999999999999996 is 30 that came by way of radians."""
    return round(number_deg, 9)


def check_joint_angles(joints: Sequence[int], angles_cdeg: Sequence[int], limits: Limits) -> list[str]:
    """Follows each joint from the start pose; notes joints that do not come back to it.

    Raises:
        ManeuverError: joint-range.
    """
    # Integers: sums are exact, and a loop is closed or it is not.
    pose_cdeg = list(limits.start_cdeg)
    for number, (joint, angle_cdeg) in enumerate(zip(joints, angles_cdeg, strict=True), 1):
        pose_cdeg[joint - 1] += angle_cdeg
        low_cdeg, high_cdeg = limits.joint_ranges_cdeg[joint - 1]
        if not low_cdeg <= pose_cdeg[joint - 1] <= high_cdeg:
            low, high = deg_from_cdeg(low_cdeg), deg_from_cdeg(high_cdeg)
            raise ManeuverError(
                Defect.JOINT_RANGE,
                what=f"Stroke {number} would take joint {joint} to "
                f"{_deg(pose_cdeg[joint - 1])} deg; it moves from {low:g} to {high:g} deg.",
                meaning="The body would hit the frame.",
                next_step=f"Choose smaller angles: {_start_words(limits, joint)}.",
                stroke=number,
            )
    return [
        f"Joint {joint} ends at {end / CDEG_PER_DEG:.2f} deg, not at {deg_from_cdeg(start):g}: "
        "the maneuver is not a closed loop."
        for joint, (start, end) in enumerate(zip(limits.start_cdeg, pose_cdeg, strict=True), 1)
        if end != start
    ]


def _start_words(limits: Limits, joint: int) -> str:
    if not any(limits.start_cdeg):
        return "every maneuver starts with all joints at 0 deg"
    return f"a maneuver of this robot starts with joint {joint} at {deg_from_cdeg(limits.start_cdeg[joint - 1]):g} deg"


def check_distances(starts_us: Sequence[Fraction]) -> None:
    """Check that strokes come in the order of their times, and begin together or 10 ms apart.

    Raises:
        ManeuverError: starts-too-close.
    """
    for number, (before_us, start_us) in enumerate(pairwise(starts_us), 2):
        if start_us == before_us or start_us >= before_us + SCHEDULE_GRID_US:
            continue
        raise ManeuverError(
            Defect.STARTS_TOO_CLOSE,
            what=f"Stroke {number} starts at {_s(start_us)} s, stroke {number - 1} at {_s(before_us)} s.",
            meaning="The sequencer takes strokes in the order of their times, at the same time or 10 ms apart.",
            next_step="Sort the strokes by t_s; let two begin at the same time or at least 10 ms apart.",
            stroke=number,
        )


def check_timing(
    joints: Sequence[int], starts_us: Sequence[int], ends_us: Sequence[Fraction], limits: Limits
) -> None:
    """Check the timing of one or more strokes against the pause, one another and the end of the fall.

    Raises:
        ManeuverError: before-pause, overlap, outlasts-fall.
    """
    before_of: dict[int, int] = {}
    for number, (joint, start_us, end_us) in enumerate(zip(joints, starts_us, ends_us, strict=True), 1):
        if number == 1:
            _check_pause(start_us, limits)
        # Strokes of different joints may overlap, those of one may not.
        before = before_of.get(joint)
        if before is not None and start_us < ends_us[before - 1]:
            raise ManeuverError(
                Defect.OVERLAP,
                what=f"Stroke {number} of joint {joint} starts at {_s(start_us)} s, before the joint's stroke "
                f"{before} ends at {_s(ends_us[before - 1])} s.",
                meaning="A joint cannot do two strokes at once.",
                next_step="Move the joint's strokes apart, or leave out every t_s: the schedule rule then sets them.",
                stroke=number,
            )
        before_of[joint] = number
        if limits.end_max_us is not None and end_us > limits.end_max_us:
            raise ManeuverError(
                Defect.OUTLASTS_FALL,
                # To a millisecond, up: nobody plans with less, and the end stays beyond the limit.
                what=f"Stroke {number} would end {_s(1000 * math.ceil(end_us / 1000))} s after release; "
                f"the fall ends at {_s(limits.end_max_us)} s.",
                meaning="The robot would land while it still moves.",
                next_step="Use smaller angles, fewer strokes, earlier starts or a higher speed.",
                stroke=number,
            )


def _check_pause(start_us: int, limits: Limits) -> None:
    if start_us < limits.pause_min_us:
        raise ManeuverError(
            Defect.BEFORE_PAUSE,
            what=f"The first stroke starts {_s(start_us)} s after release; "
            f"it must not start before {_s(limits.pause_min_us)} s.",
            meaning="The robot would strike the release mechanism.",
            next_step=f"Start at {_s(limits.pause_min_us)} s or later.",
            stroke=1,
        )


_READABLE = 1_000_000
"""Numbers beyond this are shown as powers of ten."""


def _deg(angle_cdeg: int) -> str:
    """Degrees with two decimals."""
    angle_deg = angle_cdeg / CDEG_PER_DEG
    return f"{angle_deg:.2f}" if abs(angle_deg) < _READABLE else f"{angle_deg:g}"


def _s(t_us: Fraction | int) -> str:
    """Seconds with at least two decimals, rounded up to a microsecond."""
    rounded_us = math.ceil(t_us)
    if abs(rounded_us) >= _READABLE * US_PER_S:
        return f"{rounded_us / US_PER_S:g}"
    seconds, decimals = divmod(rounded_us, US_PER_S)
    return f"{seconds}.{f'{decimals:06}'.rstrip('0'):0<2}"
