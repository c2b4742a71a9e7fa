"""When each stroke of a maneuver starts.

The rule: the first stroke starts after the pause; a stroke of α degrees takes |α| / speed; the next
starts at the previous start plus that, rounded up to 10 ms. With 59/70 at 170 deg/s this gives the
paper's experiment sequence: 0.70, 1.05, 1.47, 1.82 s, finished at 2.23 s.

All arithmetic is on integers and fractions: a time that is an exact multiple of 10 ms stays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from tfsat_host.config import Table, read_config
from tfsat_host.maneuver.maneuver import Defect, Maneuver, ManeuverError
from tfsat_host.maneuver.stroke_checks import (
    SEQUENCER,
    CheckedStrokes,
    Limits,
    check_distances,
    check_joint_angles,
    check_strokes,
    check_timing,
)
from tfsat_host.protocol.limits import SCHEDULE_GRID_US
from tfsat_host.quantity import Column, Columns
from tfsat_host.robot import RobotFileError, default_robot_path
from tfsat_host.robot.path import ROBOT_FILE
from tfsat_host.units import US_PER_S, deg_from_cdeg, exact, round_up, s_from_us


@dataclass(frozen=True, slots=True)
class TimedStroke:
    """A stroke as the board gets it.

    Attributes:
        t_us: Start, microseconds after release.
        joint: 1 to 3.
        angle_cdeg: Change of the joint angle, 0.01 deg.
        end_us: When the joint has arrived, at the maneuver's average speed; rounded up.
    """

    t_us: int
    joint: int
    angle_cdeg: int
    end_us: int

    @property
    def t_s(self) -> float:
        """Start, seconds after release."""
        return s_from_us(self.t_us)

    @property
    def angle_deg(self) -> float:
        """Change of the joint angle, degrees."""
        return deg_from_cdeg(self.angle_cdeg)


@dataclass(frozen=True, slots=True)
class Schedule:
    """A maneuver that was checked whole, with the time of each stroke.

    Attributes:
        strokes: In the order of their times.
        speed_cdeg_s: Average joint speed, 0.01 deg/s.
        end_us: When the last stroke ends, rounded up to a microsecond; 0 without strokes.
        notices: What was rounded or looks unintended; one sentence each, to be shown to a person.
    """

    strokes: tuple[TimedStroke, ...]
    speed_cdeg_s: int
    end_us: int
    notices: tuple[str, ...] = ()

    @property
    def speed_deg_s(self) -> float:
        """Average joint speed, deg/s."""
        return deg_from_cdeg(self.speed_cdeg_s)

    @property
    def end_s(self) -> float:
        """When the last stroke ends, to the nearest 10 ms as in the paper's table; `end_us` is exact."""
        return round(Fraction(self.end_us, US_PER_S) * 100) / 100

    @property
    def moving_at_once(self) -> int:
        """Joints that move at the same time at the most."""
        return max(count_moving(self.strokes), default=0)

    @property
    def moving_s(self) -> float:
        """Time in which at least one joint moves, at the average speed."""
        moving_us, until_us = 0.0, 0.0
        for stroke in self.strokes:
            # Not `end_us`, which is rounded up.
            end_us = stroke.t_us + float(_duration_us(stroke.angle_cdeg, self.speed_cdeg_s))
            moving_us += max(0.0, end_us - max(until_us, stroke.t_us))
            until_us = max(until_us, end_us)
        return moving_us / US_PER_S

    def is_same_motion(self, other: Schedule) -> bool:
        """Return whether both command the same strokes at the same times and speed.

        The comparison is exact to the last digit that a board stores.
        """
        return self.speed_cdeg_s == other.speed_cdeg_s and self.strokes == other.strokes


def count_moving(strokes: Sequence[TimedStroke]) -> tuple[int, ...]:
    """Joints that move when each stroke has begun, its own among them."""
    # One joint's strokes do not overlap: each stroke that is under way is of another joint.
    return tuple(
        1 + sum(before.end_us > stroke.t_us for before in strokes[:index])
        for index, stroke in enumerate(strokes)
    )


STROKES: Columns = (
    Column("t_s", "start", form=".2f"),
    Column("joint", "joint"),
    Column("angle_deg", "turns by", form="+.2f"),
)
"""Of a schedule's `strokes`."""


def schedule_maneuver(maneuver: Maneuver, limits: Limits = SEQUENCER) -> Schedule:
    """Checks the maneuver whole and gives each stroke its time.

    With other limits than the sequencer's the schedule is for a study: it may not be fit for an upload.

    Angles are rounded to 0.01 deg and times up to 10 ms; each rounding that changes something is a
    notice of the schedule.

    Raises:
        ManeuverError: the maneuver cannot be flown; `code` names the defect.
    """
    checked = check_strokes(maneuver, limits)
    notices = list(checked.notices)
    notices += check_joint_angles(checked.joints, checked.angles_cdeg, limits)
    # Only a study permits this: the sequencer demands a stroke.
    if not maneuver.strokes:
        return Schedule((), checked.speed_cdeg_s, 0, tuple(notices))
    starts_us = _starts_us(maneuver, checked, limits, notices)
    # Ends remain exact fractions while they are compared; only what is stored is rounded up.
    ends_us = [
        t_us + _duration_us(angle_cdeg, checked.speed_cdeg_s)
        for t_us, angle_cdeg in zip(starts_us, checked.angles_cdeg, strict=True)
    ]
    check_timing(checked.joints, starts_us, ends_us, limits)
    strokes = tuple(
        TimedStroke(t_us, joint, angle_cdeg, math.ceil(end_us))
        for t_us, joint, angle_cdeg, end_us in zip(
            starts_us, checked.joints, checked.angles_cdeg, ends_us, strict=True
        )
    )
    end_us = max(stroke.end_us for stroke in strokes)
    return Schedule(strokes, checked.speed_cdeg_s, end_us, tuple(notices))


def _duration_us(angle_cdeg: int, speed_cdeg_s: int) -> Fraction:
    return Fraction(abs(angle_cdeg) * US_PER_S, speed_cdeg_s)


def _starts_us(maneuver: Maneuver, checked: CheckedStrokes, limits: Limits, notices: list[str]) -> list[int]:
    """Start times on the 10 ms grid: those that were given, or those of the rule."""
    given_times_s = [stroke.t_s for stroke in maneuver.strokes if stroke.t_s is not None]
    if not given_times_s:
        t_us = _on_grid(maneuver.pause_s, "The pause", None, limits, notices)
        starts_us = []
        # The rule: a stroke starts when the one before has ended, at the next point of the grid.
        for angle_cdeg in checked.angles_cdeg:
            starts_us.append(t_us)
            t_us = round_up(t_us + _duration_us(angle_cdeg, checked.speed_cdeg_s), SCHEDULE_GRID_US)
        return starts_us
    if len(given_times_s) != len(maneuver.strokes):
        number = next(n for n, stroke in enumerate(maneuver.strokes, 1) if stroke.t_s is None)
        raise ManeuverError(
            Defect.TIMES_INCOMPLETE,
            what=f"Stroke {number} has no time, but other strokes do.",
            next_step="Give t_s for every stroke, or for none: then the schedule rule sets all times.",
            stroke=number,
        )
    starts_us = [
        _on_grid(t_s, f"The time of stroke {n}", n, limits, notices) for n, t_s in enumerate(given_times_s, 1)
    ]
    # As they were given: what is 3 ms apart must not become 10 ms by rounding.
    check_distances([exact(t_s) * US_PER_S for t_s in given_times_s])
    return starts_us


def _on_grid(t_s: float, subject: str, number: int | None, limits: Limits, notices: list[str]) -> int:
    """Microseconds, rounded up to the grid with a notice."""
    if not math.isfinite(t_s):
        raise ManeuverError(
            Defect.TIME_NOT_FINITE,
            what=f"{subject} is {t_s}, which is not a time.",
            next_step=f"Give seconds after release, at least {limits.pause_min_us / US_PER_S:.2f}.",
            stroke=number,
        )
    asked_us = exact(t_s) * US_PER_S
    # Up, never down: no stroke starts before the time that was asked for.
    t_us = round_up(asked_us, SCHEDULE_GRID_US)
    if t_us != asked_us:
        notices.append(
            f"{subject} was rounded up from {t_s} s to {s_from_us(t_us):.2f} s: "
            f"strokes start on a grid of {SCHEDULE_GRID_US // 1000} ms."
        )
    return t_us


def servo_speed_notices(schedule: Schedule, robot_file: Path | None = None) -> tuple[str, ...]:
    """Return a notice if the speed exceeds the servo rates of the moved joints in the robot file.

    Only the servo rates are read from the file, so that an upload does not wait for numpy.
    """
    path = default_robot_path() if robot_file is None else robot_file
    moved = sorted({stroke.joint for stroke in schedule.strokes})
    joints: list[Table] = []
    try:
        joints = read_config(path, ROBOT_FILE).tables("joint")
        servos = [joints[joint - 1].table("servo") for joint in moved]
        # The slowest servo among those that move counts.
        average = min(servo.number("average_rate_deg_s") for servo in servos)
        greatest = min(servo.number("max_rate_deg_s") for servo in servos)
    # The maneuver is sound without this comparison: an unreadable robot file is a notice.
    except RobotFileError as error:
        return (f"The speed was not compared with the servos. {error.what}",)
    except IndexError:
        return (f"The speed was not compared with the servos: {path} has {len(joints)} joints.",)
    speed = schedule.speed_deg_s
    if speed <= average:
        return ()
    if speed > greatest:
        above = f"above the greatest rate of the servos, {greatest:g} deg/s"
    else:
        above = f"above the average rate of the servos, {average:g} deg/s ({greatest:g} at most)"
    return (
        f"The speed of {speed:g} deg/s is {above}, by {path.name}: joints will not be where the schedule "
        "assumes when the next stroke starts, and may turn back before they reach their angles. "
        f"Rehearse it, or plan with {average:g} deg/s or less.",
    )
