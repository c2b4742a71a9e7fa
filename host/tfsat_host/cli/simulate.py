"""`tfsat-host simulate`: where a maneuver leaves the robot, and all that happens on the way."""

from __future__ import annotations

import argparse
import math
from contextlib import nullcontext
from typing import TYPE_CHECKING

from tfsat_host.cli import maneuver_argument as given
from tfsat_host.cli.usage import FORCE, INITIAL_RATE, OUTPUT, ROBOT, duration_s
from tfsat_host.errors import UsageError
from tfsat_host.maneuver import Maneuver, Schedule
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show, show_facts
from tfsat_host.quantity import record

if TYPE_CHECKING:
    from tfsat_host.dynamics import JointHistory
    from tfsat_host.robot import RobotModel

_SLOW_STEPS = 5_000  # about a second
_SLOW_TURNS = 5.0  # so many take as long


_USAGE = f"""
Compute the attitude of a free-floating robot from the motion of its joints, by conservation of angular momentum.
{given.WHAT_A_B_MEANS} docs/simulate.md explains conventions and columns.

{given.maneuver_usage(given.SERVOS_SPEED)}
--history FILE            take measured joint angles instead of strokes: a CSV file with t_s, theta1_deg, theta2_deg, …
--between {{cubic,linear}}  what lies between two samples of --history: a cubic spline or straight lines (default cubic)
robot and release:
{ROBOT}
{given.CALIBRATION}
--base BODY               the body whose attitude is computed, by name or number (default: the robot file's base)
{INITIAL_RATE}
time:
--until S      follow the robot until this time after the release (default: 2.5, or as long as the joints move)
--step S       longest step of the integration (default: as short as an error of 1e-4 deg needs)
--order {{4,6}}  order of the integration (default 6)
histories:
--out PATH     write the motion to a file .csv or .npz, or to simulation.csv in a folder
{FORCE}
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options for joint motion, robot, release and histories."""
    order = {"type": int, "default": 6}
    given.add_maneuver_options(parser, _USAGE, "Nothing was simulated.", step=duration_s, order=order)
    parser.set_defaults(between="cubic")


def run(args: argparse.Namespace, out: Output) -> int:
    """Simulates, writes the histories, shows where the robot ends."""
    from tfsat_host.dynamics.motion_files import flight_path, write_flight
    from tfsat_host.dynamics.simulation import fly
    from tfsat_host.dynamics.simulation_result import FILES, RESULT, SimulationResult, notices, tables

    rate = given.initial_rate_rad_s(args)
    robot = given.robot_from(args, out)
    base = None if args.base is None else robot.body_index(args.base)
    file = None if args.out is None else flight_path(args.out, args.history, force=args.force)
    maneuver, motion, until_s = _motion(args, robot)
    steps = 0.0 if args.step is None else 3.0 * until_s / args.step
    turns = 0.0 if rate is None else until_s * math.hypot(*rate) / math.tau
    slow = steps >= _SLOW_STEPS or turns >= _SLOW_TURNS
    with out.progress("Simulating") if slow else nullcontext():
        how = {"step_s": args.step, "order": args.order}
        simulation = fly(robot, motion, until_s=until_s, base=base, initial_rate_rad_s=rate, **how)
    doubts = notices(simulation, maneuver, step_s=args.step)
    result = SimulationResult(simulation, args.initial_rate, doubts, file, args.calibration)
    out.warn_each(result.notices)
    document = record(RESULT, result)
    if file is not None:
        write_flight(simulation.flight, file, document, force=args.force)

    def show_result() -> None:
        show_facts((*RESULT, *FILES), result, out)
        show(tables(result), out)

    out.result(document | record(FILES, result), show_result)
    return 0


def _motion(
    args: argparse.Namespace, robot: RobotModel
) -> tuple[Maneuver | None, Schedule | JointHistory, float]:
    """Return the maneuver, if there is one, the joints' motion, and the time in s at which to end."""
    from tfsat_host.dynamics.motion_files import read_history
    from tfsat_host.dynamics.simulation import arrivals_s, end_of_flight_s, robot_limits

    if args.history is not None:
        if any(option is not None for option in (args.a_deg, args.file, args.speed, args.calibration)):
            raise _refusal(
                "--history was given together with a maneuver or servos: both tell how the joints move.",
                Advice(NextStep("simulate", ("--history", str(args.history)))),
            )
        history = read_history(args.history, robot.n_joints, between=args.between)
        joints_end_s = float(history.breaks_s[-1]) if args.until is None else 0.0
        return None, history, end_of_flight_s(args.until, joints_end_s, args.step)
    if robot.n_joints == 0 and (args.a_deg is not None or args.speed is not None):
        raise _refusal(
            f"{robot.path} has no joints that a maneuver could move.",
            Advice(NextStep("simulate", ("--robot", str(args.robot), "--initial-rate", "0", "0", "10"))),
        )
    # A single rigid body flies, too, but no maneuver moves it.
    alone = robot.n_joints == 0 and args.file is None
    maneuver = Maneuver(()) if alone else given.maneuver_from(args, robot)
    schedule = given.schedule_from(args, maneuver, robot_limits(robot))
    joints_end_s = max(arrivals_s(robot, schedule), default=0.0)
    return maneuver, schedule, end_of_flight_s(args.until, joints_end_s, args.step)


def _refusal(what: str, next_step: str) -> UsageError:
    return UsageError(what=what, meaning="Nothing was done.", next_step=next_step)
