"""`tfsat-host campaign`: a folder of numbered drops with an index, notes, a comparison and one report."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.usage import FORCE, OUTPUT, add_actions, drop_number, output_file_name
from tfsat_host.exit_code import ExitCode
from tfsat_host.next_step import NextStep
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import list_facts, sentences, show_rows
from tfsat_host.quantity import record
from tfsat_host.run.campaign.entries import ENTRY

if TYPE_CHECKING:
    from tfsat_host.run.campaign.campaign_folder import CampaignList
    from tfsat_host.run.campaign.campaign_report import CampaignReport

_FAULTS = "index or folders MODIFIED (see the warnings)"
_ACTIONS = f"""
init    make a folder a campaign, without drops
add     copy a run into it as the next drop
    RUN          a folder with a recording, or a recording
    --note TEXT  a note on the drop
    --move       remove the folder RUN when its copy is in its place
list    all drops with their notes, and whether their recordings are unmodified
note    add a note to a drop
    N     number of the drop
    TEXT  the note: one line, in quotes
void    take a drop out of the count; its number and its folder stay
    N     number of the drop
    TEXT  the reason: one line, in quotes
next    the number of the next drop
report  evaluate all drops, compare them, and write one page with all of them
    --robot FILE  a robot file, or a shipped robot's name (default: robot.toml of the drops, else drop_tower)
    --laser NAME     file in each drop's folder with the places of its laser spots, such as laser.csv; a drop without it
                     is evaluated without release velocity
    --facility FILE  the permitted release velocity (default: COSMOTORRE's)
    --out FILE    the page (default: report.html in DIR)
    {FORCE}
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the actions, the campaign's folder, and the options of each action."""
    number = {"type": drop_number, "dest": "number"}
    add_actions(
        parser,
        _ACTIONS,
        "DIR  the campaign's folder",
        OUTPUT,
        n=number,
        name=str,
        laser=Path,
        out=output_file_name,
    )


def run(args: argparse.Namespace, out: Output) -> int:
    """Does what was typed."""
    from tfsat_host.run.campaign import campaign_folder

    match args.action:
        case "init":
            campaign_folder.init(args.dir)
            first = NextStep("campaign add", (str(args.dir), "RUN"))
            result = {"campaign": str(args.dir), "index": str(args.dir / campaign_folder.INDEX)}
            out.result(result, f"Campaign: {args.dir} (no drops)\nNext: {first}")
        case "add":
            from tfsat_host.run.campaign.adding import ADDED
            from tfsat_host.run.campaign.adding import add as add_run

            added = add_run(args.dir, args.run, note=args.note, move=args.move, notices=out)
            out.result(record(ADDED, added), added.sentence)
            return _warn_and_exit_code(added.doubts, out)
        case "note":
            drop = campaign_folder.note(args.dir, args.number, args.text)
            count = len(drop.notes)
            out.result(record(ENTRY, drop), f"Drop {drop.number}: {count} note{'' if count == 1 else 's'}")
        case "void":
            drop = campaign_folder.void(args.dir, args.number, args.text)
            out.result(
                record(ENTRY, drop), f"Drop {drop.number}: void ({args.dir / drop.folder} is not counted)"
            )
        case "next":
            contents = campaign_folder.read(args.dir)
            out.result(record(campaign_folder.NEXT, contents), str(contents.next_number))
            return _warn_and_exit_code(contents.findings, out)
        case action:
            return {"list": _list, "report": _report}[action](args, out)
    return 0


def _list(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.campaign.campaign_folder import LIST, list_drops

    campaign = list_drops(args.dir)
    out.result(record(LIST, campaign), lambda: _show_list(campaign, out))
    changed = any(drop.changes for drop in campaign.drops)
    return _warn_and_exit_code(campaign.contents.findings, out) or ExitCode.DATA_LOSS * changed


def _show_list(campaign: CampaignList, out: Output) -> None:
    from tfsat_host.run.campaign.campaign_folder import LISTED

    if not campaign.drops:
        out.line(f"Campaign: {campaign.folder} (no drops)")
        return
    count, changed = len(campaign.drops), sum(bool(drop.changes) for drop in campaign.drops)
    gone = sum(drop.gone for drop in campaign.drops)
    void = sum(drop.entry.void is not None for drop in campaign.drops)
    counted = f"{count} drop{'' if count == 1 else 's'}" + (f", {void} void" if void else "")
    states = [f"{gone} GONE"] * bool(gone) + [f"{changed} CHANGED since added"] * bool(changed)
    state = ", ".join(states) or "all files as added"
    faults = f", {_FAULTS}" if campaign.contents.findings else ""
    sentences([f"Campaign: {campaign.folder} ({counted}, {state}{faults})"], out)
    show_rows(LISTED, campaign.drops, out)
    list_facts(
        "Changed",
        [f"drop {drop.entry.number}: {change}" for drop in campaign.drops for change in drop.changes],
        out,
    )


def _report(args: argparse.Namespace, out: Output) -> int:
    from tfsat_host.run.campaign.campaign_report import REPORT, report

    given = {"laser": args.laser, "facility": args.facility, "force": args.force}
    campaign_report = report(args.dir, args.robot, args.out, notices=out, **given)
    out.result(record(REPORT, campaign_report), lambda: _show_report(campaign_report, out))
    return _warn_and_exit_code(campaign_report.findings, out) or (
        0 if campaign_report.good else ExitCode.DATA_LOSS
    )


def _show_report(campaign_report: CampaignReport, out: Output) -> None:
    """Show the verdict, the drops, why some are left out, each robot's combined results, the verdict again."""
    from tfsat_host.present.evaluation_text import show_comparison
    from tfsat_host.run.campaign.campaign_report import DROPS_OF_ALL

    _show_verdict(campaign_report, out)
    show_rows(DROPS_OF_ALL, campaign_report.tried, out)
    sentences(campaign_report.sentences(), out)
    for robot in campaign_report.robots:
        if robot.compared is not None:
            out.line(f"All drops of the {robot.name}")
            show_comparison(robot.tables(), robot.compared.remarks, out)
    out.line(f"Report: {campaign_report.page or 'not written (no drop can be evaluated)'}")
    _show_verdict(campaign_report, out)


def _show_verdict(campaign_report: CampaignReport, out: Output) -> None:
    counts = ", ".join(f"{count} {level}" for level, count in sorted(campaign_report.counts.items()))
    number = len(campaign_report.tried)
    facts = [f"{number} drop{'' if number == 1 else 's'} ({counts})"]
    facts += [f"{len(campaign_report.void)} void"] if campaign_report.void else []
    facts += ["drops contradict each other"] if campaign_report.contradictory else []
    facts += [_FAULTS] if campaign_report.findings else []
    verdict, color = ("GOOD", "1;32") if campaign_report.good else ("DOUBTFUL", "1;33")
    sentences([f"{verdict}: {', '.join(facts)}"], out, colored=verdict, color=color)


def _warn_and_exit_code(messages: Sequence[str], out: Output) -> int:
    """Warn with these sentences and return the exit code they call for."""
    out.warn_each(messages)
    return ExitCode.DATA_LOSS if messages else 0
