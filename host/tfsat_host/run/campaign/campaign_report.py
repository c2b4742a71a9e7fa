"""All drops of a campaign evaluated, each robot's compared, and laid over each other in one page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from tfsat_host import quantity
from tfsat_host.crash import bug_error
from tfsat_host.error_columns import error_columns
from tfsat_host.errors import TfsatError
from tfsat_host.evaluation.result.comparison_result import COMPARISON
from tfsat_host.file_hash import sha256_of
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import SILENT, Notices
from tfsat_host.quantity import UNKNOWN, Column, Columns, columns_of, fields
from tfsat_host.run import drop_evaluation
from tfsat_host.run.campaign.campaign_folder import changes_in, read
from tfsat_host.run.campaign.entries import ENTRY, DropEntry, folder_name
from tfsat_host.run.drop_comparison import DROPS, Comparison, DropSummary
from tfsat_host.run.drop_evaluation import EVALUATED_RUN, DroppedRobot, EvaluatedRun, dropped_robot
from tfsat_host.run.drop_report import (
    PAGE,
    ReportFiles,
    ReportOptions,
    explain_absence,
    report_drop,
)
from tfsat_host.run.files import EMULATED, EvaluationOptions

_SHOWN = 8
_Key = tuple[DroppedRobot, str]


@dataclass(frozen=True, eq=False)
class TriedDrop:
    """A drop that counts, and its evaluation or why there is none."""

    entry: DropEntry
    attempt: EvaluatedRun | TfsatError

    @property
    def evaluation(self) -> EvaluatedRun | None:
        """None if it cannot be evaluated."""
        return self.attempt if isinstance(self.attempt, EvaluatedRun) else None

    @property
    def error(self) -> TfsatError | None:
        """Why it cannot be evaluated."""
        return self.attempt if isinstance(self.attempt, TfsatError) else None

    @property
    def summary(self) -> DropSummary:
        """Its line in the table of all."""
        return DropSummary(self.entry.folder, self.evaluation)

    @property
    def robot(self) -> str:
        """One of `files.ROBOTS`: the recording's own word, where it was decoded, goes before the index's."""
        run = self.evaluation
        return self.entry.robot if run is None else dropped_robot(run.found.log).kind

    @property
    def notes(self) -> str:
        """What people wrote of it."""
        return "; ".join(note.text for note in self.entry.notes) or UNKNOWN


_SUMMARY = columns_of("summary", DROPS)
DROPS_OF_ALL: Columns = (_SUMMARY[0], Column("robot", "robot"), *_SUMMARY[1:], Column("notes", "notes"))
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
        names = [folder_name(number) for number in self.numbers]
        return [] if self.compared is None else self.compared.tables(names)


ROBOT: Columns = (
    *fields("robot=robot.kind logger_serial=robot.logger_serial robot_sha256=model_sha256 drops=numbers"),
    Column("comparison", of="compared", columns=COMPARISON),
)


@dataclass(frozen=True, eq=False)
class CampaignReport:
    """All drops of a campaign, evaluated and compared.

    Attributes:
        folder: Of the campaign.
        page: None: no drop can be evaluated.
        tried: Each drop that counts, and its evaluation or why there is none.
        void: Drops that do not count.
        robots: Each robot's drops.
        findings: What is wrong with the campaign; sentences.
    """

    folder: Path
    page: Path | None
    tried: list[TriedDrop]
    void: list[DropEntry]
    robots: list[OfOneRobot]
    findings: tuple[str, ...]

    @property
    def good(self) -> bool:
        """Whether all drops are good, agree, and the campaign is whole."""
        return self.counts["good"] == len(self.tried) and not self.contradictory and not self.findings

    @property
    def counts(self) -> Counter[str]:
        """How many drops have each verdict."""
        runs = (drop.evaluation for drop in self.tried)
        return Counter("failed" if run is None else run.verdict.level for run in runs)

    @property
    def contradictory(self) -> bool:
        """Whether drops of one robot contradict each other."""
        return any(robot.compared is not None and robot.compared.doubts for robot in self.robots)

    def sentences(self) -> list[str]:
        """List the drops left out, with reasons, and the separation of different robots, as sentences."""
        sentences: list[str] = [
            Advice(f"{drop.entry.folder} cannot be evaluated: {drop.error.what} ", drop.error.next_step)
            for drop in self.tried
            if drop.error is not None
        ]
        for drop in self.void:
            why = "" if drop.void is None else f": {drop.void.text}"
            sentences.append(f"{drop.folder} is void and not counted{why}")
        if len(self.robots) > 1:
            apart = "robots or robot files: none is combined with those of another."
            sentences.append(f"The drops are of {len(self.robots)} {apart}")
            sentences += [
                f"{folder_name(robot.numbers[0])} is the only one of the {robot.name}: compared with nothing."
                for robot in self.robots
                if robot.compared is None
            ]
        return sentences


_EVALUATED_DROP: Columns = (*columns_of("entry", ENTRY), Column("evaluation", columns=EVALUATED_RUN))
_REFUSED_DROP: Columns = (*_EVALUATED_DROP, Column("error", columns=error_columns))
REPORT: Columns = (
    *fields("campaign=folder report=page"),
    Column("drops", of="tried", columns=lambda drop: _REFUSED_DROP if drop.error else _EVALUATED_DROP),
    Column("void", columns=ENTRY),
    Column("comparisons", of="robots", columns=ROBOT),
    Column("findings"),
)
"""Of `campaign report --json`."""


def report(
    folder: Path,
    robot: Path | None = None,
    page: Path | None = None,
    *,
    laser: Path | None = None,
    facility: Path | None = None,
    force: bool = False,
    notices: Notices = SILENT,
) -> CampaignReport:
    """Evaluates each drop that counts; one that cannot be is named and does not keep the others from being compared.

    Drops of different robots are drawn over each other, and never taken together in a number.

    Args:
        folder: Of the campaign.
        robot: A robot file, or the name of a shipped one; None: each drop's own, else the drop tower's.
        laser: Name of a file in each drop's folder with its laser spots; a drop without it is evaluated without.
        facility: For the release velocity; None: COSMOTORRE's.
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
    _require_laser(laser, present, folder, notices)
    files = ReportFiles.of([_recording_file(folder, drop) for drop in present], None, report_options)
    files.check()
    options = EvaluationOptions(robot=robot, laser=laser, facility=facility)
    options.check([folder])
    if robot is not None:
        drop_evaluation.robot_of(robot)  # one that cannot be read is no drop's fault
    tried = [TriedDrop(drop, _try_evaluation(drop, folder, options, notices)) for drop in counting]
    # Offsets are of one robot and its file: only drops that share both are combined.
    robots = by_robot([(drop.entry.number, drop.evaluation) for drop in tried if drop.evaluation])
    if robots:
        _write(tried, robots, files, notices)
    void = [drop for drop in contents.drops if drop.void is not None]
    return CampaignReport(folder, files.page if robots else None, tried, void, robots, contents.findings)


def _require_laser(laser: Path | None, present: Sequence[DropEntry], folder: Path, notices: Notices) -> None:
    """Say which drops have no file of laser spots. Raises TfsatError: none has one."""
    if laser is None:
        return
    without = [drop.folder for drop in present if not (folder / drop.folder / laser).is_file()]
    if len(without) == len(present):
        raise TfsatError(
            what=f"No drop in {folder} has a file {laser}.",
            meaning="Nothing was evaluated.",
            next_step="Copy each drop's laser spots into its folder under that name, or leave --laser out.",
        )
    if without:
        notices.note(f"Without {laser}, and so without a measured release velocity: {', '.join(without)}.")


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
        if not recording.is_file():
            raise TfsatError(
                what=f"{recording} is gone.",
                meaning="The drop is left out; what is said of the others holds.",
                next_step=Advice(
                    "Copy it back from a backup or out of its bundle; if it is lost: ",
                    NextStep("campaign void", (str(folder), str(drop.number), "REASON")),
                ),
            )
        _require_as_it_came(drop, folder)
        robot = drop_evaluation.robot_of(options.robot, [recording])
        laser = None if options.laser is None else recording.parent / options.laser
        own = (
            options if laser is not None and laser.is_file() else replace(options, laser=None, facility=None)
        )
        return drop_evaluation.evaluate_run(
            recording, replace(own, laser=own.laser and laser), robot, notices
        )
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
            what=f"Modified since it was added: {' '.join(changes)}",
            meaning="What was changed is no evidence of the drop: it is left out; what is said of the others holds.",
            next_step=Advice(
                "Put the unchanged file back. If the change is meant: copy the drop's folder to another place, ",
                NextStep("campaign void", (str(folder), str(drop.number))),
                ", then campaign add the copy.",
            ),
        )


def _write(
    tried: Sequence[TriedDrop], robots: Sequence[OfOneRobot], files: ReportFiles, notices: Notices
) -> None:
    """Write the report page of the drops that can be evaluated, with a comparison per robot."""
    drops = {
        drop.entry.number: report_drop(_name(drop.entry, drop.evaluation), drop.evaluation)
        for drop in tried
        if drop.evaluation
    }
    tables: list[quantity.Table] = []
    for robot in robots:
        if robot.compared is not None:
            name = f" ({robot.name})" if len(robots) > 1 else ""
            of_them = robot.compared.tables([drops[number].name for number in robot.numbers])
            tables += [replace(table, title=f"{table.title}{name}") for table in of_them]
    without = [explain_absence(Path(drop.entry.folder), drop.error) for drop in tried if drop.error]
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
        certificate = None if run.held is None else run.held.calibration
        key = (dropped_robot(run.found.log, certificate), sha256_of(run.found.model.path))
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
