"""The maneuver that a command is told: two angles, or a file."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from tfsat_host.cli.options import file_name, number
from tfsat_host.errors import UsageError

if TYPE_CHECKING:
    from tfsat_host.maneuver import Limits, Maneuver, Schedule
    from tfsat_host.robot import RobotModel

WHAT_A_B_MEANS = "A B means the closed loop +A joint 1, +B joint 2, -A joint 1, -B joint 2, in degrees."


def add_maneuver_arguments(
    parser: argparse.ArgumentParser,
    *,
    default_speed: str = "170",
    nothing_done: str = "Nothing was computed.",
) -> argparse._ArgumentGroup:
    """`A B`, `--file` and `--speed`; gives the group, for what else a command wants to know of the maneuver.

    Args:
        parser: Of the command.
        default_speed: For the help.
        nothing_done: What a maneuver that is refused means for this command, one sentence.
    """
    parser.set_defaults(nothing_done=nothing_done)
    group = parser.add_argument_group("maneuver")
    group.add_argument("a_deg", metavar="A", nargs="?", type=number, help="angle of joint 1, deg, to 0.01")
    group.add_argument("b_deg", metavar="B", nargs="?", type=number, help="angle of joint 2, deg, to 0.01")
    group.add_argument(
        "--file", metavar="FILE", type=file_name, help="take the strokes from a maneuver file (TOML)"
    )
    group.add_argument(
        "--speed",
        metavar="DEG_S",
        type=number,
        help=f"average joint speed of A B, deg/s (default {default_speed})",
    )
    return group


def maneuver_from(args: argparse.Namespace, *, default_speed_deg_s: float | None = None) -> Maneuver:
    """The maneuver that the arguments name: a file or two angles, never both.

    Args:
        args: Of a parser with `add_maneuver_arguments`.
        default_speed_deg_s: Of A B without `--speed`; that of the drop experiment if None.

    Raises:
        UsageError: both, or neither.
        ManeuverError: the file cannot be understood.
    """
    from tfsat_host.maneuver import four_stroke, read_maneuver
    from tfsat_host.maneuver.maneuver import DEFAULT_SPEED_DEG_S

    if args.file is not None:
        if args.a_deg is not None or args.speed is not None:
            raise UsageError(
                what="--file was given together with angles or --speed: the file says both.",
                meaning="Nothing was done.",
                next_step=f"tfsat-host {args.command} --file {args.file}",
            )
        with _refusals(args):
            return read_maneuver(args.file)
    if args.a_deg is None or args.b_deg is None:
        raise UsageError(
            what="Two angles are needed: A of joint 1 and B of joint 2.",
            meaning="Nothing was done.",
            next_step=f"tfsat-host {args.command} 59 70   or   tfsat-host {args.command} --file maneuver.toml",
        )
    speeds = (args.speed, default_speed_deg_s, DEFAULT_SPEED_DEG_S)
    return four_stroke(
        args.a_deg, args.b_deg, speed_deg_s=next(speed for speed in speeds if speed is not None)
    )


def robots_maneuver(args: argparse.Namespace, robot: RobotModel) -> Maneuver:
    """The maneuver that the arguments name; A B without `--speed` move as fast as the robot's servos do on average.

    Raises:
        UsageError: no maneuver was named, or two.
        ManeuverError: the file cannot be understood.
    """
    rates_deg_s = [math.degrees(servo.average_rate_rad_s) for servo in robot.servos[:2]]
    return maneuver_from(args, default_speed_deg_s=round(min(rates_deg_s), 9) if rates_deg_s else None)


def schedule_from(args: argparse.Namespace, maneuver: Maneuver, limits: Limits | None = None) -> Schedule:
    """The checked schedule, by the sequencer's limits if None; an error of a maneuver from a file names the file.

    Raises:
        ManeuverError: the maneuver cannot be flown.
    """
    from tfsat_host.maneuver import SEQUENCER, ManeuverError, schedule_maneuver

    with _refusals(args):
        try:
            return schedule_maneuver(maneuver, limits or SEQUENCER)
        except ManeuverError as error:
            if args.file is None:
                raise
            raise error.in_file(str(args.file)) from error


@contextmanager
def _refusals(args: argparse.Namespace) -> Iterator[None]:
    """A maneuver that is refused, in the words of the command that was typed."""
    from tfsat_host.maneuver import Defect, ManeuverError

    try:
        yield
    except ManeuverError as error:
        error.meaning = f"{error.meaning} {args.nothing_done}"
        if error.code == Defect.FILE_UNREADABLE:
            error.next_step = (
                "Give the path of a maneuver file, "
                f"tfsat-host {args.command} --file maneuver.toml, or two angles: tfsat-host {args.command} 59 70"
            )
        raise
