"""A bundled drop computed again from raw, and what differs."""

from __future__ import annotations

import json
import shlex
from dataclasses import asdict, dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from tfsat_host.errors import TfsatError
from tfsat_host.notices import SILENT, Notices, printable
from tfsat_host.robot import load_robot
from tfsat_host.run.bundle import recomputing
from tfsat_host.run.bundle.archive import unpack
from tfsat_host.run.bundle.collecting import RUN
from tfsat_host.run.bundle.comparing import (
    EVALUATION_TOLERANCE,
    NOT_THERE,
    REPORT_TOLERANCE,
    Compared,
    Difference,
    Tolerance,
    differences,
)
from tfsat_host.run.bundle.doubts import not_as_checked
from tfsat_host.run.bundle.environment import changed_since
from tfsat_host.run.bundle.manifest import ENVIRONMENT, EVALUATION, REPORT, BundleError, Manifest
from tfsat_host.run.bundle.recalibrating import recalibrate, recordings_of
from tfsat_host.run.bundle.recomputing import Recomputed, document_in
from tfsat_host.run.files import PREFLIGHT
from tfsat_host.run.record import verify

_RESULTS = ("truth.*", "summary.json", "report.html", "evaluation.json")
"""Of a run's folder: what a rehearsal or an earlier evaluation said."""
_UNREADABLE = object()
_OF_ITS_TIME = ("made_by", "made_at")
"""Of a result: who made it and when differs rightly."""


@dataclass(frozen=True, eq=False)
class Reproduced:
    """What came of it.

    Attributes:
        folder: Where the bundle was unpacked.
        manifest: Of the bundle.
        manifest_sha256: Of its file.
        compared: Evaluation, report and calibration.
        record: What is not as the run's record and its preflight say; sentences.
        environment: With what else it was computed than then; sentences.
    """

    folder: Path
    manifest: Manifest
    manifest_sha256: str
    compared: tuple[Compared, ...]
    record: tuple[str, ...]
    environment: tuple[str, ...]

    @property
    def same(self) -> bool:
        """What was computed does not differ."""
        return not any(one.differs for one in self.compared)

    @property
    def incomplete(self) -> list[str]:
        """Why sameness says less than it seems to: what could not be computed, is lost, or was changed."""
        return [
            *(f"NOT COMPUTED: {one.sentence}" for one in self.compared if one.lacking),
            *(f"LOST: {one.what}: {one.why}" for one in self.manifest.missing if one.lost),
            *(f"CHANGED: {sentence}" for sentence in self.record),
            *(f"DOUBTFUL: {sentence}" for sentence in self.manifest.doubts),
        ]

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "same": self.same,
            "complete": not self.incomplete,
            "incomplete": self.incomplete,
            "manifest_sha256": self.manifest_sha256,
            "folder": str(self.folder),
            "name": self.manifest.name,
            "files": len(self.manifest.files),
            "compared": [
                {
                    "what": one.what,
                    "sentence": one.sentence,
                    "lacking": one.lacking,
                    "differences": None if one.differs is None else [asdict(each) for each in one.differs],
                }
                for one in self.compared
            ],
            "not_computed": [name for name in sorted(self.manifest.files) if _is_result(name)],
            "record": list(self.record),
            "doubts": list(self.manifest.doubts),
            "missing": self.manifest.as_dict()["missing"],
            "environment": list(self.environment),
        }


def reproduce(bundle: Path | str, folder: Path | str | None = None, notices: Notices = SILENT) -> Reproduced:
    """Unpacks a bundle, checks every hash, computes evaluation, report and calibration, and compares.

    Args:
        bundle: The archive.
        folder: A new one to unpack into; None: NAME-reproduced here, for NAME.tfsat.zip.
        notices: For progress.

    Raises:
        BundleError: the archive is none, is damaged or is not safe; nothing was unpacked.
        OSError: something cannot be read or written.
    """
    bundle = Path(bundle)
    _require_file(bundle)
    folder = Path(folder or bundle.name.removesuffix(".zip").removesuffix(".tfsat") + "-reproduced")
    with notices.progress("Unpacking and checking"):
        manifest, manifest_sha256 = unpack(bundle, folder)
    with notices.progress(f"Computing {printable(manifest.name)} anew"):
        done = recomputing.recompute(folder, manifest.name, manifest.evaluated)
        compared = (
            _evaluation(folder, done),
            _report(folder, done),
            *_calibrations(folder, manifest, done),
        )
    record = tuple(_changed(folder, manifest)) or manifest.record
    environment = tuple(changed_since(_load(folder / ENVIRONMENT)))
    return Reproduced(folder, manifest, manifest_sha256, compared, record, environment)


def _require_file(bundle: Path) -> None:
    """Raises BundleError: there is none."""
    if bundle.is_file():
        return
    what = f"{bundle} is a folder" if bundle.is_dir() else f"There is no file {bundle}"
    raise BundleError(
        what=f"{what}; BUNDLE is a file that tfsat-host bundle makes, such as run.tfsat.zip.",
        meaning="Nothing was unpacked.",
        next_step=f"To make one of a run: tfsat-host bundle {shlex.quote(str(bundle))}"
        if bundle.is_dir()
        else "Name the file; to make one of a run: tfsat-host bundle RUN",
    )


def _is_result(name: str) -> bool:
    """Of an earlier command, in the run's folder: it is kept by its hash, and not made again."""
    path = PurePosixPath(name)
    return path.match(f"{RUN}/*") and any(path.match(pattern) for pattern in _RESULTS)


def _changed(folder: Path, manifest: Manifest) -> list[str]:
    """What is not as the run's record and its preflight say; sentences."""
    run = folder / RUN
    if not run.is_dir():
        return []
    at_hand = {name: file.sha256 for name, file in manifest.files.items()}
    checked = not_as_checked(_load(run / PREFLIGHT), at_hand, manifest.evaluated)
    return [*(finding.sentence for finding in verify(run)), *checked]


def _evaluation(folder: Path, done: Recomputed) -> Compared:
    bundled = _load(folder / EVALUATION)
    if bundled is _UNREADABLE:
        there = (folder / EVALUATION).is_file()
        differs = [Difference(EVALUATION, "unreadable" if there else NOT_THERE, "an evaluation", None)]
        sentence = "The bundled evaluation cannot be read." if there else "The bundle has no evaluation."
        return Compared(
            "evaluation", differs, f"{sentence} What the raw data give is not held against anything."
        )
    differs = _differences(bundled, done.evaluation, EVALUATION_TOLERANCE)
    if "error" in done.evaluation:
        then = "now, and was not then" if differs else "now as then"
        why = done.evaluation["error"]["what"]
        return Compared("evaluation", differs, f"The drop cannot be evaluated, {then}: {why}", refused=True)
    count = _numbers(done.evaluation)
    return Compared("evaluation", differs, f"{count} numbers were decoded and evaluated anew.")


def _report(folder: Path, done: Recomputed) -> Compared:
    def other(bundled: str, now: str, sentence: str) -> Compared:
        return Compared("report", [Difference("report", bundled, now, None)], sentence)

    try:
        bundled = document_in((folder / REPORT).read_text(encoding="utf-8"))
    except FileNotFoundError:
        if done.page is None:
            return Compared("report", None, "There is none, now as then.")
        return other(NOT_THERE, "a page", "The bundle has no report.")
    except ValueError as error:
        return other("unreadable", "a page", f"The bundled page cannot be read: {error}.")
    if done.page is None:
        return other("a page", NOT_THERE, "The bundle has a report, and none can be made.")
    document = document_in(done.page)
    differs = _differences(bundled, document, REPORT_TOLERANCE)
    return Compared("report", differs, f"{_numbers(document)} numbers of the page were made anew.")


def _calibrations(folder: Path, manifest: Manifest, done: Recomputed) -> list[Compared]:
    """The certificate that lay there, and the one before it if that held at the release."""
    used = manifest.evaluated
    if used.calibration is None:
        return [Compared("calibration", None, "The bundle has no certificate.")]
    found = []
    names = dict.fromkeys([used.calibration, *([done.certificate] if done.certificate else [])])
    for name in (name for name in names if name in manifest.files):
        try:
            robot = load_robot(None if used.robot is None else folder / used.robot)
            found.append(recalibrate(folder / name, recordings_of(folder / name), robot, name))
        except TfsatError as error:
            found.append(Compared("calibration", None, error.what, lacking=True))
    return found


def _differences(bundled: Any, recomputed: Any, tolerance: Tolerance) -> list[Difference]:
    return [one for one in differences(bundled, recomputed, tolerance) if one.key not in _OF_ITS_TIME]


def _load(path: Path) -> Any:
    """A JSON file of the bundle, whose hash is right; `_UNREADABLE` if it is none."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError, RecursionError):
        return _UNREADABLE


def _numbers(value: Any) -> int:
    if isinstance(value, dict):
        return sum(map(_numbers, value.values()))
    if isinstance(value, list):
        return sum(map(_numbers, value))
    return isinstance(value, int | float) and not isinstance(value, bool)
