"""The run folder of one rehearsal: maneuver, calibration, preflight, card, decoded columns, truth, a summary."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.certificate.recordings_archive import (
    kept_copy,
    recordings_folder,
    write_certificate,
)
from tfsat_host.json_values import format_json
from tfsat_host.maneuver import Maneuver, format_maneuver
from tfsat_host.output_files import was_made_with
from tfsat_host.plan.facility import load_tower
from tfsat_host.preflight.preflight_result import PreflightResult
from tfsat_host.rehearsal.day import PreflightOutcome
from tfsat_host.rehearsal.folder import ResultFolder
from tfsat_host.rehearsal.rehearsed_drop import Drop
from tfsat_host.rehearsal.truth_comparison import truth_table
from tfsat_host.report.figures import FORMATS
from tfsat_host.report.figures import MARKER as FIGURE
from tfsat_host.report.foxglove_export import MARKER as MCAP
from tfsat_host.run.campaign.campaign_folder import DROP, INDEX
from tfsat_host.run.certificate_check import is_of_robot, origin_of_log
from tfsat_host.run.drop_report import PAGE_MARKER
from tfsat_host.run.exports import write_decoded
from tfsat_host.run.files import (
    EMULATED_CERTIFICATE,
    EVALUATION_MARKER,
    MANEUVER,
    PREFLIGHT,
    RECORDING,
    REHEARSED,
    ROBOT,
    rehearsed_files,
)
from tfsat_host.run.held_maneuver import note_name, note_text
from tfsat_host.run.prepared_run import hashes_of, write_result
from tfsat_host.run.recorded_landing import note_landing_of
from tfsat_host.run.signed_record import RECORD
from tfsat_host.sdlog import DropLog, load
from tfsat_host.whole_file import write_whole

SUMMARY = "summary.json"
_DECODED = ("SD.csv", "SD.events.csv")


class RunFolder(ResultFolder):
    """See the module.

    Attributes:
        removed: What `evaluate` and `report` had made there of the recording that was replaced.
        collected: When the card was taken out, by the rehearsal's clock: all files have their times by it, so that the
            same rehearsal gives the same bytes. None: nothing was written yet.
    """

    def __init__(self, path: Path, *, force: bool) -> None:
        super().__init__(path, force=force)
        self.removed: tuple[Path, ...] = ()
        self.collected: datetime | None = None
        self._copies: set[Path] = set()

    def may_be_made_again(self, path: Path) -> bool:
        """`report` writes its page again."""
        return _is_derived(path)

    def stale(self) -> Iterable[Path]:
        """Find the files that `evaluate` and `report` derived from the recording being replaced."""
        # Copies that were there before are not this rehearsal's to mark or remove.
        self._copies = set(self._certificates())
        rehearsed_names = rehearsed_files(self.path)
        self.removed = tuple(
            path for path in _derived_in(self.path) if self._name(path) not in rehearsed_names
        )
        return self.removed

    def written_paths(self) -> list[Path]:
        """Also the certificate's copies, whose names tell what is in them."""
        return list(
            dict.fromkeys((*super().written_paths(), *sorted(set(self._certificates()) - self._copies)))
        )

    def _certificates(self) -> Iterator[Path]:
        return self.path.glob("calibration-emulated-recordings/certificate-*")

    def write(self, maneuver: Maneuver, drop: Drop, robot: bytes, truth_text: str) -> DropLog | None:
        """Writes what the day left, decodes the card from its file and exports it; gives the log, if there is one.

        Inside `replace_files`.
        """
        self.collected = drop.collected
        self.file(MANEUVER).write_text(format_maneuver(maneuver), encoding="utf-8")
        self.file(ROBOT).write_bytes(robot)
        certificate = self._write_certificate(drop)
        self.file("truth.json").write_text(truth_text, encoding="utf-8")
        if drop.released_s is not None:
            self.file("truth.csv").write_text(truth_table(drop), encoding="utf-8")
        if drop.preflight is not None:
            self._write_preflight(drop.preflight, certificate)
        self.file(SUMMARY)
        log = self._write_card(drop.card) if drop.card else None
        if log is not None:
            self._note_landing(log, drop, certificate)
            if drop.held_maneuver is not None:
                text = note_text(drop.held_maneuver, log.session, "rehearse")
                self.file(note_name(log.session)).write_text(text, encoding="utf-8")
        return log

    def _write_certificate(self, drop: Drop) -> Path:
        """Write the certificate as `tfsat-host calibrate` does.

        With it go its recordings and a copy that stays as the preflight signs it.
        """
        certificate = self.file(EMULATED_CERTIFICATE)
        folder_name = recordings_folder(certificate).name
        for recording in drop.calibration.recordings:
            write_whole(self.file(f"{folder_name}/{recording.file}"), drop.recordings[recording.file])
        # Writing the certificate makes this copy, too: note it first, so that an interruption removes it.
        self.file(f"{folder_name}/{kept_copy(certificate, drop.calibration).name}")
        write_certificate(certificate, drop.calibration)
        return certificate

    def _note_landing(self, log: DropLog, drop: Drop, certificate: Path) -> None:
        """Note the landing in the certificate as `decode` would, but by the rehearsal's clock.

        The evaluation then finds it there.
        """
        # Another robot's certificate, a fault that can be rehearsed, must not get this one's landing.
        if not is_of_robot(drop.calibration, origin_of_log(log.header)):
            return
        note_landing_of(log, certificate, drop.calibration, now=drop.collected)
        copy = kept_copy(certificate, read_calibration(certificate))
        # With the landing it is another certificate, which has a permanent copy of its own.
        if copy not in self.files:
            self.files.append(copy)
            self.mark()

    def _write_preflight(self, preflight: PreflightOutcome, certificate: Path) -> None:
        """Write and sign the preflight result as `tfsat-host preflight` does."""
        files = {
            "maneuver": self.path / MANEUVER,
            "calibration": certificate,
            "robot": self.path / ROBOT,
            "facility": load_tower(None).path,
        }
        result = PreflightResult(preflight.evidence, preflight.checks, hashes_of(files))
        self.file(RECORD)
        self.file(PREFLIGHT)
        write_result(self.path, result)

    def _write_card(self, card: bytes) -> DropLog:
        path = self.file(RECORDING)
        path.write_bytes(card)
        log = load(path)
        for name in _DECODED:
            self.announce(name)
        self.files += write_decoded(log, self.path / "SD", ("csv",), force=True).files.values()
        self.mark()
        return log

    def write_summary(self, result: Mapping[str, Any]) -> None:
        """Writes `summary.json`, the command's result."""
        (self.path / SUMMARY).write_text(format_json(result), encoding="utf-8")
        self.seal()


def _derived_in(folder: Path) -> tuple[Path, ...]:
    """Results of `evaluate` and `report`: next to another recording they would be taken for its.

    In subfolders `report` puts figures; one that is a run of its own, or a campaign's, is not looked into.
    """
    # By the marks in them, not by names: a person's file that is named alike stays.
    files = [path for path in folder.glob("*") if path.is_file() and _is_derived(path)]
    figures = [
        path
        for place in folder.glob("*")
        if place.is_dir() and not place.is_symlink() and not _is_a_run(place)
        for path in place.glob("*")
        if path.is_file() and path.suffix[1:] in FORMATS and was_made_with(path, FIGURE)
    ]
    return tuple(sorted((*files, *figures)))


def _is_a_run(folder: Path) -> bool:
    """Return whether the folder is of another drop or a campaign.

    Any file that marks a run is enough.
    """
    signs = (REHEARSED, MANEUVER, SUMMARY, DROP, INDEX, PREFLIGHT, RECORD)
    return any((folder / sign).exists() for sign in signs) or any(
        path.suffix.lower() == ".bin" for path in folder.glob("*")
    )


def _is_derived(path: Path) -> bool:
    """Return whether the file bears the mark of a command that derives files from a recording."""
    return any(was_made_with(path, mark) for mark in (EVALUATION_MARKER, PAGE_MARKER, FIGURE, MCAP))
