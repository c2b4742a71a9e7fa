"""`tfsat-host simulate`: where a maneuver leaves the robot, and all that happens on the way."""

from __future__ import annotations

import argparse
import math
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING

from tfsat_host.cli.initial_rate import add_initial_rate_option, initial_rate_rad_s
from tfsat_host.cli.maneuver_argument import (
    WHAT_A_B_MEANS,
    add_maneuver_arguments,
    robots_maneuver,
    schedule_from,
)
from tfsat_host.cli.options import add_output_options, file_name, number
from tfsat_host.errors import UsageError
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.dynamics.flying import Simulation
    from tfsat_host.maneuver import Schedule
    from tfsat_host.robot import RobotModel

_SLOW_STEPS = 5_000  # about a second
_SLOW_TURNS = 5.0  # so many take as long
_STEPS_MAX = 200_000


def configure(parser: argparse.ArgumentParser) -> None:
    """The motion of the joints, the robot, the release, and where histories go."""
    parser.description = (
        "Compute the attitude of a free-floating robot from the motion of its joints, by conservation of angular "
        f"momentum. {WHAT_A_B_MEANS} docs/simulate.md explains conventions and columns."
    )
    motion = add_maneuver_arguments(
        parser,
        default_speed="what the robot file says of its servos",
        nothing_done="Nothing was simulated.",
    )
    motion.add_argument(
        "--history",
        metavar="FILE",
        type=file_name,
        help="take measured joint angles instead of strokes: a CSV file with t_s, theta1_deg, theta2_deg, …",
    )
    motion.add_argument(
        "--between",
        choices=("cubic", "linear"),
        default="cubic",
        help="what lies between two samples of --history: a cubic spline or straight lines (default cubic)",
    )
    robot = parser.add_argument_group("robot and release")
    robot.add_argument(
        "--robot",
        metavar="FILE",
        type=file_name,
        help="a robot file, or the name of a robot that tfsat brings along (default: drop_tower)",
    )
    robot.add_argument(
        "--base",
        metavar="BODY",
        help="the body whose attitude is computed, by name or number (default: the robot file's base)",
    )
    add_initial_rate_option(robot)
    _add_accuracy_options(parser)
    files = parser.add_argument_group("histories")
    files.add_argument(
        "--out",
        metavar="PATH",
        type=file_name,
        help="write the motion to a file .csv or .npz, or to simulation.csv in a folder",
    )
    files.add_argument("--force", action="store_true", help="overwrite a file that this command did not make")
    add_output_options(parser)


def _add_accuracy_options(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("time")
    group.add_argument(
        "--until",
        metavar="S",
        type=number,
        help="follow the robot until this time after the release (default: 2.5, or as long as the joints move)",
    )
    group.add_argument(
        "--step",
        metavar="S",
        type=number,
        help="longest step of the integration (default: as short as an error of 1e-4 deg needs)",
    )
    group.add_argument(
        "--order", type=int, choices=(4, 6), default=6, help="order of the integration (default 6)"
    )


def run(args: argparse.Namespace, out: Output) -> int:
    """Simulates, writes the histories, shows where the robot ends."""
    from tfsat_host.cli.simulate_files import output_file
    from tfsat_host.cli.simulate_notices import error_notices
    from tfsat_host.cli.simulate_words import result_of, show
    from tfsat_host.robot import load_robot

    _check_arguments(args)
    robot = load_robot(args.robot)
    _check_robot(args, robot)
    base = _base_index(robot, args.base)
    file = None if args.out is None else output_file(args.out, args.history, force=args.force)
    notices: list[str] = []
    schedule: Schedule | None
    if args.history is None:
        schedule = _schedule(args, robot, notices)
        simulation = _fly_schedule(args, robot, base, schedule, notices, out)
    else:
        schedule = None
        simulation = _fly_history(args, robot, base, notices, out)
    if not simulation.is_closed:
        notices.append(
            "The joints do not end where they started, so the final rotation depends on the base body: this is that "
            f"of {robot.body_names[base]}."
        )
    notices += error_notices(args, simulation)
    result = result_of(robot, simulation, schedule, args.initial_rate) | {"notices": notices}
    for notice in notices:
        out.warn(notice)
    if file is not None:
        file.write(simulation.flight, result)
    result["files"] = {} if file is None else {file.format: str(file.path)}
    out.result(result, lambda: show(result, out))
    return 0


def _schedule(args: argparse.Namespace, robot: RobotModel, notices: list[str]) -> Schedule:
    """The strokes by the robot's own limits; what the sequencer would say of them is no more than a notice."""
    from tfsat_host.dynamics.flying import robot_limits
    from tfsat_host.maneuver import Maneuver, ManeuverError, schedule_maneuver
    from tfsat_host.maneuver.servo_speed import servo_speed_notices

    alone = robot.n_joints == 0 and args.file is None
    maneuver = Maneuver(()) if alone else robots_maneuver(args, robot)
    schedule = schedule_from(args, maneuver, robot_limits(robot))
    notices += schedule.notices
    if not schedule.strokes:
        return schedule
    notices += servo_speed_notices(schedule, robot.path)
    if all(servo.pulses is not None for servo in robot.servos):  # somebody commands them: the sequencer
        try:
            schedule_maneuver(maneuver)
        except ManeuverError as error:
            notices.append(f"The sequencer would refuse this maneuver: {error.what}")
    return schedule


def _fly_schedule(
    args: argparse.Namespace,
    robot: RobotModel,
    base: int,
    schedule: Schedule,
    notices: list[str],
    out: Output,
) -> Simulation:
    from tfsat_host.cli.simulate_notices import late_notices
    from tfsat_host.dynamics.flying import arrivals_s, fly_schedule

    arrivals = arrivals_s(robot, schedule)
    until_s = _until_s(args, max(arrivals, default=0.0))
    with _progress(args, until_s, 4 * len(schedule.strokes), out):
        simulation = fly_schedule(
            robot,
            schedule,
            until_s=until_s,
            base=base,
            initial_rate_rad_s=initial_rate_rad_s(args),
            step_s=args.step,
            order=args.order,
        )
    notices += late_notices(robot, schedule, simulation)
    return simulation


def _fly_history(
    args: argparse.Namespace, robot: RobotModel, base: int, notices: list[str], out: Output
) -> Simulation:
    from tfsat_host.cli.simulate_notices import history_notices
    from tfsat_host.dynamics.flying import fly_history
    from tfsat_host.dynamics.history_file import read_history

    history = read_history(args.history, robot.n_joints, between=args.between)
    notices += history_notices(robot, history)
    until_s = _until_s(args, float(history.breaks_s[-1]) if args.until is None else 0.0)
    with _progress(args, until_s, len(history.breaks_s), out):
        return fly_history(
            robot,
            history,
            until_s=until_s,
            base=base,
            initial_rate_rad_s=initial_rate_rad_s(args),
            step_s=args.step,
            order=args.order,
        )


def _check_arguments(args: argparse.Namespace) -> None:
    maneuver = (args.a_deg, args.file, args.speed)
    if args.history is not None and any(given is not None for given in maneuver):
        raise UsageError(
            what="--history was given together with a maneuver: both say how the joints move.",
            meaning="Nothing was done.",
            next_step=f"tfsat-host simulate --history {args.history}",
        )
    initial_rate_rad_s(args)
    if args.step is not None and not (math.isfinite(args.step) and args.step > 0.0):
        raise UsageError(
            what=f"A step of {args.step:g} s leads nowhere.",
            meaning="Nothing was done.",
            next_step="Give seconds above zero: --step 0.01",
        )


def _check_robot(args: argparse.Namespace, robot: RobotModel) -> None:
    """A single rigid body flies, too, but no maneuver moves it."""
    if robot.n_joints == 0 and (args.a_deg is not None or args.speed is not None):
        raise UsageError(
            what=f"{robot.path} has no joints that a maneuver could move.",
            meaning="Nothing was done.",
            next_step=f"tfsat-host simulate --robot {args.robot} --initial-rate 0 0 10",
        )


def _base_index(robot: RobotModel, body: str | None) -> int:
    names = robot.body_names
    if body is None:
        return robot.base
    if body in names:
        return names.index(body)
    if body.isascii() and body.isdigit() and 1 <= int(body) <= len(names):
        return int(body) - 1
    raise UsageError(
        what=f"{robot.path} has no body {body!r}.",
        meaning="Nothing was done.",
        next_step=f"Name one of its bodies ({', '.join(names)}) or a number from 1 to {len(names)}.",
    )


def _until_s(args: argparse.Namespace, joints_end_s: float) -> float:
    """The end of the flight: as asked, else the end of the fall, or of the joints' motion if that is later."""
    from tfsat_host.protocol.limits import FALL_US
    from tfsat_host.units import s_from_us

    until_s = float(max(s_from_us(FALL_US), joints_end_s) if args.until is None else args.until)
    if not (math.isfinite(until_s) and until_s > 0.0 and until_s >= joints_end_s):
        raise UsageError(
            what=f"--until {until_s:g} ends before the joints have come to rest, {joints_end_s:g} s after release.",
            meaning="Nothing was done.",
            next_step="Give a later time, or leave --until out.",
        )
    if args.step is not None and until_s / args.step > _STEPS_MAX:
        raise UsageError(
            what=f"{until_s:g} s in steps of {args.step:g} s are more than {_STEPS_MAX} steps.",
            meaning="Nothing was done: it would take very long and much memory.",
            next_step="Give a longer --step, or leave it out.",
        )
    return until_s


def _progress(
    args: argparse.Namespace, until_s: float, breaks: int, out: Output
) -> AbstractContextManager[object]:
    """Shows that work is going on where it takes longer than a moment."""
    steps = breaks + (0.0 if args.step is None else 3.0 * until_s / args.step)
    turns = 0.0 if args.initial_rate is None else until_s * math.hypot(*args.initial_rate) / 360.0
    if steps < _SLOW_STEPS and turns < _SLOW_TURNS:
        return nullcontext()
    return out.progress("Simulating")
