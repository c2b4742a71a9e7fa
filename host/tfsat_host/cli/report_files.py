"""The files of a report: where they go, and that nothing of somebody else's is in the way."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.cli.evaluate.run_files import RECORDING, run_files
from tfsat_host.cli.outputs import OutputFile, check_may_write, write_all
from tfsat_host.errors import TfsatError

if TYPE_CHECKING:
    from tfsat_host.report.contents.reported import Reported
    from tfsat_host.report.document import Table

PAGE = "report.html"
PAGE_MARKER = b"<title>tfsat report</title>"
BESIDE = Path()
"""`--mcap` without a name."""
_MCAP_ENDING = ".evaluated.mcap"


@dataclass(frozen=True, slots=True)
class DropFiles:
    """What is to be written of one drop.

    Attributes:
        name: Of the drop, for people.
        figures: Each figure's file by its name and format; none if none is wanted.
        mcap: None if none is wanted.
    """

    name: str
    figures: dict[tuple[str, str], Path]
    mcap: Path | None


@dataclass(frozen=True, eq=False)
class PageParts:
    """What stands in the page besides the drops.

    Attributes:
        tables: Of all drops together.
        lacking: Which drops could not be evaluated, and why; a sentence or more each.
    """

    tables: Sequence[Table] = ()
    lacking: Sequence[str] = ()


@dataclass(frozen=True, eq=False)
class ReportFiles:
    """What is to be written.

    Attributes:
        page: The HTML file.
        drops: By recording.
    """

    page: Path
    drops: dict[Path, DropFiles]

    @classmethod
    def of(cls, args: argparse.Namespace) -> ReportFiles:
        """By the command's arguments; of several, a recording that cannot be found is left for later to refuse.

        Raises:
            TfsatError: the only recording cannot be found.
        """
        recordings = _recordings(args)
        alone = len(args.runs) == 1
        page = args.out or (recordings[0].parent / PAGE if alone else Path(PAGE))
        drops = {}
        for recording, name in zip(recordings, names_of(recordings), strict=True):
            folder = args.figures if args.figures is None or alone else args.figures / _file_name(name)
            drops[recording] = DropFiles(name, _figures(folder), _mcap(args.mcap, recording))
        return cls(page, drops)

    def check(self, *, force: bool) -> None:
        """Refuses what could not be written: before anything is evaluated.

        Raises:
            TfsatError: something is in the way, or a library is missing.
        """
        check_may_write(self.page, marker=PAGE_MARKER, force=force)
        figures = [path for drop in self.drops.values() for path in drop.figures.values()]
        recordings = [drop.mcap for drop in self.drops.values() if drop.mcap is not None]
        if figures:
            from tfsat_host.report.figures.files import MARKER as FIGURE_MARKER
            from tfsat_host.report.figures.files import check_matplotlib

            check_matplotlib()
            for path in figures:
                check_may_write(path, marker=FIGURE_MARKER, force=force)
        if recordings:
            from tfsat_host.report.recording.file import MARKER as MCAP_MARKER
            from tfsat_host.sdlog.extras import check_extra

            check_extra("mcap")
            for path in recordings:
                check_may_write(path, marker=MCAP_MARKER, force=force)

    def write(
        self,
        drops: Sequence[Reported],
        parts: PageParts,
        made_at: datetime,
        *,
        force: bool,
        progress: Callable[[float], object],
    ) -> list[Path]:
        """Writes all of it, the page first, and says what; `progress` gets the share of files that each makes up.

        Raises:
            TfsatError: something is in the way: then nothing was written.
        """
        outputs = [OutputFile(self.page, PAGE_MARKER, partial(_write_page, drops, parts, made_at))]
        for drop in drops:
            files = self.drops[drop.evaluation.log.path]
            outputs += _figure_outputs(drop, files)
            if files.mcap is not None:
                outputs.append(_mcap_output(drop, files.mcap))
        share = 1.0 / len(outputs)
        write_all([_counted(output, lambda: progress(share)) for output in outputs], force=force)
        return [output.path for output in outputs]


def _counted(output: OutputFile, done: Callable[[], object]) -> OutputFile:
    """The same, telling when it is written."""

    def write(path: Path) -> None:
        output.write(path)
        done()

    return replace(output, write=write)


def _recordings(args: argparse.Namespace) -> list[Path]:
    found = []
    for place in args.runs:
        try:
            found.append(run_files(place, args.maneuver).recording)
        except TfsatError:
            if len(args.runs) == 1:
                raise
    return found


def _figures(folder: Path | None) -> dict[tuple[str, str], Path]:
    if folder is None:
        return {}
    from tfsat_host.report.figures.arrangements import FIGURES
    from tfsat_host.report.figures.files import FORMATS

    return {(figure, kind): folder / f"{figure}.{kind}" for figure in FIGURES for kind in FORMATS}


def _mcap(asked: Path | None, recording: Path) -> Path | None:
    return recording.with_suffix(_MCAP_ENDING) if asked == BESIDE else asked


def _figure_outputs(drop: Reported, files: DropFiles) -> list[OutputFile]:
    if not files.figures:
        return []
    from tfsat_host.report.figures.files import MARKER, drawn_of, write_figure

    drawn = drawn_of(drop.evaluation)
    return [
        OutputFile(path, MARKER, partial(write_figure, figure, drawn, kind))
        for (figure, kind), path in files.figures.items()
    ]


def _mcap_output(drop: Reported, path: Path) -> OutputFile:
    from tfsat_host.report.recording.file import MARKER, write_evaluated_mcap

    write: Callable[[Path], object] = partial(write_evaluated_mcap, drop)
    return OutputFile(path, MARKER, write)


def names_of(recordings: Sequence[Path]) -> list[str]:
    """What people call each drop: its folder, or its file where that has a name of its own; no two are the same."""
    names: list[str] = []
    for recording in recordings:
        folder = recording.resolve().parent.name or "drop"
        name = folder if recording.name == RECORDING else recording.stem
        same = sum(other == name or other.startswith(f"{name} (") for other in names)
        names.append(f"{name} ({same + 1})" if same else name)
    return names


def _file_name(name: str) -> str:
    """A folder for any name, such as `run_2`."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._") or "drop"


def _write_page(drops: Sequence[Reported], parts: PageParts, made_at: datetime, path: Path) -> None:
    from tfsat_host.report import render
    from tfsat_host.report.contents.building import document_of

    path.write_text(
        render(document_of(drops, made_at, tables=parts.tables, lacking=parts.lacking)), encoding="utf-8"
    )
