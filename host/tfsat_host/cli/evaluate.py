"""`tfsat-host evaluate`: from a recorded drop to what the robot did, and what should be corrected."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.next_steps import advise_on_drop
from tfsat_host.cli.run_options import RUNS, options_of
from tfsat_host.cli.usage import FORCE, OUTPUT, add_options, output_file_name
from tfsat_host.errors import UsageError
from tfsat_host.exit_code import ExitCode
from tfsat_host.json_values import format_json, jsonable
from tfsat_host.next_step import NextStep
from tfsat_host.output_files import check_may_write, write_text
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import bullets, printable, show_rows
from tfsat_host.quantity import Column, record
from tfsat_host.run.files import CORRECTED_MARKER, EVALUATION_MARKER

if TYPE_CHECKING:
    from tfsat_host.run.drop_comparison import Comparison, Tried
    from tfsat_host.run.drop_evaluation import EvaluatedRun


_USAGE = f"""
Evaluate a drop: strokes, joint angles and attitudes with standard deviations, the model next to them before and after
its correction, and whether the data agree with themselves. docs/evaluation.md explains every number. Ends with 3 if
anything is doubtful.

{RUNS}
options:
--full                  every number and table, not one screen
--out FILE              write the object of --json to a file, such as evaluation.json
{FORCE}
--corrected-robot FILE  write the robot file as the drop corrects it, each change with its ±: for `simulate --robot
                        FILE`
{OUTPUT}"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the drops, the files that belong to them, and the output options."""
    add_options(parser, _USAGE, corrected_robot=output_file_name)


def run(args: argparse.Namespace, out: Output) -> int:
    """Evaluates each drop; several are compared."""
    from tfsat_host.run.drop_evaluation import EVALUATED_RUN, MADE_BY, evaluate_run, robot_of

    options, robot_file = options_of(args), args.corrected_robot
    options.check(args.runs)
    if robot_file is not None and len(args.runs) > 1:
        raise UsageError(
            what=f"--corrected-robot is of one drop, and {len(args.runs)} were named.",
            meaning="Nothing was evaluated.",
            next_step="Correct the robot by one drop, then evaluate the next one with --robot FILE.",
        )
    for path, marker, option in (
        (args.out, EVALUATION_MARKER, "--out"),
        (robot_file, CORRECTED_MARKER, "--corrected-robot"),
    ):
        if path is not None:
            check_may_write(path, marker=marker, force=args.force, option=option)
    if len(args.runs) > 1:
        return _run_several(args, out)
    evaluated_run = evaluate_run(args.runs[0], options, robot_of(options.robot, args.runs), out)
    result = jsonable(record((*MADE_BY, *EVALUATED_RUN), evaluated_run), out.complete)
    out.result(result, lambda: _show(evaluated_run, args, out))
    _write(args, result, out)
    if robot_file is not None:
        from tfsat_host.run.corrected_robot import corrected_robot

        text, path_text = corrected_robot(evaluated_run.found, evaluated_run.recorded), printable(robot_file)
        write_text(robot_file, CORRECTED_MARKER, text, force=args.force)
        flown = evaluated_run.files.maneuver
        maneuver = ("59", "70") if flown is None else ("--file", printable(flown))
        out.note(f"Written: {path_text}\nNext: {NextStep('simulate', (*maneuver, '--robot', path_text))}")
    return ExitCode.DATA_LOSS if evaluated_run.verdict.level != "good" else 0


def _run_several(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.evaluation.result.comparison_result import COMPARISON
    from tfsat_host.run.drop_comparison import Comparison, Refused, evaluate_several, tried_columns
    from tfsat_host.run.drop_evaluation import MADE_BY

    tried = evaluate_several(args.runs, options_of(args), out)
    evaluated_runs = [attempt for attempt in tried if not isinstance(attempt, Refused)]
    compared = Comparison.of(evaluated_runs)
    drops = []
    for attempt in tried:
        advise_on_drop(attempt.place, args, out)
        drops.append(jsonable(record(tried_columns(attempt), attempt), out.complete))
    columns = (
        *MADE_BY,
        Column("drops", of=lambda _: drops),
        Column("comparison", of=lambda compared: compared, columns=COMPARISON),
    )
    result = record(columns, compared)
    out.result(result, lambda: _show_several(tried, compared, args, out))
    _write(args, result, out)
    if len(evaluated_runs) < len(tried):
        return ExitCode.FAILED
    doubtful = any(run.verdict.level != "good" for run in evaluated_runs) or (
        compared is not None and compared.doubts
    )
    return ExitCode.DATA_LOSS if doubtful else 0


def _show(run: EvaluatedRun, args: argparse.Namespace, out: Output) -> None:
    from tfsat_host.present.evaluation_text import show_evaluation
    from tfsat_host.robot.absent_parts import list_absent

    calibration = "none"
    when = "at an unknown time of day" if run.recorded is None else f"{run.recorded:%Y-%m-%d %H:%M:%S} UTC"
    if run.held is not None:
        calibration = f"{run.held.path} ({'not valid for this drop' if run.held.objections else 'valid'})"
    recording = f"{run.files.recording}, {run.found.log.session:08x}, released {when}"
    maneuver = "unknown" if run.files.maneuver is None else str(run.files.maneuver)
    typed = [word for option in options_of(args).as_arguments() for word in option.split(" ", 1)]
    more = None if args.full else NextStep("evaluate", (str(run.place), *typed, "--full"))
    absent = list_absent(run.found.model)
    sources = (
        ("Calibration", calibration),
        ("Maneuver", maneuver),
        *((("Absent", ", ".join(absent)),) if absent else ()),
    )
    show_evaluation(run.found, run.verdict, recording, sources, run.remarks, out, more=more)


def _show_several(
    tried: Sequence[Tried], compared: Comparison | None, args: argparse.Namespace, out: Output
) -> None:
    from tfsat_host.present.evaluation_text import show_comparison, show_verdict
    from tfsat_host.run.drop_comparison import DROPS, DropSummary, Refused

    for attempt in tried:
        out.line(f"== {printable(attempt.place)}")
        advise_on_drop(attempt.place, args, out)
        if isinstance(attempt, Refused):
            show_verdict(attempt.verdict, attempt.verdict.line(), out)
            bullets(attempt.verdict.reasons, out)
        else:
            _show(attempt, args, out)
        out.line()
    rows = [
        DropSummary(str(attempt.place), None if isinstance(attempt, Refused) else attempt)
        for attempt in tried
    ]
    show_rows(DROPS, rows, out, title="All drops")
    if compared is not None:
        names = [str(run.place) for run in compared.runs]
        show_comparison(compared.tables(names), compared.remarks, out)


def _write(args: argparse.Namespace, result: Mapping[str, Any], out: Output) -> None:
    if args.out is not None:
        write_text(args.out, EVALUATION_MARKER, format_json(result), force=args.force)
        out.note(f"Written: {printable(args.out)}")
