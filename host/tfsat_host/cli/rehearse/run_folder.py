"""The run folder of one rehearsal: maneuver, calibration, preflight, card, decoded columns, truth, a summary."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.outputs import was_made_with
from tfsat_host.cli.rehearse.result_folder import RECORDING, ResultFolder

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
    """

    def __init__(self, path: Path, *, force: bool) -> None:
        super().__init__(path, force=force)
        self.removed: tuple[Path, ...] = ()
        self.maneuver = path / "maneuver.toml"

    def write(self, maneuver: Maneuver, drop: Drop, filed: RobotModel, truth_text: str) -> DropLog | None:
        """Writes what the day left, decodes the card from its file and exports it; gives the log, if there is one."""
        from tfsat_host.calibration.certificate.text import format_calibration
        from tfsat_host.cli.calibrate.options import EMULATED_CERTIFICATE
        from tfsat_host.emulated.truth import format_truth
        from tfsat_host.maneuver import format_maneuver

        self.emptied()
        self.removed = _derived_in(self.path)
        for stale in self.removed:
            stale.unlink()
        self.file("maneuver.toml").write_text(format_maneuver(maneuver), encoding="utf-8")
        certificate = self.file(EMULATED_CERTIFICATE)
        certificate.write_text(format_calibration(drop.calibration), encoding="utf-8")
        self.file("truth.json").write_text(truth_text, encoding="utf-8")
        if drop.released_s is not None:
            self.file("truth.csv").write_text(format_truth(drop.truth, drop.released_s), encoding="utf-8")
        if drop.checked is not None:
            self._write_preflight(drop, filed, certificate)
        self.file(SUMMARY)
        return self._write_card(drop.card) if drop.card else None

    def _write_preflight(self, drop: Drop, filed: RobotModel, certificate: Path) -> None:
        """As `tfsat-host preflight` writes and signs it."""
        from tfsat_host.cli.preflight_files import RESULT, hashes_of, result_of, write_result
        from tfsat_host.facility import load_tower
        from tfsat_host.record.run_record import RECORD

        assert drop.checked is not None
        evidence = drop.checked.evidence
        files = {
            "maneuver": self.maneuver,
            "calibration": certificate,
            "robot": filed.path,
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
        self.marked()


def _derived_in(folder: Path) -> tuple[Path, ...]:
    """Results of `evaluate` and `report`, by their own marks: beside another recording they would be taken for its."""
    from tfsat_host.cli.evaluate.command import MARKER as EVALUATION
    from tfsat_host.cli.report_files import PAGE_MARKER
    from tfsat_host.report.figures.files import MARKER as FIGURE
    from tfsat_host.report.recording.file import MARKER as MCAP

    marks = (EVALUATION, PAGE_MARKER, FIGURE, MCAP)
    files = sorted(path for path in (*folder.glob("*"), *folder.glob("*/*")) if path.is_file())
    return tuple(path for path in files if any(was_made_with(path, mark) for mark in marks))


def _plain(value: Any) -> Any:
    return value.tolist()
