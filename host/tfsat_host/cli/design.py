"""`tfsat-host design`: the maneuver that turns a robot farthest in the time there is."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.design_studies import show_grid, show_learning
from tfsat_host.cli.usage import OUTPUT, ROBOT, add_options, number, seed, whole_number
from tfsat_host.errors import UsageError
from tfsat_host.exit_code import ExitCode
from tfsat_host.maneuver import format_maneuver
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.output_files import SEAL, check_may_write, sealed_file, write_all
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import sentences, show_facts, show_table
from tfsat_host.quantity import Columns, Table, record

if TYPE_CHECKING:
    from tfsat_host.plan.problem import DesignSettings

_DEFAULT_FILE = Path("maneuver.toml")


_USAGE = f"""
Design the closed loop of strokes that turns the robot farthest in the given time: the paper's particle swarm over all
sequences, and the true optimum. Writes the optimum as a maneuver file for upload-sequence --file. Exit code 3 if a
check against the drop tower fails.

what is asked for:
{ROBOT}
--joints N,N     joints that may move (default: all)
--time-limit S   time of all strokes together, s (default 1.5; the paper's 59/70 takes 1.532)
--speed DEG_S    average joint speed, deg/s (default: the servos')
--limit DEG,DEG  greatest displacement of each of the joints, deg
--together       let strokes of different joints overlap, within the drop tower's limits
--robust K       the greatest mean less K standard deviations over the file's [uncertainty]
--penalty P      P, deg/s^2 of overtime (default 1e11)
particle swarm:
--seed N                  seed of its random numbers (default 1)
--particles N             how many (default 48)
--iterations N            how many (default 50)
--inertia FIRST,LAST      coefficient w at first and last (default 0.9,0.4)
--own-best FIRST,LAST     coefficient c1 (default 3.5,2.5)
--best-of-all FIRST,LAST  coefficient c2 (default 0.5,3.5)
--alternating             optimize displacements and sequence in turns, instead of the best sequence of every particle
result:
--swarm        take the swarm's maneuver instead of the optimum
--out FILE     the maneuver file (default {_DEFAULT_FILE}); with --grid, the CSV
--force        let --out overwrite a file that this command did not make
--grid DEG     instead: the distribution of all four-stroke loops on a grid of displacements
--figure FILE  with --grid, a picture of it (PNG, PDF, SVG)
--learn WHAT   instead: the maneuver, and the pair, after which a drop leaves the least uncertainty of com, masses,
               inertias, hinge-points
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of the task, of the search, and of the maneuver file."""
    pairs = dict.fromkeys(("limit", "inertia", "own_best", "best_of_all"), _numbers)
    counts = {name: whole_number(name, 1, 1_000_000) for name in ("particles", "iterations")}
    learn = {"choices": ("com", "masses", "inertias", "hinge-points")}
    add_options(parser, _USAGE, joints=_joints, seed=seed, learn=learn, **pairs, **counts)


def run(args: argparse.Namespace, out: Output) -> int:
    """Designs, checks against the drop tower, writes and shows."""
    from tfsat_host.robot import load_robot

    if args.grid is not None:
        return show_grid(args, load_robot(args.robot), out)
    if args.figure is not None:
        raise UsageError(
            what="--figure was given without --grid.",
            meaning="Nothing was designed.",
            next_step=Advice(NextStep("design", ("--grid", "5", "--figure", "distribution.png"))),
        )
    path = args.out or _DEFAULT_FILE
    if args.learn is not None:
        return show_learning(args, path, out)
    if args.together and (args.swarm or args.alternating):
        raise UsageError(
            what="--together was given with --swarm or --alternating: the swarm moves one joint at a time.",
            meaning="Nothing was designed.",
            next_step=Advice(NextStep("design", ("--together",))),
        )
    check_may_write(path, marker=SEAL, force=args.force)
    robot = load_robot(args.robot)

    from tfsat_host.plan import design_result, together_result
    from tfsat_host.plan.checked_maneuver import flight_warnings, verdict_and_next_step
    from tfsat_host.plan.maneuver_design import design

    settings, robot_option = _settings(args), () if args.robot is None else ("--robot", str(args.robot))
    with out.progress("Designing the maneuver", total=1.0) as advance:
        if args.together:
            overlapping = together_result.propose_together(robot, settings, path, advance)
            checked, cautions = overlapping.checked, flight_warnings(overlapping.checked)
            closing = verdict_and_next_step(checked, robot_option)
            shown: tuple[Columns, object, Table] = (
                together_result.TOGETHER,
                overlapping,
                together_result.stroke_table(overlapping),
            )
        else:
            proposal = design_result.propose(design(robot, settings, advance), robot, path, swarm=args.swarm)
            checked, cautions = proposal.checked, design_result.warnings(proposal)
            closing = design_result.conclusions(proposal, robot_option)
            shown = design_result.PROPOSAL, proposal, design_result.candidate_table(proposal)
    write_all([sealed_file(path, format_maneuver(checked.maneuver))], force=args.force)
    out.warn_each(() if args.json else cautions)

    def show_proposal() -> None:
        columns, row, table = shown
        show_facts(columns, row, out)
        show_table(table, out)
        sentences(closing, out)

    out.result(record(*shown[:2]), show_proposal)
    return 0 if checked.may_fly else ExitCode.DATA_LOSS


def _settings(args: argparse.Namespace) -> DesignSettings:
    from tfsat_host.plan.problem import DesignSettings, coefficient
    from tfsat_host.plan.swarm import SwarmSettings

    swarm = {"particles": args.particles, "iterations": args.iterations}
    for name in ("inertia", "own_best", "best_of_all"):
        pair = getattr(args, name)
        swarm[name] = None if pair is None else coefficient(name, pair)
    settings = {"joints": args.joints, "speed_deg_s": args.speed, "time_limit_s": args.time_limit}
    settings |= {"robust": args.robust, "limit_deg": args.limit, "penalty": args.penalty, "seed": args.seed}
    return DesignSettings(
        **_given_options(settings), alternating=args.alternating, swarm=SwarmSettings(**_given_options(swarm))
    )


def _given_options(options: dict[str, Any]) -> dict[str, Any]:
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
