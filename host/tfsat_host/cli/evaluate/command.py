"""`tfsat-host evaluate`: from a recorded drop to what the robot did, and what should be corrected."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tfsat_host import __version__
from tfsat_host.cli.evaluate.options import add_run_arguments, options_of
from tfsat_host.cli.options import add_output_options, file_name
from tfsat_host.errors import DataLossError, TfsatError
from tfsat_host.json_values import jsonable
from tfsat_host.output_files import OutputFile, check_may_write, write_all
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import bullets, printable, show_rows
from tfsat_host.run.files import EVALUATION_MARKER

if TYPE_CHECKING:
    from tfsat_host.run.several import Comparison, Tried


def configure(parser: argparse.ArgumentParser) -> None:
    """The drops, what belongs to them, where to write."""
    parser.description = (
        "Evaluate a drop: strokes, joint angles and attitudes with standard deviations, the model beside them before "
        "and after its correction, and whether the data agree with themselves. docs/evaluation.md explains every "
        "number. Ends with 3 if anything is doubtful."
    )
    add_run_arguments(parser)
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=file_name,
        help="write the object of --json to a file, such as evaluation.json",
    )
    parser.add_argument(
        "--force", action="store_true", help="overwrite a file that this command did not make"
    )
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Evaluates each drop; several are compared."""
    from tfsat_host.cli.evaluate.words import show
    from tfsat_host.run.evaluated import evaluate_run, result_of, robot_of

    options = options_of(args)
    options.check(args.runs)
    if args.out is not None:
        check_may_write(args.out, marker=EVALUATION_MARKER, force=args.force)
    if len(args.runs) > 1:
        return _run_several(args, out)
    done = evaluate_run(args.runs[0], options, robot_of(options.robot, args.runs), out)
    result = _made(result_of(done))
    out.result(result, lambda: show(done, out))
    _write(args, result, out)
    return DataLossError.exit_code if done.verdict.level != "good" else 0


def _run_several(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.cli.evaluate.several import comparison_as_dict
    from tfsat_host.run.evaluated import refused_as_dict, result_of
    from tfsat_host.run.several import Comparison, Refused, evaluate_several

    tried = evaluate_several(args.runs, options_of(args), out)
    done = [one for one in tried if not isinstance(one, Refused)]
    compared = Comparison.of(done)
    drops = [
        refused_as_dict(one.place, one.error, one.verdict) if isinstance(one, Refused) else result_of(one)
        for one in tried
    ]
    comparison = None if compared is None else comparison_as_dict(compared)
    result = _made({"drops": drops, "comparison": comparison})
    out.result(result, lambda: _show_several(tried, compared, out))
    _write(args, result, out)
    if len(done) < len(tried):
        return TfsatError.exit_code
    doubtful = any(one.verdict.level != "good" for one in done) or (compared is not None and compared.doubts)
    return DataLossError.exit_code if doubtful else 0


def _show_several(tried: Sequence[Tried], compared: Comparison | None, out: Output) -> None:
    from tfsat_host.cli.evaluate.several import DROPS, row_of, show_comparison
    from tfsat_host.cli.evaluate.words import show
    from tfsat_host.run.several import Refused

    for one in tried:
        out.line(f"== {printable(one.place)}")
        if isinstance(one, Refused):
            out.line(f"Verdict     FAILED. {printable(one.verdict.sentence)}")
            bullets(one.verdict.reasons, out)
        else:
            show(one, out)
        out.line()
    rows = [row_of(one.place, None if isinstance(one, Refused) else one) for one in tried]
    show_rows(DROPS, rows, out, title="All drops")
    if compared is not None:
        show_comparison(compared, out)


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
