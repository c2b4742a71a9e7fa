"""`tfsat-host evaluate`: from a recorded drop to what the robot did, and what should be corrected."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tfsat_host import __version__
from tfsat_host.cli.options import add_output_options, file_name
from tfsat_host.cli.run_options import add_out, add_run_arguments, options_of
from tfsat_host.errors import DataLossError, TfsatError
from tfsat_host.json_values import jsonable
from tfsat_host.output_files import OutputFile, check_may_write, write_all
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import bullets, printable, show_rows
from tfsat_host.run.files import EVALUATION_MARKER

if TYPE_CHECKING:
    from tfsat_host.run.drop_comparison import Comparison, Tried
    from tfsat_host.run.drop_evaluation import EvaluatedRun


def configure(parser: argparse.ArgumentParser) -> None:
    """The drops, what belongs to them, where to write."""
    parser.description = (
        "Evaluate a drop: strokes, joint angles and attitudes with standard deviations, the model next to them before "
        "and after its correction, and whether the data agree with themselves. docs/evaluation.md explains every "
        "number. Ends with 3 if anything is doubtful."
    )
    add_run_arguments(parser)
    add_out(parser, "write the object of --json to a file, such as evaluation.json", file_name)
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Evaluates each drop; several are compared."""
    from tfsat_host.run.drop_evaluation import evaluate_run, robot_of

    options = options_of(args)
    options.check(args.runs)
    if args.out is not None:
        check_may_write(args.out, marker=EVALUATION_MARKER, force=args.force)
    if len(args.runs) > 1:
        return _run_several(args, out)
    done = evaluate_run(args.runs[0], options, robot_of(options.robot, args.runs), out)
    result = _made(done.as_dict())
    out.result(result, lambda: _show(done, out))
    _write(args, result, out)
    return DataLossError.exit_code if done.verdict.level != "good" else 0


def _run_several(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.drop_comparison import Comparison, Refused, evaluate_several

    tried = evaluate_several(args.runs, options_of(args), out)
    done = [one for one in tried if not isinstance(one, Refused)]
    compared = Comparison.of(done)
    comparison = None if compared is None else compared.as_dict()
    result = _made({"drops": [one.as_dict() for one in tried], "comparison": comparison})
    out.result(result, lambda: _show_several(tried, compared, out))
    _write(args, result, out)
    if len(done) < len(tried):
        return TfsatError.exit_code
    doubtful = any(one.verdict.level != "good" for one in done) or (compared is not None and compared.doubts)
    return DataLossError.exit_code if doubtful else 0


def _show(run: EvaluatedRun, out: Output) -> None:
    from tfsat_host.present.evaluation import show_evaluation

    held = "none"
    when = "at an unknown time of day" if run.recorded is None else f"{run.recorded:%Y-%m-%d %H:%M:%S} UTC"
    if run.held is not None:
        held = f"{run.held.path}, which {'does not hold as it is' if run.held.objections else 'holds'}"
    recording = f"{run.files.recording}, {run.found.log.session:08x}, released {when}"
    maneuver = "unknown" if run.files.maneuver is None else str(run.files.maneuver)
    sources = (("Calibrated", held), ("Maneuver", maneuver))
    show_evaluation(run.found, run.verdict, recording, sources, run.remarks, out)


def _show_several(tried: Sequence[Tried], compared: Comparison | None, out: Output) -> None:
    from tfsat_host.present.evaluation import show_comparison
    from tfsat_host.run.drop_comparison import DROPS, Refused, row_of

    for one in tried:
        out.line(f"== {printable(one.place)}")
        if isinstance(one, Refused):
            out.line(f"Verdict     FAILED. {printable(one.verdict.sentence)}")
            bullets(one.verdict.reasons, out)
        else:
            _show(one, out)
        out.line()
    rows = [row_of(one.place, None if isinstance(one, Refused) else one) for one in tried]
    show_rows(DROPS, rows, out, title="All drops")
    if compared is not None:
        names = [f"drop {number}" for number in range(1, len(compared.runs) + 1)]
        show_comparison(compared.tables(names), compared.remarks, out)


def _made(result: dict[str, Any]) -> dict[str, Any]:
    """With the mark by which the command knows a file of its own."""
    return {"made_by": f"tfsat-host evaluate {__version__}", **result}


def _write(args: argparse.Namespace, result: dict[str, Any], out: Output) -> None:
    if args.out is None:
        return
    text = json.dumps(jsonable(result), indent=1, allow_nan=False) + "\n"
    file = OutputFile(args.out, EVALUATION_MARKER, lambda path: path.write_text(text, encoding="utf-8"))
    write_all([file], force=args.force)
    out.note(f"Written to {printable(args.out)}.")
