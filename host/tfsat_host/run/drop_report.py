"""The report of one drop or several: its files, that nothing is overwritten that no report made, and its making."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from itertools import chain
from pathlib import Path

from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.evaluation.verdict import VERDICT
from tfsat_host.file_hash import sha256_of
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import SILENT, Notices
from tfsat_host.output_files import OutputFile, check_may_write, new_folder_of, tell_new_folder, write_all
from tfsat_host.plotting import check_matplotlib
from tfsat_host.quantity import Column, Columns, Table, fields
from tfsat_host.report import render
from tfsat_host.report.contents.document_builder import ReportedDrop, Source, document_of
from tfsat_host.report.figures import FIGURES, FORMATS, drawn_of, write_figure
from tfsat_host.report.figures import MARKER as FIGURE_MARKER
from tfsat_host.report.foxglove_export import MARKER as MCAP_MARKER
from tfsat_host.report.foxglove_export import write_evaluated_mcap
from tfsat_host.run.drop_comparison import Comparison, Refused, try_evaluation
from tfsat_host.run.drop_evaluation import EvaluatedRun, robot_of
from tfsat_host.run.files import AS_FOUND, EvaluationOptions, names_of, run_files
from tfsat_host.sdlog.log_errors import check_extra

PAGE = "report.html"
PAGE_MARKER = b"<title>tfsat report</title>"
BESIDE = Path()
"""As an MCAP file's name: one next to each recording."""
_MCAP_ENDING = ".evaluated.mcap"


@dataclass(frozen=True, slots=True)
class ReportOptions:
    """What is to be written.

    Attributes:
        page: The HTML file; None: `report.html` next to the recording, of several drops in the current folder.
        figures: A folder for the figures of a paper; None: there are none.
        mcap: The evaluated drop for Foxglove and others; `BESIDE`: a file next to each recording; None: there is none.
        force: Whether files that no report made may be overwritten.
    """

    page: Path | None = None
    figures: Path | None = None
    mcap: Path | None = None
    force: bool = False


@dataclass(frozen=True, eq=False)
class Report:
    """A report that was written.

    Attributes:
        page: Of it.
        files: All that was written, the page first.
        drops: As the page has them.
        runs: Their evaluations, in that order.
        refused: Drops that could not be evaluated.
        compared: What several say together; None: of one.
    """

    page: Path
    files: list[Path]
    drops: list[ReportedDrop]
    runs: list[EvaluatedRun]
    refused: list[Refused]
    compared: Comparison | None


_REPORTED: Columns = (
    Column("name", of=lambda drop: drop[0].name),
    Column("run", of=lambda drop: drop[1].place),
    Column("verdict", of=lambda drop: drop[1].verdict, columns=VERDICT),
)
REPORT: Columns = (
    *fields("report=page files"),
    Column("drops", of=lambda report: list(zip(report.drops, report.runs, strict=True)), columns=_REPORTED),
    Column("refused", columns=fields("run=place what=error.what")),
)
"""Of `report --json`."""


def report(
    places: Sequence[Path],
    options: EvaluationOptions = AS_FOUND,
    report_options: ReportOptions = ReportOptions(),
    notices: Notices = SILENT,
    made_at: datetime | None = None,
) -> Report:
    """Evaluates drops of one robot and writes one page of them; one that is refused is named in it.

    Args:
        places: Recordings or their folders.
        options: What else is known of them.
        report_options: What is to be written.
        notices: For progress and warnings.
        made_at: The time that the page gives; None: the computer's.

    Raises:
        TfsatError: something is in the way, or none can be evaluated. Nothing was written.
    """
    options.check(places)
    if len(places) > 1 and report_options.mcap not in (None, BESIDE):
        raise UsageError(
            what=f"--mcap names one file, and {len(places)} drops were named.",
            meaning="Nothing was evaluated.",
            next_step="Leave out the name: each file then lies next to its recording.",
        )
    files = ReportFiles.of(places, options.maneuver, report_options)
    # Find out what is in the way before the evaluation, which takes long.
    files.check()
    robot = robot_of(options.robot, places)
    each = [try_evaluation(place, options, robot, notices) for place in places]
    runs = [attempt for attempt in each if isinstance(attempt, EvaluatedRun)]
    refused = [attempt for attempt in each if isinstance(attempt, Refused)]
    if refused and len(places) == 1:
        raise refused[0].error
    for refusal in refused:
        error = refusal.error
        notices.warn(
            Advice(f"{refusal.place} is not in the report. {error.what} {error.meaning} ", error.next_step)
        )
    if not runs:
        raise TfsatError(
            what="None of the drops can be evaluated.",
            meaning="No report was written.",
            next_step=Advice("Look at the first alone: ", NextStep("evaluate", (str(places[0]),))),
        )
    drops = [report_drop(files.names[run.files.recording], run) for run in runs]
    compared = Comparison.of(runs)
    tables = [] if compared is None else compared.tables([drop.name for drop in drops])
    without = [explain_absence(refusal.place, refusal.error) for refusal in refused]
    written = files.write(drops, tables, without, notices, made_at)
    return Report(files.page, written, drops, runs, refused, compared)


@dataclass(frozen=True, eq=False)
class ReportFiles:
    """Where a report goes.

    Attributes:
        page: The HTML file.
        names: Of the drops, for people, by recording.
        wanted: What is to be written.
        alone: One drop was asked for.
    """

    page: Path
    names: dict[Path, str]
    wanted: ReportOptions
    alone: bool

    @classmethod
    def of(cls, places: Sequence[Path], maneuver: Path | None, report_options: ReportOptions) -> ReportFiles:
        """Build the list of files to write.

        Of several recordings, one that cannot be found is skipped here and refused later.

        Raises:
            TfsatError: the only recording cannot be found.
        """
        alone, recordings = len(places) == 1, []
        for place in places:
            try:
                recordings.append(run_files(place, maneuver, command=NextStep("report")).recording)
            except TfsatError:
                if alone:
                    raise
        page = report_options.page or (recordings[0].parent / PAGE if alone else Path(PAGE))
        return cls(page, dict(zip(recordings, names_of(recordings), strict=True)), report_options, alone)

    def figures(self, recording: Path) -> dict[tuple[str, str], Path]:
        """Return each figure's file by its name and format."""
        folder = self.wanted.figures
        if folder is None:
            return {}
        if not self.alone:
            # Each drop has the same figures: a subfolder for each, with a name that every system takes.
            folder /= re.sub(r"[^\w.-]+", "_", self.names[recording]).strip("._") or "drop"
        return {(figure, kind): folder / f"{figure}.{kind}" for figure in FIGURES for kind in FORMATS}

    def mcap(self, recording: Path) -> Path | None:
        """Return the path of the recording's MCAP file; None if it is not wanted."""
        return recording.with_suffix(_MCAP_ENDING) if self.wanted.mcap == BESIDE else self.wanted.mcap

    def check(self) -> None:
        """Refuses what could not be written, before anything is evaluated.

        Raises:
            TfsatError: something is in the way, or a library is missing.
        """
        if self.names and self.wanted.figures is not None:
            check_matplotlib("--figures", "leave --figures out")
        if self.names and self.wanted.mcap is not None:
            check_extra("mcap")
        paths = [(self.page, PAGE_MARKER, "--out")]
        for recording in self.names:
            paths += [(path, FIGURE_MARKER, "--figures") for path in self.figures(recording).values()]
            paths += [(path, MCAP_MARKER, "--mcap") for path in (self.mcap(recording),) if path is not None]
        for path, marker, option in paths:
            check_may_write(path, marker=marker, force=self.wanted.force, option=option)

    def write(
        self,
        drops: Sequence[ReportedDrop],
        tables: Sequence[Table],
        without: Sequence[str],
        notices: Notices,
        made_at: datetime | None = None,
    ) -> list[Path]:
        """Writes all of it, the page first, and gives the files.

        `tables` are of all drops together; `without` has a sentence or more on each drop that could not be
        evaluated, and why. The page gives the time `made_at`; None: the computer's.

        Raises:
            TfsatError: something is in the way: then nothing was written.
        """

        def write_page(path: Path) -> None:
            document = document_of(drops, made_at or datetime.now(UTC), tables=tables, lacking=without)
            path.write_text(render(document), encoding="utf-8")

        # Page, figures and MCAP files in one list: if one of them is in the way, none is written.
        outputs = [OutputFile(self.page, PAGE_MARKER, write_page), *chain(*map(self._others, drops))]
        new_folder = new_folder_of(self.page)
        with notices.progress("Writing the report", total=1.0) as advance:
            step = partial(advance, 1.0 / len(outputs))
            write_all([_count_output(output, step) for output in outputs], force=self.wanted.force)
        tell_new_folder(new_folder, notices)
        return [output.path for output in outputs]

    def _others(self, drop: ReportedDrop) -> list[OutputFile]:
        """Figures and the MCAP file of a drop."""
        recording, outputs = drop.evaluation.log.path, []
        if figures := self.figures(recording):
            content = drawn_of(drop.evaluation)
            outputs = [
                OutputFile(path, FIGURE_MARKER, partial(write_figure, figure, content, kind), "--figures")
                for (figure, kind), path in figures.items()
            ]
        if (mcap := self.mcap(recording)) is not None:
            outputs.append(OutputFile(mcap, MCAP_MARKER, partial(write_evaluated_mcap, drop), "--mcap"))
        return outputs


def report_drop(name: str, run: EvaluatedRun) -> ReportedDrop:
    """Build the report page's entry of a drop."""
    certificate = None if run.held is None else run.held.path
    files = {
        "file of the robot": run.found.model.path,
        "file of the calibration": certificate,
        "file of the maneuver": run.files.maneuver,
        "video": run.options.video,
        "laser spots": run.options.laser,
        "facility": run.options.facility,
    }
    sources = tuple(
        Source.of(what, path) for what, path in files.items() if path is not None and path.is_file()
    )
    sha256 = sha256_of(run.files.recording)
    return ReportedDrop(
        name, run.found, run.verdict, sha256, certificate, run.remarks, sources, run.options.as_arguments()
    )


def explain_absence(place: Path, refusal: TfsatError) -> str:
    """Why a drop is not in the page."""
    return f"{place} could not be evaluated: {refusal.what} {refusal.next_step}"


def _count_output(output: OutputFile, on_written: Callable[[], object]) -> OutputFile:
    """Wrap an output file so that `on_written` is called once it is written."""

    def write(path: Path) -> None:
        output.write(path)
        on_written()

    return replace(output, write=write)
