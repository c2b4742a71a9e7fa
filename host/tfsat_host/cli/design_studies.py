"""Instead of a design: all loops on a grid (`--grid`), and which maneuver a drop learns most from (`--learn`)."""

from __future__ import annotations

import argparse
import math
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.errors import UsageError
from tfsat_host.output_files import OutputFile, check_may_write, write_all
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import show
from tfsat_host.quantity import Column, Table

if TYPE_CHECKING:
    from tfsat_host.rehearsal.learning import Learnt, Lesson
    from tfsat_host.robot import RobotModel


# Options of `design` that a grid has no use for; all but the last two have None where they are not given.
_SEARCH_ONLY = (
    "time-limit robust penalty seed particles iterations inertia own-best best-of-all alternating swarm"
)
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


_MARKER = b'name = "to learn: '
_USELESS = (
    "joints time_limit speed limit robust penalty seed particles iterations inertia own_best best_of_all"
)
_SHOWN = 3


def show_learning(args: argparse.Namespace, path: Path, out: Output) -> int:
    """Writes the best maneuver to `path`, and the pair next to it where that is another one.

    Raises:
        UsageError: an option does not fit, or the robot is none that the boards fly.
    """
    from tfsat_host.maneuver import write_maneuver
    from tfsat_host.rehearsal.learning import learn
    from tfsat_host.robot import load_robot

    given = [f"--{one.replace('_', '-')}" for one in _USELESS.split() if getattr(args, one) is not None]
    if given:
        raise UsageError(
            what=f"{', '.join(given)}: --learn compares maneuvers that use the whole fall.",
            meaning="Nothing was designed.",
            next_step=f"tfsat-host design --learn {args.learn}",
        )
    second = path.with_name(f"{path.stem}-2{path.suffix}")
    for one in (path, second):
        check_may_write(one, marker=_MARKER, force=args.force)
    robot = load_robot(args.robot)
    with out.progress("Flying and evaluating maneuvers", total=1.0) as advance:
        found = learn(robot, args.learn, advance)
    best, other = found.lessons[0], _other(found)
    files = [OutputFile(path, _MARKER, lambda place: write_maneuver(best.maneuver, place))]
    if other is not best:
        files.append(OutputFile(second, _MARKER, lambda place: write_maneuver(other.maneuver, place)))
    write_all(files, force=args.force)
    out.result(_document(found, [one.path for one in files]), lambda: show(_lines(found, files), out))
    return 0


def _other(found: Learnt) -> Lesson:
    """Return the member of the best pair that is not the best single maneuver."""
    return next((one for one in found.pair if one is not found.lessons[0]), found.lessons[0])


def _choices(found: Learnt) -> dict[str, tuple[Lesson, ...]]:
    first, second = found.pair
    return {
        f"{found.usual.name}": (found.usual,),
        **{one.name: (one,) for one in found.lessons[:_SHOWN]},
        f"{found.usual.name}, twice": (found.usual, found.usual),
        f"{first.name} and {second.name}": (first, second),
    }


def _document(found: Learnt, files: list[Path]) -> dict[str, Any]:
    return {
        "wanted": found.wanted,
        "unit": found.unit,
        "names": list(found.names),
        "maneuvers": [
            {"name": name, "drops": len(of), "std": found.std(*of), "rms_std": found.rms(*of)}
            for name, of in _choices(found).items()
        ],
        "compared": len(found.lessons),
        "files": [str(one) for one in files],
    }


def _lines(found: Learnt, files: list[OutputFile]) -> list[str | Table]:
    usual = found.rms(found.usual)
    columns = (
        Column("name", "drops with"),
        Column("rms", f"± of {found.wanted}, rms", "", form=".3f"),
        Column("share", "of 59/70's", form=".2f"),
    )
    rows = [
        {"name": name, "rms": found.rms(*of), "share": found.rms(*of) / usual}
        for name, of in _choices(found).items()
    ]
    listed = ", ".join(str(one.path) for one in files)
    return [
        Table("", columns, rows),
        f"The ± (in {found.unit}) is what a drop leaves of {len(found.names)} numbers if the robot is as uncertain as "
        f"its file says; {len(found.lessons)} maneuvers were flown and compared.",
        f"Written: {listed}. Next: tfsat-host envelope --file {files[0].path}",
    ]
