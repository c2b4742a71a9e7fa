"""`tfsat-host design --grid`: all four-stroke loops of a robot on a grid, the best ones, and data to plot."""

from __future__ import annotations

import argparse
import math
from contextlib import nullcontext
from typing import TYPE_CHECKING

from tfsat_host.errors import UsageError
from tfsat_host.output_files import check_may_write, write_all
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show

if TYPE_CHECKING:
    from tfsat_host.robot import RobotModel

# Options of `design` that a grid has no use for; all but the last two have None where they are not given.
_SEARCH_ONLY = "time-limit penalty seed particles iterations inertia own-best best-of-all alternating swarm"
_DEFAULT_SEED = 1
_SLOW_BELOW_DEG = 1.0  # finer grids take longer than a moment


def show_grid(args: argparse.Namespace, robot: RobotModel, out: Output) -> int:
    """Shows the most efficient loop of every joint pair; writes all of them with `--out`, draws with `--figure`.

    Args:
        args: Those of `design`, with `grid` in deg.
        robot: From whose start pose and within whose limits the loops are.
        out: Where the result goes.

    Raises:
        UsageError: an option does not fit a grid.
    """
    import numpy as np

    from tfsat_host.dynamics import Multibody
    from tfsat_host.plan import grid, grid_result

    _check_options(args)
    files = grid_result.files_for(args.out, args.figure)
    for path, marker in files:
        check_may_write(path, marker=marker, force=args.force)
    start = np.array([servo.start_rad for servo in robot.servos])
    room = grid.room_rad(robot, args.joints, args.limit)
    slow = args.grid < _SLOW_BELOW_DEG
    with out.progress("Computing the loops") if slow else nullcontext():
        found = grid.distribution(Multibody.of(robot), room, args.grid, start_rad=start)
        result = grid_result.document(found, robot, args.speed)
    for path, marker in files:
        with out.progress(f"Writing {path}") if slow or path == args.figure else nullcontext():
            write_all([grid_result.output_file(found, robot, path, marker)], force=args.force)
    result["files"] = [str(path) for path, _ in files]
    out.result(result, lambda: show(grid_result.lines(result), out))
    return 0


def _check_options(args: argparse.Namespace) -> None:
    given = [
        f"--{option}"
        for option in _SEARCH_ONLY.split()
        if (value := getattr(args, option.replace("-", "_"))) not in (None, False)
        and not (option == "seed" and value == _DEFAULT_SEED)
    ]
    what = cure = ""
    if given:
        unused = "it" if len(given) == 1 else "them"
        what = f"{', '.join(given)}: a grid has no use for {unused}, nothing is searched."
        cure = f"tfsat-host design --grid {args.grid:g}, with --joints, --limit or --speed as you like."
    elif not (math.isfinite(args.grid) and args.grid > 0.0):
        what, cure = f"A grid step of {args.grid:g} deg is not above zero.", "tfsat-host design --grid 5"
    elif args.speed is not None and not (math.isfinite(args.speed) and args.speed > 0.0):
        what = f"A joint speed of {args.speed:g} deg/s is not above zero."
        cure = "Give a speed such as --speed 30, or leave it out: then it is the servos'."
    elif args.out is not None and args.out.suffix.lower() != ".csv":
        what = f"With --grid, --out writes a table (CSV), and {args.out} does not end with .csv."
        cure = f"tfsat-host design --grid {args.grid:g} --out loops.csv"
    if what:
        raise UsageError(what=what, meaning="Nothing was computed.", next_step=cure)
