"""`tfsat-host plan`: a target attitude, approached by motion primitives with feedback after each."""

from __future__ import annotations

import argparse
import json
import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.options import accept_negative_numbers, add_output_options, file_name, number, seed
from tfsat_host.cli.output import Output
from tfsat_host.cli.outputs import OutputFile, check_may_write, write_all
from tfsat_host.errors import DataLossError, UsageError

if TYPE_CHECKING:
    from tfsat_host.dynamics.components import FloatArray
    from tfsat_host.orbit import Flight, Planner, PrimitiveTable, Step
    from tfsat_host.robot import RobotModel

_MARKER = '"made_by": "tfsat-host plan"'
_TARGET_PART = re.compile(r"\s*([xyz])\s*:\s*(.+?)\s*", re.IGNORECASE)


def configure(parser: argparse.ArgumentParser) -> None:
    """The target, how it is approached, what may be wrong, where the plan goes."""
    parser.description = (
        "Chain closed loops of the joints to turn the robot to a target attitude, with a measurement after each. "
        "Exit code 3 if the error at the end is above the tolerance."
    )
    accept_negative_numbers(parser)
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
    result.add_argument("--force", action="store_true", help="let --out overwrite a file of somebody else")
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Plans, flies with feedback, writes and shows."""
    import numpy as np

    from tfsat_host.orbit import Planner, Sensing, fly, primitive_table
    from tfsat_host.orbit.plant import drawn_robot
    from tfsat_host.robot import load_robot
    from tfsat_host.robot.path import find_robot

    if args.out is not None:
        check_may_write(args.out, marker=_MARKER.encode(), force=args.force)
    target = _target_quaternion(args)
    robot = load_robot(find_robot(args.robot))
    plant = drawn_robot(robot, args.model_error, args.seed) if args.model_error > 0.0 else None
    with out.progress("Planning"):
        table = primitive_table(robot, args.grid)
        planner = Planner.of(
            table, args.method, math.radians(args.tolerance), trim=not args.table_only, most=args.most
        )
        flight = fly(planner, target, plant=plant, sensing=Sensing(float(np.radians(args.noise)), args.seed))
        result = _result(args, robot, planner, flight)
        if plant is not None:
            from tfsat_host.orbit.flight import open_loop_error_rad

            result["open_loop_error_deg"] = math.degrees(open_loop_error_rad(planner, target, plant=plant))
    if args.out is not None:
        _write(args.out, result, force=args.force)
        result["file"] = str(args.out)
    out.result(result, lambda: _show(result, table, flight, out))
    return 0 if flight.reached else DataLossError.exit_code


def _target_quaternion(args: argparse.Namespace) -> FloatArray:
    import numpy as np

    from tfsat_host.orbit import quaternion_of_euler_zyx

    if args.target is not None:
        return quaternion_of_euler_zyx(np.radians(args.target))
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

    from tfsat_host.orbit import euler_zyx_rad, slew_time_s

    start_deg = math.degrees(flight.start_error_rad)
    rate = math.degrees(float(planner.time_to_go.rate_rad_s[0]))
    return {
        "made_by": "tfsat-host plan",
        "robot": robot.name,
        "method": args.method,
        "reached": flight.reached,
        "outcome": flight.outcome,
        "tolerance_deg": args.tolerance,
        "error_deg": math.degrees(flight.error_rad),
        "least_error_deg": math.degrees(flight.least_error_rad),
        "primitives": len(flight.steps),
        "duration_s": flight.duration_s,
        "start_error_deg": start_deg,
        "best_rate_deg_s": rate,
        "least_time_s": slew_time_s(start_deg, rate),
        "open_loop_error_deg": None,
        "target_quaternion_xyzw": flight.target_xyzw.tolist(),
        "target_euler_zyx_deg": np.degrees(euler_zyx_rad(flight.target_xyzw)).tolist(),
        "steps": [_as_json(step) for step in flight.steps],
    }


def _as_json(step: Step) -> dict[str, Any]:
    return {
        "strokes": [
            {"joint": joint + 1, "angle_deg": math.degrees(angle)} for joint, angle in step.primitive.strokes
        ],
        "duration_s": step.primitive.duration_s,
        "predicted_xyzw": step.predicted_xyzw.tolist(),
        "attitude_xyzw": step.attitude_xyzw.tolist(),
        "measured_xyzw": step.measured_xyzw.tolist(),
        "error_deg": math.degrees(step.error_rad),
        "measured_error_deg": math.degrees(step.measured_error_rad),
    }


def _write(path: Path, result: dict[str, Any], *, force: bool) -> None:
    text = json.dumps(result, indent=2) + "\n"
    marker = _MARKER.encode()
    write_all([OutputFile(path, marker, lambda to: to.write_text(text, encoding="utf-8"))], force=force)


def _show(result: dict[str, Any], table: PrimitiveTable, flight: Flight, out: Output) -> None:
    rows = []
    elapsed_s = 0.0
    for count, step in enumerate(flight.steps, start=1):
        elapsed_s += step.primitive.duration_s
        rows.append(
            (
                count,
                " ".join(
                    f"{joint + 1}:{math.degrees(angle):+.1f}" for joint, angle in step.primitive.strokes
                ),
                f"{elapsed_s:.1f}",
                f"{math.degrees(step.measured_error_rad):.3f}",
                f"{math.degrees(step.error_rad):.3f}",
            )
        )
    if rows:
        out.table(("", "joint:angle / deg", "t / s", "measured / deg", "error / deg"), rows)
    out.line(
        f"{'Reached' if flight.reached else 'NOT REACHED'}: {result['error_deg']:.3g} deg left of "
        f"{result['start_error_deg']:.1f} deg, tolerance {result['tolerance_deg']:g} deg, in "
        f"{result['duration_s']:.1f} s by {result['primitives']} primitives ({len(table)} in the table)."
    )
    out.line(
        f"At {result['best_rate_deg_s']:.2f} deg/s, this robot's best, the angle alone takes "
        f"{result['least_time_s']:.1f} s."
    )
    if result["open_loop_error_deg"] is not None:
        out.line(f"Without feedback {result['open_loop_error_deg']:.3g} deg would be left.")
    if not flight.reached:
        out.line(_advice(result))
    if "file" in result:
        out.line(f"Written to {result['file']}.")


def _advice(result: dict[str, Any]) -> str:
    """What came of it, and what would be possible."""
    if result["outcome"] == "within tolerance":
        return (
            "The measured error is within the tolerance, the true one is not: the noise is too great for it."
        )
    why = {
        "no progress": "No primitive brings it nearer any more.",
        "primitives used up": "The primitives were used up; --most allows more.",
    }[result["outcome"]]
    least = result["least_error_deg"]
    met = f"--tolerance {least * 1.02:.3g} would have been met."
    return f"{why} The smallest error on the way was {least:.3g} deg: {met}"


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
