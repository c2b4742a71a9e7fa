"""`tfsat-host design`: the maneuver that turns a robot farthest in the time there is."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.maneuver_argument import add_robot_option
from tfsat_host.cli.options import add_output_options, file_name, number, seed, whole_number
from tfsat_host.errors import DataLossError, UsageError
from tfsat_host.output_files import OutputFile, check_may_write, write_all
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show

if TYPE_CHECKING:
    from tfsat_host.plan.problem import DesignSettings

_DEFAULT_FILE = Path("maneuver.toml")
_MARKER = b'name = "designed: '


def configure(parser: argparse.ArgumentParser) -> None:
    """What is asked for, how it is searched, and where the maneuver goes."""
    parser.description = (
        "Design the closed loop of strokes that turns the robot farthest in the given time: the paper's particle "
        "swarm over all sequences, and the true optimum. Writes the optimum as a maneuver file for "
        "upload-sequence --file. Exit code 3 if a check against the drop tower fails."
    )
    asked = parser.add_argument_group("what is asked for")
    add_robot_option(asked)
    swarm = parser.add_argument_group("particle swarm")
    swarm.add_argument("--seed", metavar="N", type=seed, help="seed of its random numbers (default 1)")
    for group, option, metavar, kind, shown in (
        (asked, "joints", "N,N", _joints, "joints that may move (default: all)"),
        (asked, "time-limit", "S", number, "time of all strokes together, s (default 1.5)"),
        (asked, "speed", "DEG_S", number, "average joint speed, deg/s (default: the servos')"),
        (asked, "limit", "DEG,DEG", _numbers, "greatest displacement of each of the joints, deg"),
        (asked, "penalty", "P", number, "P, deg/s^2 of overtime (default 1e11)"),
        (swarm, "particles", "N", whole_number("particles", 1, 1_000_000), "how many (default 48)"),
        (swarm, "iterations", "N", whole_number("iterations", 1, 1_000_000), "how many (default 50)"),
        (swarm, "inertia", "FIRST,LAST", _numbers, "coefficient w at first and last (default 0.9,0.4)"),
        (swarm, "own-best", "FIRST,LAST", _numbers, "coefficient c1 (default 3.5,2.5)"),
        (swarm, "best-of-all", "FIRST,LAST", _numbers, "coefficient c2 (default 0.5,3.5)"),
    ):
        group.add_argument(f"--{option}", metavar=metavar, type=kind, help=shown)
    shown = "optimize displacements and sequence in turns, instead of the best sequence of every particle"
    swarm.add_argument("--alternating", action="store_true", help=shown)
    result = parser.add_argument_group("result")
    shown = "take the swarm's maneuver instead of the optimum"
    result.add_argument("--swarm", action="store_true", help=shown)
    shown = f"the maneuver file (default {_DEFAULT_FILE}); with --grid, the CSV"
    result.add_argument("--out", metavar="FILE", type=file_name, help=shown)
    result.add_argument(
        "--force", action="store_true", help="let --out overwrite a file that this command did not make"
    )
    shown = "instead: the distribution of all four-stroke loops on a grid of displacements"
    result.add_argument("--grid", metavar="DEG", type=number, help=shown)
    shown = "with --grid, a picture of it (PNG, PDF, SVG)"
    result.add_argument("--figure", metavar="FILE", type=file_name, help=shown)
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Designs, checks against the drop tower, writes and shows."""
    from tfsat_host.maneuver import write_maneuver
    from tfsat_host.robot import load_robot

    if args.grid is not None:
        from tfsat_host.cli.grid import show_grid

        return show_grid(args, load_robot(args.robot), out)
    if args.figure is not None:
        raise UsageError(
            what="--figure was given without --grid.",
            meaning="Nothing was designed.",
            next_step="tfsat-host design --grid 5 --figure distribution.png",
        )
    path = args.out or _DEFAULT_FILE
    check_may_write(path, marker=_MARKER, force=args.force)
    robot = load_robot(args.robot)

    from tfsat_host.plan.design import design
    from tfsat_host.plan.design_result import document, lines, propose, warnings

    with out.progress("Designing the maneuver", total=1.0) as advance:
        found = design(robot, _settings(args), advance)
    made = propose(found, robot, swarm=args.swarm)
    file = OutputFile(path, _MARKER, lambda place: write_maneuver(made.maneuver, place))
    write_all([file], force=args.force)
    option = "" if args.robot is None else f" --robot {args.robot}"
    for warning in () if args.json else warnings(found, made):
        out.warn(warning)
    out.result(document(found, made, path), lambda: show(lines(found, made, path, option), out))
    return DataLossError.exit_code if made.failed else 0


def _settings(args: argparse.Namespace) -> DesignSettings:
    from tfsat_host.plan.problem import DesignSettings, coefficient
    from tfsat_host.plan.swarm import SwarmSettings

    swarm = {"particles": args.particles, "iterations": args.iterations}
    for name in ("inertia", "own_best", "best_of_all"):
        pair = getattr(args, name)
        swarm[name] = None if pair is None else coefficient(name, pair)
    asked = {"joints": args.joints, "speed_deg_s": args.speed, "time_limit_s": args.time_limit}
    asked |= {"limit_deg": args.limit, "penalty": args.penalty, "seed": args.seed}
    return DesignSettings(**_given(asked), alternating=args.alternating, swarm=SwarmSettings(**_given(swarm)))


def _given(options: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


def _numbers(text: str) -> tuple[float, ...]:
    """Numbers with commas between."""
    return tuple(number(part.strip()) for part in text.split(","))


def _joints(text: str) -> tuple[int, ...]:
    """Joint numbers from 1 with commas between, as indices."""
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isascii() and part.isdigit() and int(part) > 0 for part in parts):
        raise argparse.ArgumentTypeError(f"{text!r} are no joints: write their numbers, such as 1,2")
    return tuple(int(part) - 1 for part in parts)
