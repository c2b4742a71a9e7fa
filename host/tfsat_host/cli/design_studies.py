"""Instead of a design: all loops on a grid (`--grid`), and which maneuver a drop learns most from (`--learn`)."""

from __future__ import annotations

import argparse
import math
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.errors import UsageError
from tfsat_host.maneuver import format_maneuver
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.output_files import SEAL, check_may_write, sealed_file, write_all
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import sentences, show_facts, show_rows, show_table
from tfsat_host.quantity import Column, Columns, fields, record

if TYPE_CHECKING:
    from tfsat_host.rehearsal.learning import Learnt, Lesson
    from tfsat_host.robot import RobotModel


# Options of `design` that a grid has no use for.
_SEARCH_ONLY = (
    "time-limit robust penalty seed particles iterations inertia own-best best-of-all alternating swarm "
    "together"
)
_SLOW_BELOW_DEG = 1.0  # finer grids take longer than a moment


def show_grid(args: argparse.Namespace, robot: RobotModel, out: Output) -> int:
    """Shows the most efficient loop of every joint pair; writes all of them with `--out`, draws with `--figure`.

    Loops start from the robot's start pose and stay within its limits; `args.grid` is in deg.

    Raises:
        UsageError: an option does not fit a grid.
    """
    import numpy as np

    from tfsat_host.dynamics import Multibody
    from tfsat_host.plan import grid, grid_result

    _check_options(args)
    files = grid_result.files_for(args.out, args.figure)
    for path, marker in files:
        option = "--figure" if path == args.figure else "--out"
        check_may_write(path, marker=marker, force=args.force, option=option)
    start = np.array([servo.start_rad for servo in robot.servos])
    room = grid.room_rad(robot, args.joints, args.limit)
    slow = args.grid < _SLOW_BELOW_DEG
    with out.progress("Computing the loops") if slow else nullcontext():
        distribution = grid.distribution(Multibody.of(robot), room, args.grid, start_rad=start)
        result = grid_result.GridResult(distribution, robot, args.speed, [path for path, _ in files])
    for path, marker in files:
        with out.progress(f"Writing {path}") if slow or path == args.figure else nullcontext():
            write_all([grid_result.output_file(distribution, robot, path, marker)], force=args.force)

    def show_result() -> None:
        show_facts(grid_result.DISTRIBUTION, result, out)
        show_table(grid_result.pair_table(result), out)

    out.result(record(grid_result.DISTRIBUTION, result), show_result)
    return 0


def _given(options: str, args: argparse.Namespace) -> list[str]:
    """Return those of the options, by spaces, that were typed."""
    return [
        f"--{option}"
        for option in options.split()
        if getattr(args, option.replace("-", "_")) not in (None, False)
    ]


def _check_options(args: argparse.Namespace) -> None:
    options = _given(_SEARCH_ONLY, args)
    what = cure = ""
    if options:
        unused = "it" if len(options) == 1 else "them"
        what = f"{', '.join(options)}: a grid has no use for {unused}, nothing is searched."
        cure = Advice(
            NextStep("design", ("--grid", f"{args.grid:g}")),
            ", with --joints, --limit or --speed as you like.",
        )
    elif not (math.isfinite(args.grid) and args.grid > 0.0):
        what, cure = (
            f"A grid step of {args.grid:g} deg is not above zero.",
            Advice(NextStep("design", ("--grid", "5"))),
        )
    elif args.speed is not None and not (math.isfinite(args.speed) and args.speed > 0.0):
        what = f"A joint speed of {args.speed:g} deg/s is not above zero."
        cure = "Give a speed such as --speed 30, or leave it out: then it is the servos'."
    elif args.out is not None and args.out.suffix.lower() != ".csv":
        what = f"With --grid, --out writes a table (CSV), and {args.out} does not end with .csv."
        cure = Advice(NextStep("design", ("--grid", f"{args.grid:g}", "--out", "loops.csv")))
    if what:
        raise UsageError(what=what, meaning="Nothing was computed.", next_step=cure)


_USELESS = (
    "joints time-limit speed limit robust penalty seed particles iterations inertia own-best best-of-all "
    "together"
)
_MAX_SHOWN_LESSONS = 3


def show_learning(args: argparse.Namespace, path: Path, out: Output) -> int:
    """Writes the best maneuver to `path`, and the pair next to it where that is another one.

    Raises:
        UsageError: an option does not fit, or the robot is none that the boards fly.
    """
    from tfsat_host.rehearsal.learning import learn
    from tfsat_host.robot import load_robot

    options = _given(_USELESS, args)
    if options:
        raise UsageError(
            what=f"{', '.join(options)}: --learn compares maneuvers that use the whole fall.",
            meaning="Nothing was designed.",
            next_step=Advice(NextStep("design", ("--learn", str(args.learn)))),
        )
    second = path.with_name(f"{path.stem}-2{path.suffix}")
    for target in (path, second):
        check_may_write(target, marker=SEAL, force=args.force)
    robot = load_robot(args.robot)
    with out.progress("Flying and evaluating maneuvers", total=1.0) as advance:
        search = learn(robot, args.learn, advance)
    best = search.lessons[0]
    # The member of the best pair that is not the best single maneuver.
    other = next((lesson for lesson in search.pair if lesson is not best), best)
    files = [sealed_file(path, format_maneuver(best.maneuver))]
    if other is not best:
        files.append(sealed_file(second, format_maneuver(other.maneuver)))
    write_all(files, force=args.force)
    result = _LearningResult(search, [file.path for file in files])

    def show_result() -> None:
        show_rows(_CHOICE, result.choices, out)
        show_facts(_LEARNING, result, out)
        sentences([Advice("Next: ", NextStep("envelope", ("--file", str(path))))], out)

    out.result(record(_LEARNING, result), show_result)
    return 0


@dataclass(frozen=True)
class _Choice:
    """Drops with one maneuver or two, and what uncertainty they leave."""

    name: str
    search: Learnt
    lessons: tuple[Lesson, ...]

    @property
    def rms_std(self) -> float:
        """Root mean square of the standard deviations."""
        return self.search.rms(*self.lessons)


@dataclass(frozen=True)
class _LearningResult:
    """Which maneuvers a drop learns most from, and the files that were written."""

    search: Learnt
    files: list[Path]

    @property
    def choices(self) -> list[_Choice]:
        """What a team may fly: 59/70, the best maneuvers, 59/70 twice, the best pair."""
        search, (first, second) = self.search, self.search.pair
        lessons = {
            search.usual.name: (search.usual,),
            **{lesson.name: (lesson,) for lesson in search.lessons[:_MAX_SHOWN_LESSONS]},
            f"{search.usual.name}, twice": (search.usual, search.usual),
            f"{first.name} and {second.name}": (first, second),
        }
        return [_Choice(name, search, drops) for name, drops in lessons.items()]


_CHOICE: Columns = (
    Column("name", "drops with"),
    Column("drops", of=lambda choice: len(choice.lessons)),
    Column("std", of=lambda choice: choice.search.std(*choice.lessons)),
    Column("rms_std", "posterior σ, rms"),
    Column(
        "", "÷ 59/70's", of=lambda choice: choice.rms_std / choice.search.rms(choice.search.usual), form=".2f"
    ),
)
_LEARNING: Columns = (
    Column(
        "wanted",
        "Wanted",
        of="search.wanted",
        words=lambda result: (
            f"{result.search.wanted}, {len(result.search.names)} numbers, σ in {result.search.unit}"
        ),
    ),
    *fields("unit=search.unit"),
    Column("names", of=lambda result: list(result.search.names)),
    Column("maneuvers", of="choices", columns=_CHOICE),
    Column("compared", "Maneuvers compared", of=lambda result: len(result.search.lessons)),
    Column("files", "Written", of=lambda result: list(result.files)),
)
