"""The folder that a rehearsal leaves: maneuver, calibration, card, decoded columns, truth, a summary."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tfsat_host.cli.outputs import was_made_with
from tfsat_host.errors import UsageError

if TYPE_CHECKING:
    from tfsat_host.maneuver import Maneuver
    from tfsat_host.rehearsal.day import Drop
    from tfsat_host.sdlog import DropLog

MARK_FILE = ".tfsat-rehearsal"
"""A folder with this file was made by a rehearsal and may be made again by another."""

SUMMARY = "summary.json"


class RunFolder:
    """A folder for one rehearsal's files.

    Attributes:
        path: Of the folder.
        files: What was written.
        removed: What `evaluate` and `report` had made there of the recording that was replaced.
        maneuver: The file of the maneuver.

    Raises:
        UsageError: the folder holds something that no rehearsal made, and `force` is not set.
    """

    def __init__(self, path: Path, *, force: bool) -> None:
        self.path = path
        self.files: list[Path] = []
        self.removed: tuple[Path, ...] = ()
        self.maneuver = path / "maneuver.toml"
        if path.exists() and not path.is_dir():
            raise _refused(
                f"{path} is a file, and --out names a folder.", "Give the name of a folder with --out."
            )
        if path.is_dir() and any(path.iterdir()) and not (path / MARK_FILE).exists() and not force:
            raise _refused(
                f"{path} holds files that no rehearsal made.",
                "Give another folder with --out, or add --force.",
            )

    def write(self, maneuver: Maneuver, drop: Drop, truth_text: str) -> DropLog | None:
        """Writes what the day left, decodes the card from its file and exports it; gives the log, if there is one."""
        from tfsat_host.calibration.certificate.text import format_calibration
        from tfsat_host.cli.calibrate.options import EMULATED_CERTIFICATE
        from tfsat_host.emulated.truth import format_truth
        from tfsat_host.maneuver import format_maneuver

        self.path.mkdir(parents=True, exist_ok=True)
        self.removed = _derived_in(self.path)
        for stale in self.removed:
            stale.unlink()
        (self.path / MARK_FILE).write_text("made by tfsat-host rehearse\n", encoding="utf-8")
        self._file("maneuver.toml").write_text(format_maneuver(maneuver), encoding="utf-8")
        self._file(EMULATED_CERTIFICATE).write_text(format_calibration(drop.calibration), encoding="utf-8")
        self._file("truth.json").write_text(truth_text, encoding="utf-8")
        if drop.released_s is not None:
            self._file("truth.csv").write_text(format_truth(drop.truth, drop.released_s), encoding="utf-8")
        self.files.append(self.path / SUMMARY)
        return self._write_card(drop.card) if drop.card else None

    def _write_card(self, card: bytes) -> DropLog:
        from tfsat_host.cli.decoded_files import write_decoded
        from tfsat_host.sdlog import load

        path = self._file("SD.bin")
        path.write_bytes(card)
        log = load(path)
        self.files += write_decoded(log, self.path / "SD", ("csv",), force=True).files.values()
        return log

    def write_summary(self, result: Mapping[str, Any]) -> None:
        """Writes `summary.json`, the command's result."""
        text = json.dumps(result, indent=1, default=_plain)
        (self.path / SUMMARY).write_text(text + "\n", encoding="utf-8")

    def _file(self, name: str) -> Path:
        path = self.path / name
        self.files.append(path)
        return path


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


def _refused(what: str, next_step: str) -> UsageError:
    return UsageError(
        what=what,
        meaning="Nothing was flown, nothing was overwritten.",
        next_step=next_step,
    )
