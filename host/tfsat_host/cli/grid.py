"""`tfsat-host design --grid`: all four-stroke loops of a robot on a grid, the best ones, and data to plot."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.output_files import OutputFile, check_may_write, write_all
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show_rows
from tfsat_host.quantity import Column, Columns

if TYPE_CHECKING:
    from tfsat_host.plan.grid import Distribution, GridManeuver
    from tfsat_host.robot import RobotModel

# Bytes by which a picture of ours is known. matplotlib signs its files so.
_FIGURE_MARKERS = {"png": b"Matplotlib", "pdf": b"Matplotlib", "svg": b"Matplotlib"}
_TARGET_DEG = 90.0
# Options of `design` that a grid has no use for, by their names in the parsed arguments.
_SEARCH_ONLY: Mapping[str, str] = {
    "time_limit": "--time-limit",
    "penalty": "--penalty",
    "seed": "--seed",
    "particles": "--particles",
    "iterations": "--iterations",
    "inertia": "--inertia",
    "own_best": "--own-best",
    "best_of_all": "--best-of-all",
    "alternating": "--alternating",
    "swarm": "--swarm",
}
_DEFAULT_SEED = 1
# Finer grids take longer than a moment.
_SLOW_BELOW_DEG = 1.0


def show_grid(args: argparse.Namespace, robot: RobotModel, out: Output) -> int:
    """Shows the most efficient loop of every joint pair; writes all of them with `--out`, draws with `--figure`.

    Args:
        args: `grid` in deg; `joints`, indices, `limit` in deg and `speed` in deg/s, each or None; `out` and
            `figure`, files or None; `force`.
        robot: From whose start pose and within whose limits the loops are.
        out: Where the result goes.

    Raises:
        UsageError: an option does not fit a grid.
    """
    import numpy as np

    from tfsat_host.dynamics import Multibody
    from tfsat_host.plan.grid import distribution, room_rad

    _check_options(args)
    file_format = _figure_format(args.figure)
    _check_files(args, file_format)
    start = np.array([servo.start_rad for servo in robot.servos])
    room = room_rad(robot, args.joints, args.limit)
    slow = args.grid < _SLOW_BELOW_DEG
    with out.progress("Computing the loops") if slow else nullcontext():
        found = distribution(Multibody.of(robot), room, args.grid, start_rad=start)
        result = _result(found, robot, args.speed)
    files = _files(args, found, robot, file_format)
    for file in files:
        with out.progress(f"Writing {file.path}") if slow or file.path == args.figure else nullcontext():
            write_all([file], force=args.force)
    result |= {"files": [str(file.path) for file in files]}
    out.result(result, lambda: _show(robot, result, out))
    return 0


def _check_options(args: argparse.Namespace) -> None:
    given = [
        option
        for name, option in _SEARCH_ONLY.items()
        if getattr(args, name) not in (None, False, _DEFAULT_SEED if name == "seed" else None)
    ]
    if given:
        raise UsageError(
            what=f"{', '.join(given)}: a grid has no use for {'it' if len(given) == 1 else 'them'}, nothing is "
            "searched.",
            meaning="Nothing was computed.",
            next_step=f"tfsat-host design --grid {args.grid:g}, with --joints, --limit or --speed as you like.",
        )
    if not (math.isfinite(args.grid) and args.grid > 0.0):
        raise UsageError(
            what=f"A grid step of {args.grid:g} deg is not above zero.",
            meaning="Nothing was computed.",
            next_step="tfsat-host design --grid 5",
        )
    if args.speed is not None and not (math.isfinite(args.speed) and args.speed > 0.0):
        raise UsageError(
            what=f"A joint speed of {args.speed:g} deg/s is not above zero.",
            meaning="Nothing was computed.",
            next_step="Give a speed such as --speed 30, or leave it out: then it is the servos'.",
        )
    if args.out is not None and args.out.suffix.lower() != ".csv":
        raise UsageError(
            what=f"With --grid, --out writes a table (CSV), and {args.out} does not end with .csv.",
            meaning="Nothing was computed.",
            next_step=f"tfsat-host design --grid {args.grid:g} --out loops.csv",
        )


def _check_files(args: argparse.Namespace, file_format: str) -> None:
    """Raises TfsatError if a file of somebody else is in the way: before anything is computed."""
    from tfsat_host.plan.grid import COLUMNS

    if args.out is not None:
        check_may_write(args.out, marker=COLUMNS.encode(), force=args.force)
    if args.figure is not None:
        check_may_write(args.figure, marker=_FIGURE_MARKERS[file_format], force=args.force)


def _figure_format(path: Path | None) -> str:
    """Raises UsageError or TfsatError if the figure could not be drawn: before anything is computed."""
    if path is None:
        return ""
    from importlib.util import find_spec

    file_format = path.suffix.lower().removeprefix(".")
    if file_format not in _FIGURE_MARKERS:
        raise UsageError(
            what=f"{path} does not end with the name of a picture format.",
            meaning="Nothing was drawn or written.",
            next_step=f"Let --figure end with {', '.join('.' + name for name in _FIGURE_MARKERS)}.",
        )
    if find_spec("matplotlib") is None:
        raise TfsatError(
            what="--figure needs matplotlib, which is not installed.",
            meaning="Nothing was drawn or written.",
            next_step="In tfsat's folder: python -m pip install '.[figures]'; or take the CSV of --out.",
        )
    return file_format


def _files(
    args: argparse.Namespace, found: Distribution, robot: RobotModel, file_format: str
) -> list[OutputFile]:
    from tfsat_host.plan.grid import COLUMNS, draw_distribution, write_csv

    def write_table(path: Path) -> None:
        with path.open("w", encoding="utf-8", newline="\n") as file:
            write_csv(found, file)

    files = []
    if args.out is not None:
        files.append(OutputFile(args.out, COLUMNS.encode(), write_table))
    if args.figure is not None:
        title = f"{robot.name}: {len(found.angle_rad)} loops of four strokes, every {args.grid:g} deg"
        files.append(
            OutputFile(
                args.figure,
                _FIGURE_MARKERS[file_format],
                lambda path: draw_distribution(found, title, path, file_format),
            )
        )
    return files


def _result(found: Distribution, robot: RobotModel, speed_deg_s: float | None) -> dict[str, Any]:
    from tfsat_host.plan.grid import average_rate, expected_error, slew_time_s

    best = found.maneuver(found.best_by_efficiency)
    if speed_deg_s is None:
        speed_deg_s = math.degrees(min(robot.servos[joint].average_rate_rad_s for joint in best.joints))
    rate = average_rate(speed_deg_s, best.efficiency)
    return {
        "robot": robot.name,
        "grid_deg": found.step_deg,
        "maneuvers": len(found.angle_rad),
        "most_efficient": _as_json(best),
        "farthest": _as_json(found.maneuver(found.best_by_angle)),
        "pairs": [_as_json(found.maneuver(index)) for index in found.best_of_pairs()],
        "joint_speed_deg_s": speed_deg_s,
        "average_rate_deg_s": rate,
        "target_deg": _TARGET_DEG,
        "slew_time_s": slew_time_s(_TARGET_DEG, rate),
        "expected_error_deg": expected_error(_TARGET_DEG),
    }


def _as_json(maneuver: GridManeuver) -> dict[str, Any]:
    return maneuver._asdict() | {"joints": [joint + 1 for joint in maneuver.joints]}


_LOOPS: Columns = (
    Column("joints", "joints", form=".0f"),
    Column("alpha_deg", "first", form="g"),
    Column("beta_deg", "second", form="g"),
    Column("reorientation_deg", "reorientation", form=".2f"),
    Column("efficiency", "efficiency", form=".4f"),
    Column("euler_zyx_deg", "z y x", form="+.2f"),
)


def _show(robot: RobotModel, result: dict[str, Any], out: Output) -> None:
    title = f"{robot.name}: the most efficient of each pair's loops of four strokes"
    show_rows(_LOOPS, result["pairs"], out, title=title)
    out.line(f"{result['maneuvers']} loops on a grid of {result['grid_deg']:g} deg.")
    farthest = result["farthest"]
    out.line(
        f"Farthest: {farthest['reorientation_deg']:.2f} deg by joints {farthest['joints'][0]} and "
        f"{farthest['joints'][1]}, {farthest['alpha_deg']:g} and {farthest['beta_deg']:g} deg "
        f"(efficiency {farthest['efficiency']:.4f})."
    )
    out.line(
        f"With joints at {result['joint_speed_deg_s']:g} deg/s the most efficient loop again and again turns by "
        f"{result['average_rate_deg_s']:.2f} deg/s: {_TARGET_DEG:g} deg in {result['slew_time_s']:.1f} s, without "
        f"feedback to about {result['expected_error_deg']:.2f} deg, in proportion to the drop test's errors."
    )
    for path in result["files"]:
        out.line(f"Written to {path}.")
