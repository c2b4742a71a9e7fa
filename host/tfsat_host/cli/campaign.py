"""`tfsat-host campaign`: a folder of numbered drops with an index, notes, a comparison and one report."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.usage import FORCE, OUTPUT, add_actions, drop_number, output_file_name
from tfsat_host.exit_code import ExitCode
from tfsat_host.next_step import NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import printable, show_rows

if TYPE_CHECKING:
    from tfsat_host.run.campaign.campaign_report import CampaignReport

_ACTIONS = f"""
init    make a folder a campaign, without drops
add     copy a run into it as the next drop
    RUN          a folder with a recording, or a recording
    --note TEXT  what is to be remembered of it
    --move       remove the folder RUN when its copy is in its place
list    all drops with their notes, and whether their recordings are as they came
note    write something about a drop
    N     of the drop
    TEXT  what is to be remembered: one line, in quotes
void    take a drop out of the count; its number and its folder stay
    N     of the drop
    TEXT  why it does not count: one line, in quotes
next    the number of the next drop
report  evaluate all drops, compare them, and lay them over each other in one page
    --robot FILE  a robot file, or a shipped robot's name (default: robot.toml of the drops, else drop_tower)
    --out FILE    the page (default: report.html in DIR)
    {FORCE}
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the actions, the campaign's folder, and the options of each action."""
    number = {"type": drop_number, "dest": "number"}
    add_actions(parser, _ACTIONS, "DIR  the campaign's folder", OUTPUT, n=number, out=output_file_name)


def run(args: argparse.Namespace, out: Output) -> int:
    """Does what was typed."""
    from tfsat_host.run.campaign import campaign_folder

    match args.action:
        case "init":
            campaign_folder.init(args.dir)
            add = f"The first drop comes in by: {NextStep('campaign add', (str(args.dir), 'RUN'))}"
            result = {"campaign": str(args.dir), "index": str(args.dir / campaign_folder.INDEX)}
            out.result(result, f"Campaign  {args.dir}. {add}")
        case "add":
            from tfsat_host.run.campaign.adding import add as add_run

            added = add_run(args.dir, args.run, note=args.note, move=args.move, notices=out)
            out.result(added.as_dict(), added.sentence)
            return _warn_and_exit_code(added.doubts, out)
        case "note":
            drop = campaign_folder.note(args.dir, args.number, args.text)
            out.result(drop.as_dict(), f"Drop {drop.number}  {len(drop.notes)} notes.")
        case "void":
            drop = campaign_folder.void(args.dir, args.number, args.text)
            out.result(drop.as_dict(), f"Drop {drop.number}  void: {args.dir / drop.folder} is not counted.")
        case "next":
            following = campaign_folder.next_drop(args.dir)
            out.result(following, str(following["number"]))
            return _warn_and_exit_code(following["findings"], out)
        case action:
            return {"list": _list, "report": _report}[action](args, out)
    return 0


def _list(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.campaign.campaign_folder import list_drops

    listed = list_drops(args.dir)
    drops = listed["drops"]

    out.result(listed, lambda: _show_list(drops, out))
    return _warn_and_exit_code(listed["findings"], out) or ExitCode.DATA_LOSS * any(
        drop["changes"] for drop in drops
    )


def _show_list(drops: Sequence[dict[str, Any]], out: Output) -> None:
    from tfsat_host.run.campaign.campaign_folder import LISTED

    if drops:
        show_rows(LISTED, drops, out)
    else:
        out.line("No drops yet.")
    for number, sentence in ((drop["number"], change) for drop in drops for change in drop["changes"]):
        out.line(f"CHANGED   drop {number}: {printable(sentence)}")


def _report(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.campaign.campaign_report import report

    campaign_report = report(args.dir, args.robot, args.out, force=args.force, notices=out)
    out.result(
        {"campaign": str(args.dir), **campaign_report.as_dict()}, lambda: _show_report(campaign_report, out)
    )
    return _warn_and_exit_code(campaign_report.findings, out) or (
        0 if campaign_report.good else ExitCode.DATA_LOSS
    )


def _show_report(campaign_report: CampaignReport, out: Output) -> None:
    """Print the drops, why some are left out, each robot's combined results, and the report's path."""
    from tfsat_host.present.evaluation_text import show_comparison
    from tfsat_host.run.campaign.campaign_report import DROPS_OF_ALL

    show_rows(DROPS_OF_ALL, campaign_report.rows(), out, title="All drops")
    for sentence in campaign_report.sentences():
        out.line(printable(sentence))
    for robot in campaign_report.robots:
        if robot.compared is not None:
            out.line(f"The drops of the {robot.name} together:")
            show_comparison(robot.tables(), robot.compared.remarks, out)
    out.line(
        "No report was written."
        if campaign_report.page is None
        else f"Written  {printable(campaign_report.page)}"
    )


def _warn_and_exit_code(sentences: Sequence[str], out: Output) -> int:
    """Warn with these sentences and return the exit code they call for."""
    out.warn_each(sentences)
    return ExitCode.DATA_LOSS if sentences else 0
