"""`tfsat-host campaign report`: all drops so far evaluated, compared and drawn over each other."""

from __future__ import annotations

import argparse
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.output import Output
from tfsat_host.errors import DataLossError, TfsatError

if TYPE_CHECKING:
    from tfsat_host.campaign.entries import DropEntry
    from tfsat_host.cli.evaluate.one_run import EvaluatedRun
    from tfsat_host.cli.evaluate.several import Comparison

_Tried = tuple["DropEntry", "EvaluatedRun | TfsatError"]


def report(args: argparse.Namespace, out: Output) -> int:
    """A drop that cannot be evaluated is named and does not keep the others from being compared.

    Drops of a robot and of an emulated one are drawn over each other, and never taken together in a number.
    """
    from tfsat_host.campaign.entries import EMULATED, REAL
    from tfsat_host.campaign.folder import read
    from tfsat_host.cli.evaluate.one_run import robot_of
    from tfsat_host.cli.report_files import PAGE, ReportFiles

    contents = read(args.dir)
    counting = [drop for drop in contents.drops if drop.void is None]
    present = [drop for drop in counting if (args.dir / drop.folder / drop.recording).is_file()]
    if not present:
        raise TfsatError(
            what=f"{args.dir} has no drops with a recording that count.",
            meaning="There is nothing to compare; no report was written.",
            next_step=f"tfsat-host campaign add {args.dir} RUN",
        )
    options = _options(args, present, args.out or args.dir / PAGE)
    files = ReportFiles.of(options)
    files.check(force=args.force)
    robot = robot_of(options, options.runs)
    tried = [_tried(drop, args.dir, options, robot, out) for drop in present]
    page, compared = _write(tried, files, options, out)
    real, emulated = (compared.get(robot) for robot in (REAL, EMULATED))
    void = [drop for drop in contents.drops if drop.void is not None]
    result = {
        "campaign": str(args.dir),
        "report": None if page is None else str(page),
        "drops": [_as_dict(one) for one in tried],
        "void": [drop.as_dict() for drop in void],
        "comparison": _comparison(real),
        "comparison_emulated": _comparison(emulated),
        "findings": list(contents.findings),
    }
    out.result(result, lambda: _show(tried, void, compared, page, out))
    for sentence in contents.findings:
        out.warn(sentence)
    good = all(not isinstance(one, TfsatError) and one.verdict.level == "good" for _, one in tried)
    return 0 if good and not contents.findings else DataLossError.exit_code


def _options(args: argparse.Namespace, drops: list[DropEntry], page: Path) -> argparse.Namespace:
    """`report` with all drops."""
    from tfsat_host.cli.campaign_add import no_options

    options = vars(no_options()) | {
        "runs": [args.dir / drop.folder / drop.recording for drop in drops],
        "robot": args.robot,
        "out": page,
        "figures": None,
        "mcap": None,
        "force": args.force,
    }
    return argparse.Namespace(**options)


def _tried(drop: DropEntry, folder: Path, options: argparse.Namespace, robot: Any, out: Output) -> _Tried:
    """A drop that nobody foresaw breaks its own evaluation, and not that of the others."""
    from tfsat_host.cli.evaluate.one_run import evaluate_run

    recording = folder / drop.folder / drop.recording
    try:
        return drop, evaluate_run(recording, options, robot, out)
    except TfsatError as error:
        return drop, error
    except BrokenPipeError:
        raise
    except Exception as error:  # noqa: BLE001  kept with its traceback, told by name, and the report goes on
        from tfsat_host.cli.crash import bug_error

        bug = bug_error(error, ("campaign", "report", str(folder), str(recording)))
        summary = str(error).partition("\n")[0]
        return drop, TfsatError(
            what=f"{type(error).__name__}: {summary}, which tfsat-host did not foresee.",
            meaning="The drop is left out; what is said of the others holds.",
            next_step=bug.next_step,
        )


def _write(
    tried: list[_Tried], files: Any, options: argparse.Namespace, out: Output
) -> tuple[Path | None, dict[str, Comparison]]:
    """The page, of those that can be evaluated, and how they compare: real ones with real ones, emulated likewise."""
    from tfsat_host.cli.evaluate.several import Comparison, robot_in
    from tfsat_host.cli.outputs import new_folder_of, tell_new_folder
    from tfsat_host.cli.report import lacking, reported, together
    from tfsat_host.cli.report_files import PageParts

    done = [(drop, one) for drop, one in tried if not isinstance(one, TfsatError)]
    refused = [(drop, one) for drop, one in tried if isinstance(one, TfsatError)]
    if not done:
        return None, {}
    drops = [reported(_name(drop, one), one, options) for drop, one in done]
    alike = {
        robot: [index for index, (_, one) in enumerate(done) if robot_in(one) == robot]
        for robot in dict.fromkeys(robot_in(one) for _, one in done)
    }
    tables = []
    for robot, which in alike.items():
        of_them = together([drops[index] for index in which], [done[index][1] for index in which])
        for one in of_them:
            one["title"] += f" ({robot})" if len(alike) > 1 else ""
        tables += of_them
    parts = PageParts(tables=tables, lacking=[lacking(Path(drop.folder), one) for drop, one in refused])
    new_folder = new_folder_of(files.page)
    with out.progress("Writing the report", total=1.0) as advance:
        files.write(drops, parts, datetime.now(UTC), force=options.force, progress=advance)
    tell_new_folder(new_folder, out)
    return files.page, {
        robot: Comparison([done[index][1] for index in which])
        for robot, which in alike.items()
        if len(which) > 1
    }


def _name(drop: DropEntry, run: EvaluatedRun) -> str:
    """As the page has it: beside real drops nobody may take an emulated one for another."""
    from tfsat_host.campaign.entries import EMULATED
    from tfsat_host.cli.evaluate.several import robot_in

    return f"{drop.folder} (emulated)" if robot_in(run) == EMULATED else drop.folder


def _comparison(compared: Comparison | None) -> dict[str, Any] | None:
    if compared is None:
        return None
    from tfsat_host.cli.evaluate.several import comparison_as_dict

    return comparison_as_dict(compared)


def _as_dict(tried: _Tried) -> dict[str, Any]:
    from tfsat_host.cli.evaluate.result import result_of
    from tfsat_host.cli.output import error_as_dict

    drop, one = tried
    if isinstance(one, TfsatError):
        return {**drop.as_dict(), "error": error_as_dict(one), "evaluation": None}
    return {**drop.as_dict(), "evaluation": result_of(one)}


def _show(
    tried: list[_Tried],
    void: list[DropEntry],
    compared: dict[str, Comparison],
    page: Path | None,
    out: Output,
) -> None:
    from tfsat_host.cli.evaluate.phrases import printable
    from tfsat_host.cli.evaluate.several import robot_in, row_of, show_comparison

    rows = []
    for drop, one in tried:
        notes = "; ".join(printable(note.text) for note in drop.notes) or "–"
        found = ("failed", "–", "–", "–") if isinstance(one, TfsatError) else row_of(one)[1:]
        robot = drop.robot if isinstance(one, TfsatError) else robot_in(one)
        rows.append((str(drop.number), robot, *found, notes))
    columns = (
        "drop",
        "robot",
        "verdict",
        "reorientation / deg",
        "model off / deg",
        "corrected / deg",
        "notes",
    )
    out.table(columns, rows, title="All drops")
    for drop, one in tried:
        if isinstance(one, TfsatError):
            out.line(
                f"Drop {drop.number} cannot be evaluated: {printable(one.what)} {printable(one.next_step)}"
            )
    for drop in void:
        why = "" if drop.void is None else f": {printable(drop.void.text)}"
        out.line(f"Drop {drop.number} is void and not counted{why}")
    for robot, comparison in compared.items():
        out.line(f"The {robot} drops together:")
        numbers = {id(one): drop.number for drop, one in tried}
        show_comparison(comparison, out, [numbers[id(run)] for run in comparison.runs])
    out.line("No report was written." if page is None else f"Written  {printable(page)}")
