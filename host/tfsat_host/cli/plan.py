"""`tfsat-host plan`: a target attitude, approached by motion primitives with feedback after each."""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.usage import OUTPUT, add_options, number, seed, whole_number
from tfsat_host.errors import UsageError
from tfsat_host.exit_code import ExitCode
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.output_files import OutputFile, check_may_write, write_all
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import sentences, show_facts, show_table
from tfsat_host.quantity import record

if TYPE_CHECKING:
    from tfsat_host.plan.orbit.orbit_result import OrbitResult

_MARKER = b'"made_by": "tfsat-host plan"'
_HISTORY_MARKER = b"_deg,primitive"  # the end of its line of column names


_USAGE = f"""
Chain closed loops of the joints to turn the robot to a target attitude, with a measurement after each. Exit code 3 if
the error at the end is above the tolerance.

what is asked for:
! --target z:DEG               z-y-x Euler angles of the attitude, such as z:90 or x:30,y:-20,z:90: about z first, then
                               about the new y, then about the newest x, in whatever order they are written
! --target-quaternion X Y Z W  the same as a quaternion, scalar last, from body to inertial axes
--robot FILE                   a robot file, or the name of a robot that tfsat brings along (default: cubesat_3u, for
                               orbit; of all other commands: drop_tower)
--tolerance DEG                error that may be left (default 1)
how:
--method {{greedy,search}}  greedy: always the loop that leaves least; search: the fastest chain found (default)
--grid DEG                step of the primitives' displacements; loops of three joints have three times this (default 5)
--table-only              take the last loop from the table, too, instead of solving its displacements
--moving-at-once N        joints that the supply can move at the same time: strokes of so many may overlap (default 1;
                          --method search only)
--max-primitives N        give up after so many (default 150)
what may be wrong:
--model-error SCALE  fly a robot drawn from the robot file's uncertainties times this (default 0: the model)
--noise DEG          standard deviation of the measured attitude about each axis (default 0)
--seed N             seed of what is drawn (default 1)
result:
--out FILE      write the plan here (JSON)
--history FILE  write the joints' angles over time here (CSV), for simulate --history to check the plan
--force         let --out and --history overwrite a file that this command did not make
{OUTPUT}"""
_MAX_SCALE = 5.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options for target, method, errors and output."""
    above = dict.fromkeys(("tolerance", "grid"), _above_zero)
    errors = {"model_error": _scale, "noise": _not_negative}
    most = whole_number("primitives", 1, 9999)
    at_once = whole_number("joints", 1, 3)
    add_options(parser, _USAGE, max_primitives=most, moving_at_once=at_once, seed=seed, **above, **errors)
    parser.set_defaults(
        robot=Path("cubesat_3u"), method="search", max_primitives=150, seed=1, moving_at_once=1
    )
    parser.set_defaults(tolerance=1.0, grid=5.0, model_error=0.0, noise=0.0)


def run(args: argparse.Namespace, out: Output) -> int:
    """Plans, flies with feedback, writes and shows."""
    from tfsat_host.plan.orbit.joint_motion_file import write_joint_motion
    from tfsat_host.plan.orbit.orbit_flight import AttitudeSensor, drawn_robot, fly, unit_quaternion
    from tfsat_host.plan.orbit.orbit_planner import Planner
    from tfsat_host.plan.orbit.orbit_result import FILES, PLAN, OrbitResult
    from tfsat_host.plan.orbit.primitives import primitive_table
    from tfsat_host.robot import load_robot

    if args.out is not None and args.out == args.history:
        raise UsageError(
            what=f"--out and --history both name {args.out}.",
            meaning="Nothing was planned.",
            next_step=Advice(
                NextStep("plan", ("--target", "z:90", "--out", "plan.json", "--history", "plan.csv"))
            ),
        )
    for path, marker, option in (
        (args.out, _MARKER, "--out"),
        (args.history, _HISTORY_MARKER, "--history"),
    ):
        if path is not None:
            check_may_write(path, marker=marker, force=args.force, option=option)
    target = unit_quaternion(args.target, args.target_quaternion)
    robot = load_robot(args.robot)
    plant = drawn_robot(robot, args.model_error, args.seed) if args.model_error > 0.0 else None
    with out.progress("Planning"):
        table, tolerance = primitive_table(robot, args.grid), math.radians(args.tolerance)
        # Who flies the model itself may use up the tolerance; who does not keeps some of it for the errors.
        exact = {"share": 1.0} if plant is None and args.noise == 0.0 else {}
        planner = Planner.of(
            table,
            args.method,
            tolerance,
            trim=not args.table_only,
            most=args.max_primitives,
            moving_at_once=args.moving_at_once,
            **exact,
        )
        flight = fly(
            planner, target, plant=plant, sensing=AttitudeSensor(math.radians(args.noise), args.seed)
        )
        result = OrbitResult.of(robot, str(args.robot), planner, flight, plant)
    plan = record(PLAN, result)
    text = json.dumps(plan, indent=2) + "\n"
    motion = partial(write_joint_motion, robot, [step.primitive for step in flight.steps])
    files = []
    if args.out is not None:
        files.append(OutputFile(args.out, _MARKER, lambda to: to.write_text(text, encoding="utf-8")))
    if args.history is not None:
        files.append(OutputFile(args.history, _HISTORY_MARKER, motion))
    write_all(files, force=args.force)
    result = replace(result, file=args.out, history=args.history)
    out.result(plan | record(FILES, result), lambda: _show(result, out))
    return 0 if flight.reached else ExitCode.DATA_LOSS


def _show(result: OrbitResult, out: Output) -> None:
    from tfsat_host.plan.orbit.orbit_result import FILES, PLAN, step_table

    sentences([result.verdict], out)
    show_facts((*PLAN, *FILES), result, out)
    show_table(step_table(result), out)
    if result.history is not None:
        check = NextStep("simulate", ("--robot", result.robot_file, "--history", str(result.history)))
        sentences([Advice("Check: ", check)], out)
    if result.flight.steps:
        sentences([result.verdict], out)


def _above_zero(text: str) -> float:
    if not number(text) > 0.0 or math.isinf(number(text)):
        raise argparse.ArgumentTypeError(f"{text!r} is not above zero")
    return number(text)


def _scale(text: str) -> float:
    """Parse a scale of the robot file's uncertainties (argparse type).

    Refuses a scale above `_MAX_SCALE`, beyond which no robot is left to be drawn.
    """
    scale = _not_negative(text)
    if scale > _MAX_SCALE:
        raise argparse.ArgumentTypeError(f"{text!r} is too large: write a number from 0 to {_MAX_SCALE:g}")
    return scale


def _not_negative(text: str) -> float:
    return 0.0 if number(text) == 0.0 else _above_zero(text)
