"""`tfsat-host report`: an evaluated drop, or several, as one page; on demand as figures and as an MCAP file."""

from __future__ import annotations

import argparse
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.evaluate.options import add_run_arguments, check_run_arguments, options_given
from tfsat_host.cli.evaluate.several import Comparison
from tfsat_host.cli.options import add_output_options, file_name, output_file_name
from tfsat_host.cli.output import Output
from tfsat_host.cli.outputs import new_folder_of, tell_new_folder
from tfsat_host.cli.report_files import BESIDE, PageParts, ReportFiles
from tfsat_host.errors import DataLossError, TfsatError, UsageError
from tfsat_host.file_hash import sha256_of

if TYPE_CHECKING:
    from tfsat_host.cli.evaluate.one_run import EvaluatedRun
    from tfsat_host.report.contents.reported import Reported
    from tfsat_host.report.document import Table


def configure(parser: argparse.ArgumentParser) -> None:
    """What `evaluate` takes, and what to write."""
    parser.description = (
        "Evaluate a drop as `evaluate` does and write one HTML page that needs no network: verdict, numbers with "
        "standard deviations, linked plots, a replay of the robot beside the model's prediction, tables. Several drops "
        "lie over each other in one page. Ends with 3 if anything is doubtful."
    )
    add_run_arguments(parser)
    files = parser.add_argument_group("files")
    files.add_argument(
        "--out",
        metavar="FILE",
        type=output_file_name,
        help="the page (default: report.html in the folder of the recording; of several drops, here)",
    )
    files.add_argument(
        "--figures",
        metavar="DIR",
        type=file_name,
        help="also write the figures of a paper, as PDF and PNG, into this folder (needs the extra `figures`)",
    )
    files.add_argument(
        "--mcap",
        metavar="FILE",
        nargs="?",
        const=BESIDE,
        type=file_name,
        help="also write the evaluated drop for Foxglove, PlotJuggler and Rerun (needs the extra `mcap`; without FILE: "
        "a file beside each recording, such as SD.evaluated.mcap). Give RUN first, or --mcap=FILE",
    )
    files.add_argument("--force", action="store_true", help="overwrite files that this command did not make")
    add_output_options(parser)


def run(args: argparse.Namespace, out: Output) -> int:
    """Evaluates each drop, draws, writes."""
    from tfsat_host.cli.evaluate.one_run import robot_of

    check_run_arguments(args)
    _check_mcap(args)
    files = ReportFiles.of(args)
    files.check(force=args.force)
    robot = robot_of(args, args.runs)
    done, refused = [], []
    for place in args.runs:
        try:
            done.append(_evaluated(place, args, robot, out))
        except TfsatError as error:
            if len(args.runs) == 1:
                raise
            refused.append((place, error))
    for place, refusal in refused:
        out.warn(f"{place} is not in the report. {refusal.what} {refusal.meaning} {refusal.next_step}")
    if not done:
        raise TfsatError(
            what="None of the drops can be evaluated.",
            meaning="No report was written.",
            next_step=f"Look at the first alone: tfsat-host evaluate {args.runs[0]}",
        )
    return _finish(done, refused, files, args, out)


def report_on(
    args: argparse.Namespace, out: Output, made_at: datetime | None = None
) -> tuple[EvaluatedRun, list[Path]]:
    """Evaluates one drop and writes its page, for a command that wants both; what it was worth, and the files.

    Args:
        args: Of a parser with `configure`, one RUN typed.
        out: For progress.
        made_at: The time that the page gives; None: the computer's.

    Raises:
        TfsatError: it cannot be evaluated.
    """
    from tfsat_host.cli.evaluate.one_run import robot_of

    check_run_arguments(args)
    files = ReportFiles.of(args)
    done = _evaluated(args.runs[0], args, robot_of(args, args.runs), out)
    drop = reported(files.drops[done.files.recording].name, done, args)
    return done, files.write(
        [drop], PageParts(), made_at or datetime.now(UTC), force=args.force, progress=lambda _: None
    )


def _check_mcap(args: argparse.Namespace) -> None:
    if len(args.runs) > 1 and args.mcap not in (None, BESIDE):
        raise UsageError(
            what=f"--mcap names one file, and {len(args.runs)} drops were named.",
            meaning="Nothing was evaluated.",
            next_step="Leave out the name: each file then lies beside its recording.",
        )


def _evaluated(place: Path, args: argparse.Namespace, robot: Any, out: Output) -> EvaluatedRun:
    from tfsat_host.cli.evaluate.one_run import evaluate_run

    return evaluate_run(place, args, robot, out)


def _finish(
    done: list[EvaluatedRun],
    refused: list[tuple[Path, TfsatError]],
    files: ReportFiles,
    args: argparse.Namespace,
    out: Output,
) -> int:
    drops = [reported(files.drops[one.files.recording].name, one, args) for one in done]
    compared = Comparison(done) if len(done) > 1 else None
    tables = [] if compared is None else together(drops, compared)
    page = PageParts(tables=tables, lacking=[lacking(*one) for one in refused])
    new_folder = new_folder_of(files.page)
    with out.progress("Writing the report", total=1.0) as advance:
        written = files.write(drops, page, datetime.now(UTC), force=args.force, progress=advance)
    tell_new_folder(new_folder, out)
    result = {
        "report": str(files.page),
        "files": [str(path) for path in written],
        "drops": [_drop_as_dict(drop, one) for drop, one in zip(drops, done, strict=True)],
        "refused": [{"run": str(place), "what": error.what} for place, error in refused],
    }
    out.result(result, lambda: _show(drops, written, out))
    doubts = () if compared is None else compared.doubts
    for sentence in doubts:
        out.warn(sentence)
    if refused:
        return TfsatError.exit_code
    return DataLossError.exit_code if doubts or any(one.verdict.level != "good" for one in done) else 0


def reported(name: str, run: EvaluatedRun, args: argparse.Namespace) -> Reported:
    """A drop as a page has it; `args` of a parser with `add_run_arguments`."""
    from tfsat_host.report.contents.reported import Reported, Source

    certificate = None if run.held is None else run.held.path
    sha256 = sha256_of(run.files.recording)
    files = {
        "file of the robot": run.found.model.path,
        "file of the calibration": certificate,
        "file of the maneuver": run.files.maneuver,
        "video": args.video,
        "laser spots": args.laser,
        "facility": args.facility,
    }
    sources = [Source.of(what, path) for what, path in files.items() if path is not None and path.is_file()]
    return Reported(
        name, run.found, run.verdict, sha256, certificate, run.remarks, tuple(sources), options_given(args)
    )


def together(drops: list[Reported], compared: Comparison) -> list[Table]:
    """What several drops say of the model together; `drops` are those that are compared, in order."""
    from tfsat_host.report.contents.tables.together import combined_table, cross_validation_table

    names = {str(run.place): drop.name for run, drop in zip(compared.runs, drops, strict=True)}
    if compared.combined is None:
        return []
    found = [drop.evaluation for drop in drops]
    return [
        combined_table(found, list(names.values()), compared.combined, compared.remarks),
        cross_validation_table(compared.left_out, [names[one.name] for one in compared.left_out]),
    ]


def lacking(place: Path, refusal: TfsatError) -> str:
    """Why a drop is not in the page."""
    return f"{place} could not be evaluated: {refusal.what} {refusal.next_step}"


def _drop_as_dict(drop: Reported, run: EvaluatedRun) -> dict[str, Any]:
    verdict = drop.verdict
    return {
        "name": drop.name,
        "run": str(run.place),
        "verdict": {
            "level": verdict.level,
            "sentence": verdict.sentence,
            "reasons": list(verdict.reasons),
        },
    }


def _show(drops: list[Reported], written: list[Path], out: Output) -> None:
    from tfsat_host.cli.evaluate.phrases import printable

    for drop in drops:
        out.line(f"{printable(drop.name)}: {drop.verdict.level.upper()}. {printable(drop.verdict.sentence)}")
    for path in written:
        out.line(f"Written  {printable(path)}")
