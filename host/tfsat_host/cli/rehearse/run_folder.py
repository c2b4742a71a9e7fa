"""The run folder of one rehearsal: maneuver, calibration, preflight, card, decoded columns, truth, a summary."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.output import Output
from tfsat_host.cli.outputs import was_made_with
from tfsat_host.cli.rehearse.result_folder import RECORDING, ResultFolder
from tfsat_host.whole_file import write_whole

if TYPE_CHECKING:
    from tfsat_host.maneuver import Maneuver
    from tfsat_host.rehearsal.drop import Drop
    from tfsat_host.robot import RobotModel
    from tfsat_host.sdlog import DropLog

SUMMARY = "summary.json"


class RunFolder(ResultFolder):
    """See the module.

    Attributes:
        removed: What `evaluate` and `report` had made there of the recording that was replaced.
        maneuver: The file of the maneuver.
        collected: When the card was taken out, by the rehearsal's clock: all files have their times by it, so that the
            same rehearsal gives the same bytes. None: nothing was written yet.
    """

    def __init__(self, path: Path, *, force: bool) -> None:
        super().__init__(path, force=force)
        self.removed: tuple[Path, ...] = ()
        self.maneuver = path / "maneuver.toml"
        self.collected: datetime | None = None

    def may_be_made_again(self, path: Path) -> bool:
        """`report` writes its page anew."""
        return _is_derived(path)

    def write(self, maneuver: Maneuver, drop: Drop, filed: RobotModel, truth_text: str) -> DropLog | None:
        """Writes what the day left, decodes the card from its file and exports it; gives the log, if there is one.

        Raises:
            UsageError: somebody replaced a file in the folder meanwhile; nothing was overwritten.
        """
        from tfsat_host.cli.evaluate.run_files import ROBOT
        from tfsat_host.emulated.truth import format_truth
        from tfsat_host.maneuver import format_maneuver

        robot = filed.path.read_bytes()  # which may lie in this very folder
        self.emptied()
        self.removed = _derived_in(self.path)
        for stale in self.removed:
            stale.unlink()
        self.collected = drop.collected
        self.file("maneuver.toml").write_text(format_maneuver(maneuver), encoding="utf-8")
        self.file(ROBOT).write_bytes(robot)
        certificate = self._write_certificate(drop)
        self.file("truth.json").write_text(truth_text, encoding="utf-8")
        if drop.released_s is not None:
            self.file("truth.csv").write_text(format_truth(drop.truth, drop.released_s), encoding="utf-8")
        if drop.checked is not None:
            self._write_preflight(drop, certificate, self.path / ROBOT)
        self.file(SUMMARY)
        log = self._write_card(drop.card) if drop.card else None
        if log is not None:
            self._note_landing(log, drop, certificate)
        self.sealed()
        return log

    def _write_certificate(self, drop: Drop) -> Path:
        """As `tfsat-host calibrate` keeps it: with its recordings, and a copy that stays as the preflight signs it."""
        from tfsat_host.calibration.certificate.archive import kept_copy, recordings_folder, write_certificate
        from tfsat_host.cli.calibrate.options import EMULATED_CERTIFICATE

        certificate = self.file(EMULATED_CERTIFICATE)
        beside = recordings_folder(certificate).name
        for paper in drop.calibration.papers:
            write_whole(self.file(f"{beside}/{paper.file}"), drop.recordings[paper.file])
        self.file(f"{beside}/{kept_copy(certificate, drop.calibration).name}")
        write_certificate(certificate, drop.calibration)
        return certificate

    def _note_landing(self, log: DropLog, drop: Drop, certificate: Path) -> None:
        """As `decode` would, but by the rehearsal's clock: the evaluation then finds it noted."""
        from tfsat_host.calibration.certificate.archive import kept_copy
        from tfsat_host.calibration.certificate.file import read_calibration
        from tfsat_host.cli.calibration_notice import is_of_robot, origin_of_log
        from tfsat_host.cli.decode_landing import note_landing_of

        if not is_of_robot(drop.calibration, origin_of_log(log.header)):
            return
        quiet = Output(json_mode=True, stdout=io.StringIO(), stderr=io.StringIO())
        note_landing_of(log, certificate, drop.calibration, quiet, drop.collected)
        noted = kept_copy(certificate, read_calibration(certificate))
        if noted not in self.files:
            self.files.append(noted)

    def _write_preflight(self, drop: Drop, certificate: Path, robot: Path) -> None:
        """As `tfsat-host preflight` writes and signs it."""
        from tfsat_host.cli.preflight_files import RESULT, hashes_of, result_of, write_result
        from tfsat_host.facility import load_tower
        from tfsat_host.record.run_record import RECORD

        assert drop.checked is not None
        evidence = drop.checked.evidence
        files = {
            "maneuver": self.maneuver,
            "calibration": certificate,
            "robot": robot,
            "facility": load_tower(None).path,
        }
        result = result_of(evidence, drop.checked.checks, hashes_of(files))
        self.file(RECORD)
        write_result(self.path, result, evidence.now)
        self.file(RESULT)

    def _write_card(self, card: bytes) -> DropLog:
        from tfsat_host.cli.decoded_files import write_decoded
        from tfsat_host.sdlog import load

        path = self.file(RECORDING)
        path.write_bytes(card)
        log = load(path)
        self.files += write_decoded(log, self.path / "SD", ("csv",), force=True).files.values()
        self.marked()
        return log

    def write_summary(self, result: Mapping[str, Any]) -> None:
        """Writes `summary.json`, the command's result."""
        text = json.dumps(result, indent=1, default=_plain)
        (self.path / SUMMARY).write_text(text + "\n", encoding="utf-8")
        self.sealed()


def _derived_in(folder: Path) -> tuple[Path, ...]:
    """Results of `evaluate` and `report`: beside another recording they would be taken for its."""
    files = sorted(path for path in (*folder.glob("*"), *folder.glob("*/*")) if path.is_file())
    return tuple(path for path in files if _is_derived(path))


def _is_derived(path: Path) -> bool:
    """By the commands' own marks."""
    from tfsat_host.cli.evaluate.command import MARKER as EVALUATION
    from tfsat_host.cli.report_files import PAGE_MARKER
    from tfsat_host.report.figures.files import MARKER as FIGURE
    from tfsat_host.report.recording.file import MARKER as MCAP

    return any(was_made_with(path, mark) for mark in (EVALUATION, PAGE_MARKER, FIGURE, MCAP))


def _plain(value: Any) -> Any:
    return value.tolist()
