"""`tfsat-host plan`: a target attitude, approached by motion primitives with feedback after each."""

from __future__ import annotations

import argparse
import json
import math
from functools import partial
from pathlib import Path

from tfsat_host.cli.options import add_output_options, file_name, number, seed, whole_number
from tfsat_host.errors import DataLossError, UsageError
from tfsat_host.output_files import OutputFile, check_may_write, write_all
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show

_MARKER = b'"made_by": "tfsat-host plan"'
_HISTORY_MARKER = b"_deg,primitive"  # the end of its line of column names


def configure(parser: argparse.ArgumentParser) -> None:
    """The target, how it is approached, what may be wrong, where the plan goes."""
    parser.description = (
        "Chain closed loops of the joints to turn the robot to a target attitude, with a measurement after each. "
        "Exit code 3 if the error at the end is above the tolerance."
    )
    asked = parser.add_argument_group("what is asked for")
    target = asked.add_mutually_exclusive_group(required=True)
    shown = (
        "z-y-x Euler angles of the attitude, such as z:90 or x:30,y:-20,z:90: about z first, then about "
        "the new y, then about the newest x, in whatever order they are written"
    )
    target.add_argument("--target", metavar="z:DEG", help=shown)
    shown = "the same as a quaternion, scalar last, from body to inertial axes"
    target.add_argument("--target-quaternion", metavar=("X", "Y", "Z", "W"), nargs=4, type=number, help=shown)
    shown = "a robot file, or the name of a robot that tfsat brings along (default: cubesat_3u)"
    asked.add_argument("--robot", metavar="FILE", type=file_name, default=Path("cubesat_3u"), help=shown)
    shown = "error that may be left (default 1)"
    asked.add_argument("--tolerance", metavar="DEG", type=_above_zero, default=1.0, help=shown)
    how = parser.add_argument_group("how")
    shown = "greedy: always the loop that leaves least; search: the fastest chain found (default)"
    how.add_argument("--method", choices=("greedy", "search"), default="search", help=shown)
    shown = "step of the primitives' displacements; loops of three joints have three times this (default 5)"
    how.add_argument("--grid", metavar="DEG", type=_above_zero, default=5.0, help=shown)
    shown = "take the last loop from the table, too, instead of solving its displacements"
    how.add_argument("--table-only", action="store_true", help=shown)
    shown, count = "most primitives (default 150)", whole_number("primitives", 1, 9999)
    how.add_argument("--most", metavar="N", type=count, default=150, help=shown)
    wrong = parser.add_argument_group("what may be wrong")
    shown = "fly a robot drawn from the robot file's uncertainties times this (default 0: the model)"
    wrong.add_argument("--model-error", metavar="SCALE", type=_not_negative, default=0.0, help=shown)
    shown = "standard deviation of the measured attitude about each axis (default 0)"
    wrong.add_argument("--noise", metavar="DEG", type=_not_negative, default=0.0, help=shown)
    wrong.add_argument("--seed", metavar="N", type=seed, default=1, help="seed of what is drawn (default 1)")
    result = parser.add_argument_group("result")
    result.add_argument("--out", metavar="FILE", type=file_name, help="write the plan here (JSON)")
    shown = "write the joints' angles over time here (CSV), for simulate --history to check the plan"
    result.add_argument("--history", metavar="FILE", type=file_name, help=shown)
    shown = "let --out and --history overwrite a file that this command did not make"
    result.add_argument("--force", action="store_true", help=shown)
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Plans, flies with feedback, writes and shows."""
    from tfsat_host.plan.flight import Sensing, drawn_robot, fly, unit_quaternion
    from tfsat_host.plan.flight_result import document, lines, write_joint_motion
    from tfsat_host.plan.planner import Planner
    from tfsat_host.plan.primitives import primitive_table
    from tfsat_host.robot import load_robot

    if args.out is not None and args.out == args.history:
        raise UsageError(
            what=f"--out and --history both name {args.out}.",
            meaning="Nothing was planned.",
            next_step="tfsat-host plan --target z:90 --out plan.json --history plan.csv",
        )
    for path, marker in ((args.out, _MARKER), (args.history, _HISTORY_MARKER)):
        if path is not None:
            check_may_write(path, marker=marker, force=args.force)
    target = unit_quaternion(args.target, args.target_quaternion)
    robot = load_robot(args.robot)
    plant = drawn_robot(robot, args.model_error, args.seed) if args.model_error > 0.0 else None
    with out.progress("Planning"):
        table, tolerance = primitive_table(robot, args.grid), math.radians(args.tolerance)
        # Who flies the model itself may use up the tolerance; who does not keeps some of it for the errors.
        exact = {"share": 1.0} if plant is None and args.noise == 0.0 else {}
        planner = Planner.of(table, args.method, tolerance, trim=not args.table_only, most=args.most, **exact)
        flight = fly(planner, target, plant=plant, sensing=Sensing(math.radians(args.noise), args.seed))
        result = {"made_by": "tfsat-host plan", "robot_file": str(args.robot)}
        result |= document(robot, planner, flight, plant)
    text = json.dumps(result, indent=2) + "\n"
    motion = partial(write_joint_motion, robot, [step.primitive for step in flight.steps])
    files = []
    if args.out is not None:
        files.append(OutputFile(args.out, _MARKER, lambda to: to.write_text(text, encoding="utf-8")))
    if args.history is not None:
        files.append(OutputFile(args.history, _HISTORY_MARKER, motion))
    write_all(files, force=args.force)
    result |= {"file": args.out, "history": args.history}
    out.result(result, lambda: show(lines(result), out))
    return 0 if flight.reached else DataLossError.exit_code


def _above_zero(text: str) -> float:
    if not number(text) > 0.0 or math.isinf(number(text)):
        raise argparse.ArgumentTypeError(f"{text!r} is not above zero")
    return number(text)


def _not_negative(text: str) -> float:
    return 0.0 if number(text) == 0.0 else _above_zero(text)
