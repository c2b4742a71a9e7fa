"""`tfsat-host campaign`: a folder of numbered drops with an index, notes, a comparison and one report."""

from __future__ import annotations

import argparse
import shlex
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.options import add_output_options, file_name, output_file_name
from tfsat_host.cli.output import Output
from tfsat_host.cli.subcommands import add_subcommands
from tfsat_host.errors import DataLossError

if TYPE_CHECKING:
    from tfsat_host.campaign.entries import DropEntry

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
    if args.action == "add":
        from tfsat_host.cli.campaign_add import add

        return add(args, out)
    if args.action == "report":
        from tfsat_host.cli.campaign_report import report

        return report(args, out)
    return {"init": _init, "list": _list, "note": _note, "void": _void, "next": _next}[args.action](args, out)


def _number(text: str) -> int:
    """An argparse type. Raises ArgumentTypeError: no number of a drop."""
    digits = text.removeprefix("drop-")
    if not (digits.isascii() and digits.isdigit() and 0 < int(digits[:9]) < 10**6):
        raise argparse.ArgumentTypeError(f"{text!r} is no drop's number: write a whole number from 1")
    return int(digits[:9])


def _init(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.campaign.folder import INDEX, init

    init(args.dir)
    add = f"tfsat-host campaign add {shlex.quote(str(args.dir))} RUN"
    text = f"Campaign  {args.dir}. The first drop comes in by: {add}"
    out.result({"campaign": str(args.dir), "index": str(args.dir / INDEX)}, text)
    return 0


def _note(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.campaign.folder import note
    from tfsat_host.cli.campaign_add import check_note

    folder = shlex.quote(str(args.dir))
    check_note(args.text, f'tfsat-host campaign note {folder} {args.number} "wind from the west"')
    drop = note(args.dir, args.number, args.text, datetime.now(UTC))
    out.result(drop.as_dict(), f"Drop {drop.number}  {len(drop.notes)} notes.")
    return 0


def _void(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.campaign.folder import void
    from tfsat_host.cli.campaign_add import check_note

    folder = shlex.quote(str(args.dir))
    check_note(args.text, f'tfsat-host campaign void {folder} {args.number} "the hook was caught"')
    drop = void(args.dir, args.number, args.text, datetime.now(UTC))
    kept = f"{args.dir / drop.folder} stays, and no report counts it"
    out.result(drop.as_dict(), f"Drop {drop.number}  void: {kept}.")
    return 0


def _next(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.campaign.entries import folder_name
    from tfsat_host.campaign.folder import read

    contents = read(args.dir)
    number = contents.next_number
    result = {"number": number, "folder": folder_name(number), "findings": list(contents.findings)}
    out.result(result, str(number))
    for sentence in contents.findings:
        out.warn(sentence)
    return DataLossError.exit_code if contents.findings else 0


def _list(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.campaign.changes import changes_in
    from tfsat_host.campaign.folder import read

    contents = read(args.dir)
    rows = [(drop, changes_in(args.dir / drop.folder, drop)) for drop in contents.drops]
    result = {
        "campaign": str(args.dir),
        "drops": [{**drop.as_dict(), "changes": changes} for drop, changes in rows],
        "next": contents.next_number,
        "findings": list(contents.findings),
    }
    out.result(result, lambda: _show(rows, out))
    for sentence in contents.findings:
        out.warn(sentence)
    return DataLossError.exit_code if contents.findings or any(changes for _, changes in rows) else 0


def _show(rows: list[tuple[DropEntry, list[str]]], out: Output) -> None:
    from tfsat_host.cli.evaluate.phrases import printable

    if not rows:
        out.line("No drops yet.")
        return
    out.table(
        ("drop", "robot", "released / UTC", "recording", "id", "as it came", "notes"),
        [_row(drop, changes, printable) for drop, changes in rows],
    )
    for drop, changes in rows:
        for sentence in changes:
            out.line(f"CHANGED   drop {drop.number}: {printable(sentence)}")


def _row(drop: DropEntry, changes: list[str], printable: Any) -> tuple[object, ...]:
    return (
        str(drop.number),
        drop.robot,
        "unknown" if drop.released is None else f"{drop.released:%Y-%m-%d %H:%M:%S}",
        printable(drop.recording),
        drop.session or "unknown",
        "NO" if changes else "yes",
        "; ".join(printable(text) for text in _remarks(drop)) or "–",
    )


def _remarks(drop: DropEntry) -> list[str]:
    void = [] if drop.void is None else [f"VOID: {drop.void.text}"]
    return [*void, *(note.text for note in drop.notes)]
