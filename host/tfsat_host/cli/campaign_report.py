"""`tfsat-host campaign report`: all drops so far evaluated, compared and drawn over each other."""

from __future__ import annotations

import argparse
import shlex
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.output import Output
from tfsat_host.errors import DataLossError, TfsatError

if TYPE_CHECKING:
    from tfsat_host.campaign.entries import DropEntry
    from tfsat_host.campaign.folder import Contents
    from tfsat_host.cli.campaign_robots import OfOneRobot
    from tfsat_host.cli.evaluate.one_run import EvaluatedRun

_Tried = tuple["DropEntry", "EvaluatedRun | TfsatError"]


def report(args: argparse.Namespace, out: Output) -> int:
    """A drop that cannot be evaluated is named and does not keep the others from being compared.

    Drops of different robots are drawn over each other, and never taken together in a number.
    """
    from tfsat_host.campaign.folder import read
    from tfsat_host.cli.evaluate.one_run import robot_of
    from tfsat_host.cli.report_files import PAGE, ReportFiles

    contents = read(args.dir)
    counting = [drop for drop in contents.drops if drop.void is None]
    present = [drop for drop in counting if (args.dir / drop.folder / drop.recording).is_file()]
    if not present:
        raise _nothing_to_compare(args.dir, contents)
    options = _options(args, present, args.out or args.dir / PAGE)
    files = ReportFiles.of(options)
    files.check(force=args.force)
    if args.robot is not None:
        robot_of(options)  # one that cannot be read is no drop's fault
    tried = [_tried(drop, args.dir, options, out) for drop in present]
    page, robots = _write(tried, files, options, out)
    void = [drop for drop in contents.drops if drop.void is not None]
    result = {
        "campaign": str(args.dir),
        "report": None if page is None else str(page),
        "drops": [_as_dict(one) for one in tried],
        "void": [drop.as_dict() for drop in void],
        "comparisons": [robot.as_dict() for robot in robots],
        "findings": list(contents.findings),
    }
    out.result(result, lambda: _show(tried, void, robots, page, out))
    for sentence in contents.findings:
        out.warn(sentence)
    good = all(not isinstance(one, TfsatError) and one.verdict.level == "good" for _, one in tried)
    agree = not any(robot.compared is not None and robot.compared.doubts for robot in robots)
    return 0 if good and agree and not contents.findings else DataLossError.exit_code


def _nothing_to_compare(folder: Path, contents: Contents) -> TfsatError:
    """With what is wrong with the campaign: drops that it does not know any more are not none."""
    wrong = " ".join(contents.findings)
    place = shlex.quote(str(folder))
    return TfsatError(
        what=f"{folder} has no drops with a recording that count.{f' {wrong}' if wrong else ''}",
        meaning="There is nothing to compare; no report was written.",
        next_step=f"Copy {folder} back from where it is whole. What is left of it: tfsat-host campaign list {place}"
        if wrong
        else f"tfsat-host campaign add {place} RUN",
    )


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


def _tried(drop: DropEntry, folder: Path, options: argparse.Namespace, out: Output) -> _Tried:
    """A drop that nobody foresaw breaks its own evaluation, and not that of the others."""
    from tfsat_host.cli.evaluate.one_run import evaluate_run, robot_of

    recording = folder / drop.folder / drop.recording
    try:
        _require_as_it_came(drop, folder)
        return drop, evaluate_run(recording, options, robot_of(options, [recording]), out)
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


def _require_as_it_came(drop: DropEntry, folder: Path) -> None:
    """Raises TfsatError: what it would be evaluated with may not be what flew."""
    from tfsat_host.campaign.changes import changes_in

    changes = changes_in(folder / drop.folder, drop)
    if changes:
        raise TfsatError(
            what=f"It is not as it came into the campaign: {' '.join(changes)}",
            meaning="What was changed is no evidence of the drop: it is left out; what is said of the others holds.",
            next_step="Put the file back as it was. If the change is meant: copy the drop's folder to another place, "
            f"tfsat-host campaign void {shlex.quote(str(folder))} {drop.number}, then campaign add the copy.",
        )


def _write(
    tried: list[_Tried], files: Any, options: argparse.Namespace, out: Output
) -> tuple[Path | None, list[OfOneRobot]]:
    """The page, of those that can be evaluated, and each robot's drops by themselves."""
    from tfsat_host.cli.campaign_robots import by_robot
    from tfsat_host.cli.outputs import new_folder_of, tell_new_folder
    from tfsat_host.cli.report import lacking, reported, together
    from tfsat_host.cli.report_files import PageParts

    done = [(drop, one) for drop, one in tried if not isinstance(one, TfsatError)]
    refused = [(drop, one) for drop, one in tried if isinstance(one, TfsatError)]
    if not done:
        return None, []
    drops = {drop.number: reported(_name(drop, one), one, options) for drop, one in done}
    robots = by_robot([(drop.number, one) for drop, one in done])
    tables = []
    for robot in robots:
        if robot.compared is not None:
            of_them = together([drops[number] for number in robot.numbers], robot.compared)
            for table in of_them:
                table["title"] += f" ({robot.name})" if len(robots) > 1 else ""
            tables += of_them
    parts = PageParts(tables=tables, lacking=[lacking(Path(drop.folder), one) for drop, one in refused])
    new_folder = new_folder_of(files.page)
    with out.progress("Writing the report", total=1.0) as advance:
        files.write(list(drops.values()), parts, datetime.now(UTC), force=options.force, progress=advance)
    tell_new_folder(new_folder, out)
    return files.page, robots


def _name(drop: DropEntry, run: EvaluatedRun) -> str:
    """As the page has it: beside real drops nobody may take an emulated one for another."""
    from tfsat_host.campaign.entries import EMULATED
    from tfsat_host.cli.evaluate.dropped_robot import dropped_robot

    emulated = dropped_robot(run.found.log).kind == EMULATED
    return f"{drop.folder} (emulated)" if emulated else drop.folder


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
    robots: list[OfOneRobot],
    page: Path | None,
    out: Output,
) -> None:
    from tfsat_host.cli.campaign_robots import show_robots
    from tfsat_host.cli.evaluate.phrases import printable

    _show_drops(tried, out)
    for drop, one in tried:
        if isinstance(one, TfsatError):
            out.line(
                f"Drop {drop.number} cannot be evaluated: {printable(one.what)} {printable(one.next_step)}"
            )
    for drop in void:
        why = "" if drop.void is None else f": {printable(drop.void.text)}"
        out.line(f"Drop {drop.number} is void and not counted{why}")
    show_robots(robots, out)
    out.line("No report was written." if page is None else f"Written  {printable(page)}")


def _show_drops(tried: list[_Tried], out: Output) -> None:
    from tfsat_host.cli.evaluate.dropped_robot import dropped_robot
    from tfsat_host.cli.evaluate.phrases import printable
    from tfsat_host.cli.evaluate.several import row_of

    rows = []
    for drop, one in tried:
        notes = "; ".join(printable(note.text) for note in drop.notes) or "–"
        found = ("failed", "–", "–", "–") if isinstance(one, TfsatError) else row_of(one)[1:]
        robot = drop.robot if isinstance(one, TfsatError) else dropped_robot(one.found.log).kind
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
