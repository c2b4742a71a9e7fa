"""All drops of a campaign evaluated, each robot's compared, and laid over each other in one page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tfsat_host import quantity
from tfsat_host.crash import bug_error
from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import sha256_of
from tfsat_host.json_values import error_as_dict
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import SILENT, Notices
from tfsat_host.quantity import UNKNOWN, Column, Columns
from tfsat_host.report.document import PageTable
from tfsat_host.run import drop_evaluation
from tfsat_host.run.campaign.campaign_folder import changes_in, read
from tfsat_host.run.campaign.entries import DropEntry
from tfsat_host.run.drop_comparison import DROPS, Comparison, row_of
from tfsat_host.run.drop_evaluation import DroppedRobot, EvaluatedRun, dropped_robot
from tfsat_host.run.drop_report import (
    PAGE,
    ReportFiles,
    ReportOptions,
    explain_absence,
    report_drop,
    together,
)
from tfsat_host.run.files import EMULATED, EvaluationOptions

_SHOWN = 8
_Key = tuple[DroppedRobot, str]
TriedDrop = tuple[DropEntry, EvaluatedRun | TfsatError]
DROPS_OF_ALL: Columns = (DROPS[0], Column("robot", "robot"), *DROPS[1:], Column("notes", "notes"))
"""All drops of a report, a line each."""


@dataclass(frozen=True, eq=False)
class OfOneRobot:
    """The drops of one robot, evaluated with one robot file.

    Attributes:
        robot: As the recordings say.
        model_sha256: Of the robot file.
        name: As much of both as distinguishes it from the campaign's other ones.
        numbers: Of the drops.
        compared: What they say together; None: there is but one.
    """

    robot: DroppedRobot
    model_sha256: str
    name: str
    numbers: tuple[int, ...]
    compared: Comparison | None

    def tables(self) -> list[quantity.Table]:
        """Build the tables of the drops' combined results; empty for a single drop."""
        names = [f"drop {number}" for number in self.numbers]
        return [] if self.compared is None else self.compared.tables(names)

    def as_dict(self) -> dict[str, Any]:
        """Return the robot, its drops and their comparison as a dict for `--json`."""
        return {
            "robot": self.robot.kind,
            "logger_serial": self.robot.logger_serial,
            "robot_sha256": self.model_sha256,
            "drops": list(self.numbers),
            "comparison": None if self.compared is None else self.compared.as_dict(),
        }


@dataclass(frozen=True, eq=False)
class CampaignReport:
    """What came of it.

    Attributes:
        page: None: no drop can be evaluated.
        tried: Each drop that counts, and its evaluation or why there is none.
        void: Drops that do not count.
        robots: Each robot's drops.
        findings: What is wrong with the campaign; sentences.
    """

    page: Path | None
    tried: list[TriedDrop]
    void: list[DropEntry]
    robots: list[OfOneRobot]
    findings: tuple[str, ...]

    @property
    def good(self) -> bool:
        """Nothing speaks against any of it."""
        evaluations = (attempt for _, attempt in self.tried)
        return (
            all(
                isinstance(attempt, EvaluatedRun) and attempt.verdict.level == "good"
                for attempt in evaluations
            )
            and not any(robot.compared is not None and robot.compared.doubts for robot in self.robots)
            and not self.findings
        )

    def rows(self) -> list[dict[str, Any]]:
        """Return the rows of the table `DROPS_OF_ALL`, one per drop."""
        table_rows = []
        for drop, attempt in self.tried:
            evaluated_run = None if isinstance(attempt, TfsatError) else attempt
            # The recording's own word, where it was decoded, goes before the index's.
            robot = drop.robot if evaluated_run is None else dropped_robot(evaluated_run.found.log).kind
            notes = "; ".join(note.text for note in drop.notes) or UNKNOWN
            table_rows.append({**row_of(drop.number, evaluated_run), "robot": robot, "notes": notes})
        return table_rows

    def sentences(self) -> list[str]:
        """List the drops left out, with reasons, and the separation of different robots, as sentences."""
        sentences: list[str] = [
            Advice(f"Drop {drop.number} cannot be evaluated: {attempt.what} ", attempt.next_step)
            for drop, attempt in self.tried
            if isinstance(attempt, TfsatError)
        ]
        for drop in self.void:
            why = "" if drop.void is None else f": {drop.void.text}"
            sentences.append(f"Drop {drop.number} is void and not counted{why}")
        if len(self.robots) > 1:
            apart = "robots or robot files: none is combined with those of another."
            sentences.append(f"The drops are of {len(self.robots)} {apart}")
            sentences += [
                f"Drop {robot.numbers[0]} is the only one of the {robot.name}: compared with nothing."
                for robot in self.robots
                if robot.compared is None
            ]
        return sentences

    def as_dict(self) -> dict[str, Any]:
        """Return the report as a dict for `--json`."""
        return {
            "report": None if self.page is None else str(self.page),
            "drops": [
                {**drop.as_dict(), "error": error_as_dict(attempt), "evaluation": None}
                if isinstance(attempt, TfsatError)
                else {**drop.as_dict(), "evaluation": attempt.as_dict()}
                for drop, attempt in self.tried
            ],
            "void": [drop.as_dict() for drop in self.void],
            "comparisons": [robot.as_dict() for robot in self.robots],
            "findings": list(self.findings),
        }


def report(
    folder: Path,
    robot: Path | None = None,
    page: Path | None = None,
    *,
    force: bool = False,
    notices: Notices = SILENT,
) -> CampaignReport:
    """Evaluates each drop that counts; one that cannot be is named and does not keep the others from being compared.

    Drops of different robots are drawn over each other, and never taken together in a number.

    Args:
        folder: Of the campaign.
        robot: A robot file, or the name of a shipped one; None: each drop's own, else the drop tower's.
        page: The page; None: in the campaign's folder.
        force: Whether a page that no report made may be overwritten.
        notices: For progress.

    Raises:
        TfsatError: it is no campaign, holds no drop with a recording that counts, or something is in the way.
    """
    contents = read(folder)
    counting = [drop for drop in contents.drops if drop.void is None]
    present = [drop for drop in counting if _recording_file(folder, drop).is_file()]
    if not present:
        raise _nothing_to_compare(folder, contents.findings)
    report_options = ReportOptions(page or folder / PAGE, force=force)
    files = ReportFiles.of([_recording_file(folder, drop) for drop in present], None, report_options)
    files.check()
    options = EvaluationOptions(robot=robot)
    if robot is not None:
        drop_evaluation.robot_of(robot)  # one that cannot be read is no drop's fault
    tried = [(drop, _try_evaluation(drop, folder, options, notices)) for drop in present]
    # Offsets are of one robot and its file: only drops that share both are combined.
    robots = by_robot(
        [(drop.number, attempt) for drop, attempt in tried if isinstance(attempt, EvaluatedRun)]
    )
    if robots:
        _write(tried, robots, files, notices)
    void = [drop for drop in contents.drops if drop.void is not None]
    return CampaignReport(files.page if robots else None, tried, void, robots, contents.findings)


def _recording_file(folder: Path, drop: DropEntry) -> Path:
    return folder / drop.folder / drop.recording


def _nothing_to_compare(folder: Path, findings: Sequence[str]) -> TfsatError:
    """Build the error for a campaign without drops to compare.

    It includes the campaign's findings: drops lost from the campaign are not the same as no drops.
    """
    wrong, place = " ".join(findings), str(folder)
    return TfsatError(
        what=f"{folder} has no drops with a recording that count.{f' {wrong}' if wrong else ''}",
        meaning="There is nothing to compare; no report was written.",
        next_step=Advice(
            f"Copy {folder} back from where it is whole. What is left of it: ",
            NextStep("campaign list", (place,)),
        )
        if wrong
        else Advice(NextStep("campaign add", (place, "RUN"))),
    )


def _try_evaluation(
    drop: DropEntry, folder: Path, options: EvaluationOptions, notices: Notices
) -> EvaluatedRun | TfsatError:
    """Evaluate a drop and return the error if that fails.

    An unforeseen exception fails this drop only, not the evaluation of the others.
    """
    recording = _recording_file(folder, drop)
    try:
        _require_as_it_came(drop, folder)
        robot = drop_evaluation.robot_of(options.robot, [recording])
        return drop_evaluation.evaluate_run(recording, options, robot, notices)
    except TfsatError as error:
        return error
    except BrokenPipeError:
        # Whoever read the output is gone: that is no fault of this drop.
        raise
    except Exception as error:  # noqa: BLE001  kept with its traceback, named, and the report goes on
        bug = bug_error(error, ("campaign", "report", str(folder), str(recording)))
        summary = str(error).partition("\n")[0]
        return TfsatError(
            what=f"{type(error).__name__}: {summary}, which tfsat-host did not foresee.",
            meaning="The drop is left out; what is said of the others holds.",
            next_step=bug.next_step,
        )


def _require_as_it_came(drop: DropEntry, folder: Path) -> None:
    """Raises TfsatError: what it would be evaluated with may not be what flew."""
    changes = changes_in(folder, drop)
    if changes:
        raise TfsatError(
            what=f"It is not as it came into the campaign: {' '.join(changes)}",
            meaning="What was changed is no evidence of the drop: it is left out; what is said of the others holds.",
            next_step=Advice(
                "Put the file back as it was. If the change is meant: copy the drop's folder to another place, ",
                NextStep("campaign void", (str(folder), str(drop.number))),
                ", then campaign add the copy.",
            ),
        )


def _write(
    tried: Sequence[TriedDrop], robots: Sequence[OfOneRobot], files: ReportFiles, notices: Notices
) -> None:
    """Write the report page of the drops that can be evaluated, with a comparison per robot."""
    drops = {
        drop.number: report_drop(_name(drop, attempt), attempt)
        for drop, attempt in tried
        if isinstance(attempt, EvaluatedRun)
    }
    tables: list[PageTable] = []
    for robot in robots:
        if robot.compared is not None:
            of_them = together([drops[number] for number in robot.numbers], robot.compared)
            for table in of_them:
                table["title"] += f" ({robot.name})" if len(robots) > 1 else ""
            tables += of_them
    without = [
        explain_absence(Path(drop.folder), attempt)
        for drop, attempt in tried
        if isinstance(attempt, TfsatError)
    ]
    files.write(list(drops.values()), tables, without, notices)


def _name(drop: DropEntry, run: EvaluatedRun) -> str:
    """Return the drop's name on the page; an emulated drop is marked as such."""
    emulated = dropped_robot(run.found.log).kind == EMULATED
    return f"{drop.folder} (emulated)" if emulated else drop.folder


def by_robot(numbered_runs: Sequence[tuple[int, EvaluatedRun]]) -> list[OfOneRobot]:
    """Group the drops by robot; `numbered_runs` are their numbers and evaluations."""
    grouped: dict[_Key, list[tuple[int, EvaluatedRun]]] = {}
    for number, run in numbered_runs:
        # The robot file by its contents, as each drop's folder has a copy of its own.
        key = (dropped_robot(run.found.log), sha256_of(run.found.model.path))
        grouped.setdefault(key, []).append((number, run))
    return [
        OfOneRobot(
            *key,
            _robot_name(key, list(grouped)),
            tuple(number for number, _ in drops),
            Comparison.of([run for _, run in drops]),
        )
        for key, drops in grouped.items()
    ]


def _robot_name(key: _Key, all_of_them: Sequence[_Key]) -> str:
    robot, sha256 = key
    alike = {other_robot for other_robot, _ in all_of_them if other_robot.kind == robot.kind}
    name = str(robot) if len(alike) > 1 else f"{robot.kind} robot"
    files = [other_key for other_key in all_of_them if other_key[0] == robot]
    return f"{name}, robot file {sha256[:_SHOWN]}…" if len(files) > 1 else name
