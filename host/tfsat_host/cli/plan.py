"""`tfsat-host plan`: a target attitude, approached by motion primitives with feedback after each."""

from __future__ import annotations

import argparse
import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.options import add_output_options, file_name, number, seed
from tfsat_host.errors import DataLossError, UsageError
from tfsat_host.output_files import OutputFile, check_may_write, write_all
from tfsat_host.present.output import Output
from tfsat_host.quantity import Column, Columns, fields, records

if TYPE_CHECKING:
    from tfsat_host.dynamics import Multibody
    from tfsat_host.plan.flight import Flight, Step
    from tfsat_host.plan.planner import Planner
    from tfsat_host.robot import RobotModel
    from tfsat_host.robot.model import FloatArray

_MARKER = '"made_by": "tfsat-host plan"'
_HISTORY_MARKER = "_deg,primitive"  # the end of its line of column names
_TARGET_PART = re.compile(r"\s*([xyz])\s*:\s*(.+?)\s*", re.IGNORECASE)


def configure(parser: argparse.ArgumentParser) -> None:
    """The target, how it is approached, what may be wrong, where the plan goes."""
    parser.description = (
        "Chain closed loops of the joints to turn the robot to a target attitude, with a measurement after each. "
        "Exit code 3 if the error at the end is above the tolerance."
    )
    asked = parser.add_argument_group("what is asked for")
    target = asked.add_mutually_exclusive_group(required=True)
    target.add_argument(
        "--target",
        metavar="z:DEG",
        type=_target,
        help="z-y-x Euler angles of the attitude, such as z:90 or x:30,y:-20,z:90: about z first, then about "
        "the new y, then about the newest x, in whatever order they are written",
    )
    target.add_argument(
        "--target-quaternion",
        metavar=("X", "Y", "Z", "W"),
        nargs=4,
        type=number,
        help="the same as a quaternion, scalar last, from body to inertial axes",
    )
    asked.add_argument(
        "--robot",
        metavar="FILE",
        type=file_name,
        default=Path("cubesat_3u"),
        help="a robot file, or the name of a robot that tfsat brings along (default: cubesat_3u)",
    )
    asked.add_argument(
        "--tolerance", metavar="DEG", type=_above_zero, default=1.0, help="error that may be left (default 1)"
    )
    how = parser.add_argument_group("how")
    how.add_argument(
        "--method",
        choices=("greedy", "search"),
        default="search",
        help="greedy: always the loop that leaves least; search: the fastest chain found (default)",
    )
    how.add_argument(
        "--grid",
        metavar="DEG",
        type=_above_zero,
        default=5.0,
        help="step of the primitives' displacements; loops of three joints have three times this (default 5)",
    )
    how.add_argument(
        "--table-only",
        action="store_true",
        help="take the last loop from the table, too, instead of solving its displacements",
    )
    how.add_argument("--most", metavar="N", type=_count, default=150, help="most primitives (default 150)")
    wrong = parser.add_argument_group("what may be wrong")
    wrong.add_argument(
        "--model-error",
        metavar="SCALE",
        type=_not_negative,
        default=0.0,
        help="fly a robot drawn from the robot file's uncertainties times this (default 0: the model)",
    )
    wrong.add_argument(
        "--noise",
        metavar="DEG",
        type=_not_negative,
        default=0.0,
        help="standard deviation of the measured attitude about each axis (default 0)",
    )
    wrong.add_argument("--seed", metavar="N", type=seed, default=1, help="seed of what is drawn (default 1)")
    result = parser.add_argument_group("result")
    result.add_argument("--out", metavar="FILE", type=file_name, help="write the plan here (JSON)")
    result.add_argument(
        "--history",
        metavar="FILE",
        type=file_name,
        help="write the joints' angles over time here (CSV), for simulate --history to check the plan",
    )
    result.add_argument(
        "--force", action="store_true", help="let --out and --history overwrite a file of somebody else"
    )
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Plans, flies with feedback, writes and shows."""
    from tfsat_host.cli.plan_words import show
    from tfsat_host.plan.flight import Sensing, drawn_robot, fly, open_loop_error_rad
    from tfsat_host.plan.planner import Planner
    from tfsat_host.plan.primitives import primitive_table
    from tfsat_host.robot import load_robot
    from tfsat_host.robot.path import find_robot

    _check_files(args)
    target = _target_quaternion(args)
    robot = load_robot(find_robot(args.robot))
    plant = drawn_robot(robot, args.model_error, args.seed) if args.model_error > 0.0 else None
    with out.progress("Planning"):
        table = primitive_table(robot, args.grid)
        planner = Planner.of(
            table, args.method, math.radians(args.tolerance), trim=not args.table_only, most=args.most
        )
        flight = fly(planner, target, plant=plant, sensing=Sensing(math.radians(args.noise), args.seed))
        result = _result(args, robot, planner, flight)
        if plant is not None:
            result["open_loop_error_deg"] = math.degrees(open_loop_error_rad(planner, target, plant=plant))
        if not flight.reached and args.noise == 0.0:
            result["possible_tolerance_deg"] = _possible_tolerance_deg(planner, flight, plant)
    _write(args, result, robot, flight)
    result |= {name: None if path is None else str(path) for name, path in _files(args).items()}
    out.result(result, lambda: show(result, flight, out))
    return 0 if flight.reached else DataLossError.exit_code


def _files(args: argparse.Namespace) -> dict[str, Path | None]:
    """The files of the plan by their key in the result."""
    return {"file": args.out, "history": args.history}


def _check_files(args: argparse.Namespace) -> None:
    """Raises before anything is computed if a file may not be written."""
    if args.out is not None and args.out == args.history:
        raise UsageError(
            what=f"--out and --history both name {args.out}.",
            meaning="Nothing was planned.",
            next_step="tfsat-host plan --target z:90 --out plan.json --history plan.csv",
        )
    for path, marker in ((args.out, _MARKER), (args.history, _HISTORY_MARKER)):
        if path is not None:
            check_may_write(path, marker=marker.encode(), force=args.force)


def _target_quaternion(args: argparse.Namespace) -> FloatArray:
    import numpy as np
    from scipy.spatial.transform import Rotation

    if args.target is not None:
        return np.asarray(Rotation.from_euler("ZYX", args.target, degrees=True).as_quat())
    target = np.array(args.target_quaternion)
    norm = float(np.linalg.norm(target))
    if not (math.isfinite(norm) and norm > 0.0):
        raise UsageError(
            what="--target-quaternion is no rotation: its four numbers have no direction.",
            meaning="Nothing was planned.",
            next_step="tfsat-host plan --target-quaternion 0 0 0.7071 0.7071",
        )
    return np.asarray(target / norm)


def _result(args: argparse.Namespace, robot: RobotModel, planner: Planner, flight: Flight) -> dict[str, Any]:
    import numpy as np
    from scipy.spatial.transform import Rotation

    from tfsat_host.dynamics.euler import euler_zyx_rad
    from tfsat_host.plan.grid import slew_time_s

    start_deg = math.degrees(flight.start_error_rad)
    rate = math.degrees(planner.table.best_rate_about(flight.target_xyzw))
    return {
        "made_by": "tfsat-host plan",
        "robot": robot.name,
        "robot_file": str(args.robot),
        "method": args.method,
        "reached": flight.reached,
        "outcome": flight.outcome,
        "tolerance_deg": args.tolerance,
        "measured_to_deg": math.sqrt(3.0) * args.noise,
        "error_deg": math.degrees(flight.error_rad),
        "least_error_deg": math.degrees(flight.least_error_rad),
        "possible_tolerance_deg": None,
        "primitives": len(flight.steps),
        "table_size": len(planner.table),
        "duration_s": flight.duration_s,
        "start_error_deg": start_deg,
        "axis_rate_deg_s": rate if rate > 0.0 else None,
        "axis_time_s": slew_time_s(start_deg, rate) if rate > 0.0 else None,
        "open_loop_error_deg": None,
        "target_quaternion_xyzw": flight.target_xyzw.tolist(),
        "target_euler_zyx_deg": np.degrees(
            euler_zyx_rad(Rotation.from_quat(flight.target_xyzw).as_matrix())
        ).tolist(),
        "steps": records(_STEP, flight.steps),
    }


def _possible_tolerance_deg(planner: Planner, flight: Flight, plant: Multibody | None) -> float | None:
    """A tolerance a little above the smallest error, if a flight with it does reach it."""
    from tfsat_host.plan.flight import fly

    possible = float(f"{1.02 * math.degrees(flight.least_error_rad):.3g}")
    easier = replace(planner, tolerance_rad=math.radians(possible))
    return possible if fly(easier, flight.target_xyzw, plant=plant).reached else None


def _strokes(step: Step) -> list[dict[str, Any]]:
    return [{"joint": joint + 1, "angle_deg": math.degrees(angle)} for joint, angle in step.primitive.strokes]


_STEP: Columns = (
    Column("strokes", of=_strokes),
    *fields("duration_s=primitive.duration_s predicted_xyzw attitude_xyzw measured_xyzw"),
    *fields("error_deg measured_error_deg"),
)


def _write(args: argparse.Namespace, result: dict[str, Any], robot: RobotModel, flight: Flight) -> None:
    from tfsat_host.plan.flight import write_joint_motion

    def write_motion(path: Path) -> None:
        with path.open("w", encoding="utf-8", newline="\n") as file:
            write_joint_motion(robot, [step.primitive for step in flight.steps], file)

    text = json.dumps(result, indent=2) + "\n"
    files = []
    if args.out is not None:
        files.append(OutputFile(args.out, _MARKER.encode(), lambda to: to.write_text(text, encoding="utf-8")))
    if args.history is not None:
        files.append(OutputFile(args.history, _HISTORY_MARKER.encode(), write_motion))
    write_all(files, force=args.force)


def _target(text: str) -> tuple[float, float, float]:
    """An argparse type: angles about z, y, x in deg. Raises ArgumentTypeError."""
    angles = dict.fromkeys("zyx", 0.0)
    seen: set[str] = set()
    for part in text.split(","):
        match = _TARGET_PART.fullmatch(part)
        if match is None:
            raise argparse.ArgumentTypeError(f"{part!r} is no axis and angle, such as z:90")
        axis, angle = match[1].lower(), number(match[2])
        if axis in seen:
            raise argparse.ArgumentTypeError(f"{axis} is given twice")
        if not math.isfinite(angle):
            raise argparse.ArgumentTypeError(f"{part!r} is no finite angle")
        seen.add(axis)
        angles[axis] = angle
    return angles["z"], angles["y"], angles["x"]


def _above_zero(text: str) -> float:
    value = number(text)
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"{text!r} is not above zero")
    return value


def _not_negative(text: str) -> float:
    value = number(text)
    if not (math.isfinite(value) and value >= 0.0):
        raise argparse.ArgumentTypeError(f"{text!r} is below zero")
    return value


def _count(text: str) -> int:
    if not (text.isascii() and text.isdigit() and 0 < int(text) < 10_000):
        raise argparse.ArgumentTypeError(f"{text!r} is no number from 1 to 9999")
    return int(text)
