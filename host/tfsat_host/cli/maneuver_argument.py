"""The maneuver that a command is given, two angles or a file; the robot that flies it; how it turns at the release."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.usage import add_options
from tfsat_host.errors import UsageError
from tfsat_host.maneuver import (
    SEQUENCER,
    Defect,
    Limits,
    Maneuver,
    ManeuverError,
    Schedule,
    four_stroke,
    read_maneuver,
    schedule_maneuver,
)
from tfsat_host.maneuver.maneuver import DEFAULT_SPEED_DEG_S
from tfsat_host.next_step import Advice, NextStep

if TYPE_CHECKING:
    from tfsat_host.arrays import FloatArray
    from tfsat_host.present.output import Output
    from tfsat_host.robot import RobotModel

WHAT_A_B_MEANS = "A B means the closed loop +A joint 1, +B joint 2, -A joint 1, -B joint 2, in degrees."
SERVOS_SPEED = "what the robot file says of its servos"
_FASTEST_DEG_S = 100_000.0
CALIBRATION = """\
--calibration FILE  certificate with the servos as measured: speed, acceleration and delay instead of those of the
                    robot file, and play (default: none)"""


def maneuver_usage(default_speed: str = "170") -> str:
    """Return the usage lines of `A B`, `--file` and `--speed`, which begin the group of maneuver options.

    `default_speed` is the default that the help states for `--speed`.
    """
    return f"""\
maneuver:
[A]            angle of joint 1, deg, to 0.01
[B]            angle of joint 2, deg, to 0.01
--file FILE    take the strokes from a maneuver file (TOML)
--speed DEG_S  average joint speed of A B, deg/s (default {default_speed})"""


def add_maneuver_options(
    parser: argparse.ArgumentParser, usage: str, nothing_done: str = "Nothing was computed.", **kinds: Any
) -> None:
    """Adds what a usage with `maneuver_usage` declares; `usage` and `kinds` as of `add_options`.

    `nothing_done` is a sentence: what a maneuver that is refused means for this command.
    """
    parser.set_defaults(nothing_done=nothing_done)
    add_options(parser, usage, a={"dest": "a_deg"}, b={"dest": "b_deg"}, **kinds)


def initial_rate_rad_s(args: argparse.Namespace) -> FloatArray | None:
    """Return the initial rate (3,) in rad/s that was given; None: no angular momentum.

    Raises:
        UsageError: this is no rate that a robot can have.
    """
    import numpy as np

    if args.initial_rate is None:
        return None
    size = math.hypot(*args.initial_rate)
    if not size <= _FASTEST_DEG_S:
        problem = f"is beyond {_FASTEST_DEG_S:g} deg/s" if math.isfinite(size) else "is no rate"
        raise UsageError(
            what=f"The initial rate {args.initial_rate} {problem}.",
            meaning="No robot turns like that. Nothing was computed.",
            next_step="Give three numbers, deg/s: --initial-rate 0 0 1.5",
        )
    return np.asarray(np.radians(args.initial_rate))


def robot_from(args: argparse.Namespace, out: Output) -> RobotModel:
    """Return the robot that was named, its servos as the calibration measured them if one was given.

    Raises RobotFileError, and CalibrationError for a certificate of another robot or without a servo's speed.
    """
    from tfsat_host.calibration.calibration_errors import CalibrationError
    from tfsat_host.calibration.certificate.file import read_calibration
    from tfsat_host.calibration.servos.dynamics_fit import with_servos
    from tfsat_host.robot import load_robot

    robot, file = load_robot(args.robot), args.calibration
    if file is None:
        return robot
    calibration = read_calibration(file)
    servos = (*calibration.servo_dynamics, *calibration.servo_maps)
    problem = "" if servos else "holds no measured servo"
    if calibration.subject.robot != robot.name:
        problem = f"is of {calibration.subject.robot}, not of {robot.name}"
    if problem:
        raise CalibrationError(
            what=f"{file} {problem}.",
            meaning=f"The servos would move as {robot.path.name} assumes. {args.nothing_done}",
            next_step=Advice(
                "To measure them: ",
                NextStep("calibrate servo", ("--log", "SD.bin", "--out", str(file))),
                "; to go by the robot file, leave --calibration out.",
            ),
        )
    measured = with_servos(robot, calibration.servo_dynamics, calibration.servo_maps)
    by_file = [
        name for name, servo in zip(robot.joint_names, measured.servos, strict=True) if None in servo.measured
    ]
    if by_file:
        out.warn(
            f"Not measured each way in {file}: speed and delay of the servo of {', '.join(by_file)}, taken from "
            f"{robot.path.name}."
        )
    no_play = [
        name
        for name, servo in zip(robot.joint_names, measured.servos, strict=True)
        if servo.stop_std_rad is None
    ]
    if no_play:
        out.warn(
            f"{file} has no servo map of {', '.join(no_play)}: strokes are taken to end where commanded."
        )
    return measured


def maneuver_from(args: argparse.Namespace, robot: RobotModel | None = None) -> Maneuver:
    """Return the maneuver that the arguments name: a file or two angles, never both.

    A B without `--speed` move at the average speed of the robot's servos; without a `robot` as in the drop
    experiment.

    Raises:
        UsageError: both, or neither.
        ManeuverError: the file cannot be understood.
    """
    if args.file is not None:
        if args.a_deg is not None or args.speed is not None:
            raise UsageError(
                what="--file was given together with angles or --speed: the file has both.",
                meaning="Nothing was done.",
                next_step=Advice(NextStep(args.command, ("--file", str(args.file)))),
            )
        with _refusals(args):
            return read_maneuver(args.file)
    if args.a_deg is None or args.b_deg is None:
        raise UsageError(
            what="Two angles are needed: A of joint 1 and B of joint 2.",
            meaning="Nothing was done.",
            next_step=Advice(_by_angles(args), ", or ", _by_file(args)),
        )
    servos = (
        [math.degrees(servo.average_rate_rad_s) for servo in robot.servos[:2]] if robot is not None else []
    )
    speed = round(min(servos, default=DEFAULT_SPEED_DEG_S), 9) if args.speed is None else args.speed
    return four_stroke(args.a_deg, args.b_deg, speed_deg_s=speed)


def schedule_from(args: argparse.Namespace, maneuver: Maneuver, limits: Limits | None = None) -> Schedule:
    """Build and check the schedule of a maneuver; None for `limits` means the sequencer's.

    An error of a maneuver from a file names the file.

    Raises:
        ManeuverError: the maneuver cannot be flown.
    """
    with _refusals(args):
        try:
            return schedule_maneuver(maneuver, limits or SEQUENCER)
        except ManeuverError as error:
            raise (error if args.file is None else error.in_file(args.file)) from None


@contextmanager
def _refusals(args: argparse.Namespace) -> Iterator[None]:
    """Reword a ManeuverError raised in the block for the command that was typed."""
    try:
        yield
    except ManeuverError as error:
        next_step = error.next_step
        if error.code == Defect.FILE_UNREADABLE:
            next_step = Advice(
                "Give the path of a maneuver file, ", _by_file(args), ", or two angles: ", _by_angles(args)
            )
        raise error.with_words(meaning=f"{error.meaning} {args.nothing_done}", next_step=next_step) from None


def _by_file(args: argparse.Namespace) -> NextStep:
    return NextStep(args.command, ("--file", "maneuver.toml"))


def _by_angles(args: argparse.Namespace) -> NextStep:
    return NextStep(args.command, ("59", "70"))
