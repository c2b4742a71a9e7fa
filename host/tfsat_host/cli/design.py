"""`tfsat-host design`: the maneuver that turns a robot farthest in the time there is."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.design_words import Made, result_of, show
from tfsat_host.cli.options import add_output_options, file_name, number, seed
from tfsat_host.errors import DataLossError, UsageError
from tfsat_host.output_files import OutputFile, check_may_write, write_all
from tfsat_host.present.output import Output

if TYPE_CHECKING:
    from tfsat_host.maneuver import Maneuver
    from tfsat_host.plan.design import Candidate
    from tfsat_host.plan.problem import DesignSettings
    from tfsat_host.plan.swarm import Coefficient
    from tfsat_host.robot import RobotModel

_DEFAULT_FILE = Path("maneuver.toml")
_COEFFICIENT_MOST = 100.0
_MARKER = 'name = "designed: '


def configure(parser: argparse.ArgumentParser) -> None:
    """What is asked for, how it is searched, and where the maneuver goes."""
    parser.description = (
        "Design the closed loop of strokes that turns the robot farthest in the given time: the paper's particle "
        "swarm over all sequences, and the true optimum beside it. Writes the optimum as a maneuver file for "
        "upload-sequence --file. Exit code 3 if a check against the drop tower fails."
    )
    asked = parser.add_argument_group("what is asked for")
    asked.add_argument(
        "--robot",
        metavar="FILE",
        type=file_name,
        help="a robot file, or the name of a robot that tfsat brings along (default: drop_tower)",
    )
    asked.add_argument("--joints", metavar="N,N", type=_joints, help="joints that may move (default: all)")
    asked.add_argument(
        "--time-limit", metavar="S", type=number, help="time of all strokes together, s (default 1.5)"
    )
    asked.add_argument(
        "--speed", metavar="DEG_S", type=number, help="average joint speed, deg/s (default: the servos')"
    )
    asked.add_argument(
        "--limit", metavar="DEG,DEG", type=_numbers, help="greatest displacement of each of the joints, deg"
    )
    asked.add_argument("--penalty", metavar="P", type=number, help="P, deg/s^2 of overtime (default 1e11)")
    swarm = parser.add_argument_group("particle swarm")
    swarm.add_argument("--seed", metavar="N", type=seed, help="seed of its random numbers (default 1)")
    swarm.add_argument("--particles", metavar="N", type=_count, help="number of particles (default 48)")
    swarm.add_argument("--iterations", metavar="N", type=_count, help="number of iterations (default 50)")
    for option, what in (
        ("--inertia", "w: 0.9,0.4"),
        ("--own-best", "c1: 3.5,2.5"),
        ("--best-of-all", "c2: 0.5,3.5"),
    ):
        swarm.add_argument(
            option,
            metavar="FIRST,LAST",
            type=_numbers,
            help=f"coefficient at first and last (default {what})",
        )
    swarm.add_argument(
        "--alternating",
        action="store_true",
        help="optimize displacements and sequence in turns, instead of the best sequence of every particle",
    )
    result = parser.add_argument_group("result")
    result.add_argument(
        "--swarm", action="store_true", help="take the swarm's maneuver instead of the optimum"
    )
    result.add_argument(
        "--out",
        metavar="FILE",
        type=file_name,
        help=f"the maneuver file (default {_DEFAULT_FILE}); with --grid, the CSV",
    )
    result.add_argument("--force", action="store_true", help="let --out overwrite a file of somebody else")
    result.add_argument(
        "--grid",
        metavar="DEG",
        type=number,
        help="instead: the distribution of all four-stroke loops on a grid of displacements",
    )
    result.add_argument(
        "--figure", metavar="FILE", type=file_name, help="with --grid, a picture of it (PNG, PDF, SVG)"
    )
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Designs, checks against the drop tower, writes and shows."""
    from tfsat_host.robot import load_robot
    from tfsat_host.robot.path import find_robot

    if args.grid is not None:
        from tfsat_host.cli.grid import show_grid

        return show_grid(args, load_robot(find_robot(args.robot)), out)
    if args.figure is not None:
        raise UsageError(
            what="--figure was given without --grid.",
            meaning="Nothing was designed.",
            next_step="tfsat-host design --grid 5 --figure distribution.png",
        )
    path = args.out or _DEFAULT_FILE
    check_may_write(path, marker=_MARKER.encode(), force=args.force)
    robot = load_robot(find_robot(args.robot))

    from tfsat_host.plan.design import design

    with out.progress("Designing the maneuver", total=1.0) as advance:
        found = design(robot, _settings(args), advance)
    chosen = found.swarm if args.swarm else found.optimum
    flown = found.flown(chosen)
    maneuver = found.maneuver(chosen, _name(flown, robot))
    _write(path, maneuver, force=args.force)
    made = _judged(robot, maneuver, Made(flown, path, "" if args.robot is None else f" --robot {args.robot}"))
    out.result(result_of(found, made), lambda: show(found, made, out))
    return 0 if all(check.passed for check in made.checks) else DataLossError.exit_code


def _settings(args: argparse.Namespace) -> DesignSettings:
    from tfsat_host.plan.problem import DesignSettings
    from tfsat_host.plan.swarm import SwarmSettings

    paper = SwarmSettings()
    given = {
        "joints": args.joints,
        "speed_deg_s": args.speed,
        "time_limit_s": args.time_limit,
        "limit_deg": args.limit,
        "penalty": args.penalty,
    }
    return DesignSettings(
        **{name: value for name, value in given.items() if value is not None},
        alternating=args.alternating,
        swarm=SwarmSettings(
            args.particles or paper.particles,
            args.iterations or paper.iterations,
            _coefficient(args.inertia, paper.inertia, "--inertia"),
            _coefficient(args.own_best, paper.own_best, "--own-best"),
            _coefficient(args.best_of_all, paper.best_of_all, "--best-of-all"),
        ),
        seed=1 if args.seed is None else args.seed,
    )


def _coefficient(given: tuple[float, ...] | None, default: Coefficient, option: str) -> Coefficient:
    from tfsat_host.plan.swarm import Coefficient

    if given is None:
        return default
    if len(given) != 2 or not all(abs(value) <= _COEFFICIENT_MOST for value in given):
        raise UsageError(
            what=f"{option} needs two numbers up to {_COEFFICIENT_MOST:g}: at the first iteration and at the last.",
            meaning="Nothing was designed.",
            next_step=f"tfsat-host design {option} {default.first:g},{default.last:g}",
        )
    return Coefficient(*given)


def _name(chosen: Candidate, robot: RobotModel) -> str:
    from tfsat_host.plan.loops import written

    return f"designed: {written(chosen.sequence)} for {robot.name}, {chosen.reorientation_deg:.3f} deg"


def _write(path: Path, maneuver: Maneuver, *, force: bool) -> None:
    from tfsat_host.maneuver import write_maneuver

    file = OutputFile(path, _MARKER.encode(), lambda place: write_maneuver(maneuver, place))
    write_all([file], force=force)


def _judged(robot: RobotModel, maneuver: Maneuver, made: Made) -> Made:
    """What the drop robot's sequencer and the drop tower say; nothing of a robot that no sequencer commands."""
    from tfsat_host.maneuver import ManeuverError, schedule_maneuver
    from tfsat_host.maneuver.servo_speed import servo_speed_notices
    from tfsat_host.plan.envelope import EnvelopeError, envelope_of
    from tfsat_host.plan.facility import load_tower
    from tfsat_host.plan.tower_checks import check_maneuver

    if any(servo.pulses is None for servo in robot.servos):
        return made
    try:
        schedule = schedule_maneuver(maneuver)
    except ManeuverError as error:
        return replace(made, refusal=error.what)
    made = replace(made, schedule=schedule, notices=servo_speed_notices(schedule, robot.path))
    tower = load_tower()
    try:
        envelope = envelope_of(robot, schedule, until_s=tower.fall_s)
    except EnvelopeError as error:
        return replace(made, notices=(*made.notices, f"Not checked against the drop tower: {error.what}"))
    return replace(made, checks=check_maneuver(schedule, robot, tower, envelope))


def _numbers(text: str) -> tuple[float, ...]:
    """Numbers with commas between."""
    return tuple(number(part.strip()) for part in text.split(","))


def _joints(text: str) -> tuple[int, ...]:
    """Joint numbers from 1 with commas between, as indices."""
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isascii() and part.isdigit() and int(part) > 0 for part in parts):
        raise argparse.ArgumentTypeError(f"{text!r} are no joints: write their numbers, such as 1,2")
    return tuple(int(part) - 1 for part in parts)


def _count(text: str) -> int:
    """A whole number from 1."""
    if not (text.isascii() and text.isdigit() and 0 < int(text) <= 1_000_000):
        raise argparse.ArgumentTypeError(f"{text!r} is no number of them: write a whole number from 1")
    return int(text)
