"""A run: the folder of one drop, from its files to its evaluation, report, bundle and campaign.

from tfsat_host.run import EvaluationOptions, Run

run = Run.open("run")
evaluated = run.evaluate()
print(evaluated.verdict.sentence)
run.report()
run.bundle("drop.tfsat.zip")
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host.notices import SILENT, Notices
from tfsat_host.run.files import AS_FOUND, EvaluationOptions, RunFiles, run_files

if TYPE_CHECKING:
    from tfsat_host.run.bundle.making import WrittenBundle
    from tfsat_host.run.drop_evaluation import EvaluatedRun
    from tfsat_host.run.drop_report import Report, ReportOptions

__all__ = ["EvaluationOptions", "Run"]


@dataclass(frozen=True, slots=True)
class Run:
    """One drop: its recording, the files with it, and what else is known.

    Attributes:
        place: The folder, or the recording in it.
        files: What was found there.
        options: What else is known of the drop.
    """

    place: Path
    files: RunFiles
    options: EvaluationOptions

    @classmethod
    def open(cls, place: Path | str, options: EvaluationOptions = AS_FOUND) -> Run:
        """Finds the files of a drop.

        Args:
            place: A recording, or a folder with `SD.bin` or with one other recording.
            options: What else is known, and what of the model may be corrected.

        Raises:
            TfsatError: there is nothing of that name, the folder holds no recording, or several.
        """
        options.check([Path(place)])
        return cls(Path(place), run_files(Path(place), options.maneuver), options)

    def evaluate(self, notices: Notices = SILENT) -> EvaluatedRun:
        """Evaluate the drop, as `tfsat-host evaluate`: motion, model agreement and their uncertainties.

        The landing of the drop is written into its certificate.

        Raises:
            TfsatError: something cannot be read, or the recording does not hold what an evaluation needs.
        """
        from tfsat_host.run import drop_evaluation

        robot = drop_evaluation.robot_of(self.options.robot, [self.place])
        return drop_evaluation.evaluate_run(self.place, self.options, robot, notices)

    def report(self, report_options: ReportOptions | None = None, notices: Notices = SILENT) -> Report:
        """Evaluates it and writes the page, and the figures and the MCAP file that are wanted.

        Raises:
            TfsatError: it cannot be evaluated, or something is in the way.
        """
        from tfsat_host.run.drop_report import ReportOptions, report

        return report([self.place], self.options, report_options or ReportOptions(), notices)

    def bundle(
        self, target: Path | str | None = None, *, force: bool = False, notices: Notices = SILENT
    ) -> WrittenBundle:
        """Puts all of it into one archive, evaluated as now.

        Args:
            target: The archive; None: NAME.tfsat.zip in the current folder.
            force: Whether a file that no bundle is may be overwritten.
            notices: For progress.

        Raises:
            TfsatError: a file that was named is not there, or something is in the way.
        """
        from tfsat_host.run.bundle.making import bundle

        return bundle(
            self.place, self.options, None if target is None else Path(target), force=force, notices=notices
        )
