"""`tfsat-host campaign`: a folder of numbered drops with an index, notes, a comparison and one report."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.options import add_output_options, file_name, output_file_name
from tfsat_host.cli.subcommands import add_subcommands
from tfsat_host.errors import DataLossError, TfsatError
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import printable, show_rows
from tfsat_host.quantity import UNKNOWN, Column, Columns

if TYPE_CHECKING:
    from tfsat_host.run.campaign.reporting import CampaignReport, OfOneRobot

_ACTIONS = {
    "init": "make a folder a campaign, without drops",
    "add": "copy a run into it as the next drop",
    "list": "all drops with their notes, and whether their recordings are as they came",
    "note": "write something about a drop",
    "void": "take a drop out of the count; its number and its folder stay",
    "next": "the number of the next drop",
    "report": "evaluate all drops, compare them, and lay them over each other in one page",
}


def configure(parser: argparse.ArgumentParser) -> None:
    """The action, the campaign's folder, and what each needs."""
    for name, action in add_subcommands(parser, _ACTIONS).items():
        action.add_argument("dir", metavar="DIR", type=file_name, help="the campaign's folder")
        if name == "add":
            action.add_argument(
                "run", metavar="RUN", type=file_name, help="a folder with a recording, or a recording"
            )
            action.add_argument("--note", metavar="TEXT", help="what is to be remembered of it")
            action.add_argument(
                "--move", action="store_true", help="remove the folder RUN when its copy is in its place"
            )
        elif name in ("note", "void"):
            action.add_argument("number", metavar="N", type=_number, help="of the drop")
            what = "what is to be remembered" if name == "note" else "why it does not count"
            action.add_argument("text", metavar="TEXT", help=f"{what}: one line, in quotes")
        elif name == "report":
            action.add_argument(
                "--robot",
                metavar="FILE",
                type=file_name,
                help="a robot file, or the name of a robot that tfsat brings along (default: robot.toml of the drops, "
                "else drop_tower)",
            )
            action.add_argument(
                "--out",
                metavar="FILE",
                type=output_file_name,
                help="the page (default: report.html in DIR)",
            )
            action.add_argument(
                "--force", action="store_true", help="overwrite a file that this command did not make"
            )
        add_output_options(action)


def run(args: argparse.Namespace, out: Output) -> int:
    """Does what was typed."""
    do = {"init": _init, "add": _add, "list": _list, "note": _note, "void": _void, "next": _next}
    return {**do, "report": _report}[args.action](args, out)


def _number(text: str) -> int:
    """An argparse type. Raises ArgumentTypeError: no number of a drop."""
    digits = text.removeprefix("drop-")
    if not (digits.isascii() and digits.isdigit() and 0 < int(digits[:9]) < 10**6):
        raise argparse.ArgumentTypeError(f"{text!r} is no drop's number: write a whole number from 1")
    return int(digits[:9])


def _init(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.campaign.campaign import INDEX, init

    init(args.dir)
    add = f"tfsat-host campaign add {shlex.quote(str(args.dir))} RUN"
    text = f"Campaign  {args.dir}. The first drop comes in by: {add}"
    out.result({"campaign": str(args.dir), "index": str(args.dir / INDEX)}, text)
    return 0


def _add(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.campaign.adding import add
    from tfsat_host.run.files import EMULATED

    done = add(args.dir, args.run, note=args.note, move=args.move, notices=out)
    entry = done.entry
    copy = "" if done.moved else f", a copy of {args.run}"
    fell = " (EMULATED: no robot fell)" if entry.robot == EMULATED else ""
    facts = {"path": str(done.place), "moved": done.moved, "left_out": done.left_out, "changed": done.changed}
    out.result({**entry.as_dict(), **facts}, f"Drop {entry.number}  {done.place}{copy}{fell}")
    for name, why in done.left_out.items():
        out.warn(f"{printable(name)} {printable(why)}: it was left out.")
    if done.left_out and args.move:
        out.warn(f"{args.run} was not removed: not all of it is in the campaign.")
    return _warned(done.doubts, out)


def _note(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.campaign.campaign import note

    drop = note(args.dir, args.number, args.text)
    out.result(drop.as_dict(), f"Drop {drop.number}  {len(drop.notes)} notes.")
    return 0


def _void(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.campaign.campaign import void

    drop = void(args.dir, args.number, args.text)
    kept = f"{args.dir / drop.folder} stays, and no report counts it"
    out.result(drop.as_dict(), f"Drop {drop.number}  void: {kept}.")
    return 0


def _next(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.campaign.campaign import read
    from tfsat_host.run.campaign.entries import folder_name

    contents = read(args.dir)
    number = contents.next_number
    result = {"number": number, "folder": folder_name(number), "findings": list(contents.findings)}
    out.result(result, str(number))
    return _warned(contents.findings, out)


def _list(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.campaign.campaign import changes_in, read

    contents = read(args.dir)
    rows = [{**drop.as_dict(), "changes": changes_in(args.dir, drop)} for drop in contents.drops]
    result = {
        "campaign": str(args.dir),
        "drops": rows,
        "next": contents.next_number,
        "findings": list(contents.findings),
    }
    out.result(result, lambda: _show_list(rows, out))
    code = _warned(contents.findings, out)
    return DataLossError.exit_code if any(row["changes"] for row in rows) else code


def _show_list(rows: Sequence[dict[str, Any]], out: Output) -> None:
    """The drops, and what of them is not as it came."""
    if not rows:
        out.line("No drops yet.")
        return
    show_rows(_DROPS, rows, out)
    for row in rows:
        for sentence in row["changes"]:
            out.line(f"CHANGED   drop {row['number']}: {printable(sentence)}")


def _remembered(drop: dict[str, Any]) -> str:
    void = [f"VOID: {drop['void']['text']}"] if drop["void"] else []
    return "; ".join([*void, *(note["text"] for note in drop["notes"])]) or UNKNOWN


_DROPS: Columns = (
    Column("number", "drop"),
    Column("robot", "robot"),
    Column("", "released / UTC", words=lambda drop: (drop["released"] or "unknown")[:19].replace("T", " ")),
    Column("recording", "recording"),
    Column("", "id", words=lambda drop: drop["session"] or "unknown"),
    Column("", "as it came", words=lambda drop: "NO" if drop["changes"] else "yes"),
    Column("", "notes", words=_remembered),
)


def _report(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.campaign.reporting import report

    made = report(args.dir, args.robot, args.out, force=args.force, notices=out)
    out.result({"campaign": str(args.dir), **made.as_dict()}, lambda: _show_report(made, out))
    _warned(made.findings, out)
    return 0 if made.good else DataLossError.exit_code


def _show_report(made: CampaignReport, out: Output) -> None:
    """Each drop, why some are left out, what each robot's say together, and the page."""
    from tfsat_host.run.drop_comparison import DROPS, row_of
    from tfsat_host.run.drop_evaluation import dropped_robot

    rows, refused = [], []
    for drop, one in made.tried:
        done = None if isinstance(one, TfsatError) else one
        robot = drop.robot if done is None else dropped_robot(done.found.log).kind
        notes = "; ".join(note.text for note in drop.notes) or UNKNOWN
        rows.append({**row_of(drop.number, done), "robot": robot, "notes": notes})
        if isinstance(one, TfsatError):
            refused.append(f"Drop {drop.number} cannot be evaluated: {one.what} {one.next_step}")
    columns = (DROPS[0], Column("robot", "robot"), *DROPS[1:], Column("notes", "notes"))
    show_rows(columns, rows, out, title="All drops")
    for text in refused:
        out.line(printable(text))
    for drop in made.void:
        why = "" if drop.void is None else f": {printable(drop.void.text)}"
        out.line(f"Drop {drop.number} is void and not counted{why}")
    _show_robots(made.robots, out)
    out.line("No report was written." if made.page is None else f"Written  {printable(made.page)}")


def _show_robots(robots: list[OfOneRobot], out: Output) -> None:
    """What each robot's drops say together, and that robots are kept apart."""
    from tfsat_host.present.evaluation import show_comparison

    if len(robots) > 1:
        out.line(
            f"The drops are of {len(robots)} robots or robot files: none is combined with those of another."
        )
    for robot in robots:
        if robot.compared is not None:
            out.line(f"The drops of the {robot.name} together:")
            tables = robot.compared.tables([f"drop {number}" for number in robot.numbers])
            show_comparison(tables, robot.compared.remarks, out)
        elif len(robots) > 1:
            out.line(f"Drop {robot.numbers[0]} is the only one of the {robot.name}: compared with nothing.")


def _warned(sentences: Sequence[str], out: Output) -> int:
    """The exit code of a command that has these to say."""
    for sentence in sentences:
        out.warn(sentence)
    return DataLossError.exit_code if sentences else 0
