"""`tfsat-host evaluate`: from a recorded drop to what the robot did, and what should be corrected."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host import __version__
from tfsat_host.cli.evaluate.options import add_run_arguments, check_run_arguments
from tfsat_host.cli.evaluate.phrases import bullets, printable
from tfsat_host.cli.options import add_output_options, file_name
from tfsat_host.cli.output import Output
from tfsat_host.cli.outputs import OutputFile, check_may_write, write_all
from tfsat_host.errors import DataLossError, TfsatError, UsageError

if TYPE_CHECKING:
    from tfsat_host.cli.evaluate.one_run import EvaluatedRun
    from tfsat_host.cli.evaluate.several import Comparison
    from tfsat_host.evaluation.verdict import Verdict
    from tfsat_host.robot import RobotModel

MARKER = b'"made_by": "tfsat-host evaluate'


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
    from tfsat_host.cli.evaluate.one_run import evaluate_run, robot_of

    check_run_arguments(args)
    if args.out is not None:
        check_may_write(args.out, marker=MARKER, force=args.force)
    robot = robot_of(args, args.runs)
    if len(args.runs) > 1:
        return _run_several(args, robot, out)
    done = evaluate_run(args.runs[0], args, robot, out)
    return _finish_one(args, done, out)


def _finish_one(args: argparse.Namespace, done: EvaluatedRun, out: Output) -> int:
    from tfsat_host.cli.evaluate.result import result_of
    from tfsat_host.cli.evaluate.words import show

    result = _made(result_of(done))
    out.result(result, lambda: show(done, out))
    _write(args, result, out)
    return DataLossError.exit_code if done.verdict.level != "good" else 0


@dataclass(frozen=True, eq=False)
class _Refused:
    """A drop that cannot be evaluated."""

    place: Path
    error: TfsatError
    verdict: Verdict


def _run_several(args: argparse.Namespace, robot: RobotModel, out: Output) -> int:
    """One that is refused does not keep the others from being evaluated. Raises UsageError: one is a copy."""
    from tfsat_host.cli.evaluate.result import refused_as_dict, result_of
    from tfsat_host.cli.evaluate.several import Comparison, comparison_as_dict

    _refuse_copies(args.runs)
    tried = _without_copies([_tried(place, args, robot, out) for place in args.runs])
    done = [one for one in tried if not isinstance(one, _Refused)]
    compared = Comparison(done) if len(done) > 1 else None
    result = _made(
        {
            "drops": [
                refused_as_dict(one.place, one.error, one.verdict)
                if isinstance(one, _Refused)
                else result_of(one)
                for one in tried
            ],
            "comparison": None if compared is None else comparison_as_dict(compared),
        }
    )
    out.result(result, lambda: _show_several(tried, compared, out))
    _write(args, result, out)
    if len(done) < len(tried):
        return TfsatError.exit_code
    doubtful = any(one.verdict.level != "good" for one in done) or (compared is not None and compared.doubts)
    return DataLossError.exit_code if doubtful else 0


def _tried(place: Path, args: argparse.Namespace, robot: RobotModel, out: Output) -> EvaluatedRun | _Refused:
    from tfsat_host.cli.evaluate.one_run import evaluate_run
    from tfsat_host.evaluation.verdict import refused

    try:
        return evaluate_run(place, args, robot, out)
    except TfsatError as error:
        return _Refused(place, error, refused(error))


def _refuse_copies(places: Sequence[Path]) -> None:
    """A drop that is named by two names is named twice, which is found before anything is evaluated."""
    from tfsat_host.cli.evaluate.run_files import run_files
    from tfsat_host.file_hash import sha256_of

    first: dict[str, Path] = {}
    for place in places:
        try:
            sha256 = sha256_of(run_files(place, None).recording)
        except (TfsatError, OSError):
            continue  # refused for that reason when its turn comes
        if sha256 in first:
            raise UsageError(
                what=f"{place} holds the same recording as {first[sha256]}, byte for byte.",
                meaning="One drop says nothing about itself. Nothing was evaluated.",
                next_step="Name each drop once.",
            )
        first[sha256] = place


def _without_copies(tried: list[EvaluatedRun | _Refused]) -> list[EvaluatedRun | _Refused]:
    """The same session in two files, such as one that was cut, is one drop, and would agree with itself."""
    from tfsat_host.evaluation.verdict import refused

    first: dict[int, Path] = {}
    found: list[EvaluatedRun | _Refused] = []
    for one in tried:
        if isinstance(one, _Refused):
            found.append(one)
            continue
        session = one.found.log.session
        if session not in first:
            first[session] = one.place
            found.append(one)
            continue
        error = TfsatError(
            what=f"{one.place} holds the same recording as {first[session]} ({session:08x}).",
            meaning="One drop says nothing about itself: it was left out.",
            next_step="Name each drop once.",
        )
        found.append(_Refused(one.place, error, refused(error)))
    return found


def _show_several(tried: list[EvaluatedRun | _Refused], compared: Comparison | None, out: Output) -> None:
    from tfsat_host.cli.evaluate.several import row_of, show_comparison, show_table
    from tfsat_host.cli.evaluate.words import show

    for one in tried:
        out.line(f"== {printable(one.place)}")
        if isinstance(one, _Refused):
            out.line(f"Verdict     FAILED. {printable(one.verdict.sentence)}")
            bullets(one.verdict.reasons, out)
        else:
            show(one, out)
        out.line()
    unknown = ("failed", "–", "–", "–")
    show_table(
        [(printable(one.place), *unknown) if isinstance(one, _Refused) else row_of(one) for one in tried], out
    )
    if compared is not None:
        show_comparison(compared, out)


def _made(result: dict[str, Any]) -> dict[str, Any]:
    """With the mark by which the command knows a file of its own."""
    return {"made_by": f"tfsat-host evaluate {__version__}", **result}


def _write(args: argparse.Namespace, result: dict[str, Any], out: Output) -> None:
    if args.out is None:
        return
    from tfsat_host.cli.output import jsonable

    text = json.dumps(jsonable(result), indent=1, allow_nan=False) + "\n"
    file = OutputFile(args.out, MARKER, lambda path: path.write_text(text, encoding="utf-8"))
    write_all([file], force=args.force)
    out.note(f"Written to {printable(args.out)}.")
