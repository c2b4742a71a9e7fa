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
    asked.add_argument("--joints", metavar="N,N", type=_joints, help="joints that may move (default: all)")
    shown = "time of all strokes together, s (default 1.5)"
    asked.add_argument("--time-limit", metavar="S", type=number, help=shown)
    shown = "average joint speed, deg/s (default: the servos')"
    asked.add_argument("--speed", metavar="DEG_S", type=number, help=shown)
    shown = "greatest displacement of each of the joints, deg"
    asked.add_argument("--limit", metavar="DEG,DEG", type=_numbers, help=shown)
    asked.add_argument("--penalty", metavar="P", type=number, help="P, deg/s^2 of overtime (default 1e11)")
    swarm = parser.add_argument_group("particle swarm")
    swarm.add_argument("--seed", metavar="N", type=seed, help="seed of its random numbers (default 1)")
    for option, default in (("particles", 48), ("iterations", 50)):
        shown, count = f"number of {option} (default {default})", whole_number(option, 1, 1_000_000)
        swarm.add_argument(f"--{option}", metavar="N", type=count, help=shown)
    for option, default_pair in (
        ("inertia", "w: 0.9,0.4"),
        ("own-best", "c1: 3.5,2.5"),
        ("best-of-all", "c2: 0.5,3.5"),
    ):
        shown = f"coefficient at first and last (default {default_pair})"
        swarm.add_argument(f"--{option}", metavar="FIRST,LAST", type=_numbers, help=shown)
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

    swarm: dict[str, Any] = {
        one: getattr(args, one) for one in ("particles", "iterations") if getattr(args, one)
    }
    for name in ("inertia", "own_best", "best_of_all"):
        if (pair := getattr(args, name)) is not None:
            swarm[name] = coefficient(name, pair)
    named = {"speed": "speed_deg_s", "time_limit": "time_limit_s", "limit": "limit_deg"}
    options = ("joints", "penalty", "seed", *named)
    return DesignSettings(
        **{named.get(one, one): getattr(args, one) for one in options if getattr(args, one) is not None},
        alternating=args.alternating,
        swarm=SwarmSettings(**swarm),
    )


def _numbers(text: str) -> tuple[float, ...]:
    """Numbers with commas between."""
    return tuple(number(part.strip()) for part in text.split(","))


def _joints(text: str) -> tuple[int, ...]:
    """Joint numbers from 1 with commas between, as indices."""
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isascii() and part.isdigit() and int(part) > 0 for part in parts):
        raise argparse.ArgumentTypeError(f"{text!r} are no joints: write their numbers, such as 1,2")
    return tuple(int(part) - 1 for part in parts)
