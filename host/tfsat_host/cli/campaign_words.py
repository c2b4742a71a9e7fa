"""What the campaign commands show: its drops, and what they say together."""

from __future__ import annotations

from typing import Any

from tfsat_host.cli.evaluate.several import DROPS, comparison_as_dict, row_of, show_comparison
from tfsat_host.errors import TfsatError
from tfsat_host.json_values import error_as_dict
from tfsat_host.present.output import Output
from tfsat_host.present.terminal import printable, show_rows
from tfsat_host.quantity import UNKNOWN, Column, Columns
from tfsat_host.run.campaign.campaign import DropEntry
from tfsat_host.run.campaign.reporting import CampaignReport, OfOneRobot, TriedDrop
from tfsat_host.run.evaluated import EvaluatedRun, dropped_robot, result_of

_REPORTED: Columns = (DROPS[0], Column("robot", "robot"), *DROPS[1:], Column("notes", "notes"))


def show_list(rows: list[tuple[DropEntry, list[str]]], out: Output) -> None:
    """The drops, and what of them is not as it came."""
    if not rows:
        out.line("No drops yet.")
        return
    out.table(
        ("drop", "robot", "released / UTC", "recording", "id", "as it came", "notes"),
        [_listed(drop, changes) for drop, changes in rows],
    )
    for drop, changes in rows:
        for sentence in changes:
            out.line(f"CHANGED   drop {drop.number}: {printable(sentence)}")


def _listed(drop: DropEntry, changes: list[str]) -> tuple[object, ...]:
    void = [] if drop.void is None else [f"VOID: {drop.void.text}"]
    return (
        str(drop.number),
        drop.robot,
        "unknown" if drop.released is None else f"{drop.released:%Y-%m-%d %H:%M:%S}",
        printable(drop.recording),
        drop.session or "unknown",
        "NO" if changes else "yes",
        "; ".join(printable(text) for text in [*void, *(note.text for note in drop.notes)]) or "–",
    )


def report_as_dict(folder: object, made: CampaignReport) -> dict[str, Any]:
    """For `--json`."""
    return {
        "campaign": str(folder),
        "report": None if made.page is None else str(made.page),
        "drops": [_as_dict(*one) for one in made.tried],
        "void": [drop.as_dict() for drop in made.void],
        "comparisons": [
            {
                "robot": robot.robot.kind,
                "logger_serial": robot.robot.logger_serial,
                "robot_sha256": robot.model_sha256,
                "drops": list(robot.numbers),
                "comparison": None if robot.compared is None else comparison_as_dict(robot.compared),
            }
            for robot in made.robots
        ],
        "findings": list(made.findings),
    }


def _as_dict(drop: DropEntry, one: EvaluatedRun | TfsatError) -> dict[str, Any]:
    if isinstance(one, TfsatError):
        return {**drop.as_dict(), "error": error_as_dict(one), "evaluation": None}
    return {**drop.as_dict(), "evaluation": result_of(one)}


def show_report(made: CampaignReport, out: Output) -> None:
    """Each drop, why some are left out, what each robot's say together, and the page."""
    show_rows(_REPORTED, [_row(one) for one in made.tried], out, title="All drops")
    for drop, one in made.tried:
        if isinstance(one, TfsatError):
            out.line(
                f"Drop {drop.number} cannot be evaluated: {printable(one.what)} {printable(one.next_step)}"
            )
    for drop in made.void:
        why = "" if drop.void is None else f": {printable(drop.void.text)}"
        out.line(f"Drop {drop.number} is void and not counted{why}")
    _show_robots(made.robots, out)
    out.line("No report was written." if made.page is None else f"Written  {printable(made.page)}")


def _row(tried: TriedDrop) -> dict[str, Any]:
    drop, one = tried
    run = None if isinstance(one, TfsatError) else one
    robot = drop.robot if run is None else dropped_robot(run.found.log).kind
    notes = "; ".join(note.text for note in drop.notes) or UNKNOWN
    return {**row_of(drop.number, run), "robot": robot, "notes": notes}


def _show_robots(robots: list[OfOneRobot], out: Output) -> None:
    """What each robot's drops say together, and that robots are kept apart."""
    if len(robots) > 1:
        out.line(
            f"The drops are of {len(robots)} robots or robot files: none is combined with those of another."
        )
    for robot in robots:
        if robot.compared is not None:
            out.line(f"The drops of the {robot.name} together:")
            show_comparison(robot.compared, out, robot.numbers)
        elif len(robots) > 1:
            out.line(f"Drop {robot.numbers[0]} is the only one of the {robot.name}: compared with nothing.")
