"""A bundled drop computed again from raw, and what differs."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from pathlib import Path, PurePosixPath
from typing import Any

from tfsat_host.calibration.calibration_errors import CalibrationError
from tfsat_host.calibration.certificate.calibration_campaign import measured_by, with_measured
from tfsat_host.calibration.certificate.certificate import QUANTITY_NAMES, Calibration, in_words
from tfsat_host.calibration.certificate.file import certificate_values, read_calibration
from tfsat_host.calibration.certificate.recordings_archive import recordings_folder
from tfsat_host.calibration.servos.visits import servo_map_of
from tfsat_host.calibration.solution import solve
from tfsat_host.calibration.steps.evidence import Evidence, from_bytes, sha256
from tfsat_host.errors import TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import SILENT, Notices, printable
from tfsat_host.robot import RobotModel, load_robot
from tfsat_host.run.bundle import making
from tfsat_host.run.bundle.bundle_archive import unpack
from tfsat_host.run.bundle.contents import RUN, not_as_checked
from tfsat_host.run.bundle.json_comparison import (
    CERTIFICATE_TOLERANCE,
    EVALUATION_TOLERANCE,
    NOT_THERE,
    REPORT_TOLERANCE,
    Difference,
    Tolerance,
    differences,
)
from tfsat_host.run.bundle.making import RecomputedEvaluation
from tfsat_host.run.bundle.manifest import (
    ENVIRONMENT,
    EVALUATION,
    REPORT,
    BundleError,
    Manifest,
    changed_since,
)
from tfsat_host.run.files import PREFLIGHT
from tfsat_host.run.signed_record import verify

_RESULTS = ("truth.*", "summary.json", "report.html", "evaluation.json")
"""Of a run's folder: results of a rehearsal or of an earlier evaluation."""
_DOCUMENT = re.compile(r'<script type="application/json" id="document">(.*?)</script>', re.DOTALL)
_UNREADABLE = object()
_OF_ITS_TIME = ("made_by", "made_at")
"""Of a result: who made it and when differs rightly."""


@dataclass(frozen=True)
class ComparedPart:
    """One part of a bundle, computed again.

    Attributes:
        what: `evaluation`, `report` or `calibration`.
        differs: How; None: it was not computed again, and that is no difference.
        sentence: What was done, or why not.
        lacking: It should have been computed and could not be.
        refused: The raw data give none.
    """

    what: str
    differs: Sequence[Difference] | None
    sentence: str
    lacking: bool = False
    refused: bool = False


@dataclass(frozen=True, eq=False)
class Reproduction:
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
    compared: tuple[ComparedPart, ...]
    record: tuple[str, ...]
    environment: tuple[str, ...]

    @property
    def same(self) -> bool:
        """What was computed does not differ."""
        return not any(part.differs for part in self.compared)

    @property
    def incomplete(self) -> list[str]:
        """Why sameness is worth less than it seems: what could not be computed, is lost, or was changed."""
        return [
            *(f"NOT COMPUTED: {part.sentence}" for part in self.compared if part.lacking),
            *(
                f"LOST: {missing_part.what}: {missing_part.why}"
                for missing_part in self.manifest.missing
                if missing_part.lost
            ),
            *(f"CHANGED: {sentence}" for sentence in self.record),
            *(f"DOUBTFUL: {sentence}" for sentence in self.manifest.doubts),
        ]

    def as_dict(self) -> dict[str, Any]:
        """Return the outcome as a dict for JSON."""
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
                    "what": part.what,
                    "sentence": part.sentence,
                    "lacking": part.lacking,
                    "differences": None if part.differs is None else [asdict(each) for each in part.differs],
                }
                for part in self.compared
            ],
            "not_computed": [name for name in sorted(self.manifest.files) if _is_result(name)],
            "record": list(self.record),
            "doubts": list(self.manifest.doubts),
            "missing": [asdict(missing_part) for missing_part in self.manifest.missing],
            "environment": list(self.environment),
        }


def reproduce(
    bundle: Path | str, folder: Path | str | None = None, notices: Notices = SILENT
) -> Reproduction:
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
    if not bundle.is_file():
        is_folder = bundle.is_dir()
        what = f"{bundle} is a folder" if is_folder else f"There is no file {bundle}"
        make = "To make one of a run" if is_folder else "Name the file; to make one of a run"
        raise BundleError(
            what=f"{what}; BUNDLE is a file that {NextStep('bundle')} makes, such as run.tfsat.zip.",
            meaning="Nothing was unpacked.",
            next_step=Advice(f"{make}: ", NextStep("bundle", (str(bundle) if is_folder else "RUN",))),
        )
    folder = Path(folder or bundle.name.removesuffix(".zip").removesuffix(".tfsat") + "-reproduced")
    with notices.progress("Unpacking and checking"):
        manifest, manifest_sha256 = unpack(bundle, folder)
    with notices.progress(f"Recomputing {printable(manifest.name)}"):
        recomputation = making.recompute(folder, manifest.name, manifest.evaluated)
        compared = (
            _evaluation(folder, recomputation),
            _report(folder, recomputation),
            *_calibrations(folder, manifest, recomputation),
        )
    # What was wrong when it was bundled stays wrong, even if it no longer shows in the copies.
    record = tuple(_find_changes(folder, manifest)) or manifest.record
    environment = tuple(changed_since(_load(folder / ENVIRONMENT)))
    return Reproduction(folder, manifest, manifest_sha256, compared, record, environment)


def _is_result(name: str) -> bool:
    """Return whether a file in the run's folder is the result of an earlier command.

    Such a file is kept by its hash and not recomputed.
    """
    path = PurePosixPath(name)
    return path.match(f"{RUN}/*") and any(path.match(pattern) for pattern in _RESULTS)


def _find_changes(folder: Path, manifest: Manifest) -> list[str]:
    """List the deviations from the run's record and its preflight, as sentences."""
    run = folder / RUN
    if not run.is_dir():
        return []
    at_hand = {name: file.sha256 for name, file in manifest.files.items()}
    checked = not_as_checked(_load(run / PREFLIGHT), at_hand, manifest.evaluated)
    return [*(finding.sentence for finding in verify(run)), *checked]


def _evaluation(folder: Path, recomputation: RecomputedEvaluation) -> ComparedPart:
    bundled = _load(folder / EVALUATION)
    if bundled is _UNREADABLE:
        there = (folder / EVALUATION).is_file()
        differs = [Difference(EVALUATION, "unreadable" if there else NOT_THERE, "an evaluation", None)]
        sentence = "The bundled evaluation cannot be read." if there else "The bundle has no evaluation."
        return ComparedPart(
            "evaluation", differs, f"{sentence} What the raw data give is not held against anything."
        )
    differs = _differences(bundled, recomputation.evaluation, EVALUATION_TOLERANCE)
    if "error" in recomputation.evaluation:
        then = "now, and was not then" if differs else "now as then"
        why = recomputation.evaluation["error"]["what"]
        return ComparedPart(
            "evaluation", differs, f"The drop cannot be evaluated, {then}: {why}", refused=True
        )
    count = _numbers(recomputation.evaluation)
    return ComparedPart("evaluation", differs, f"{count} numbers were decoded and evaluated again.")


def _report(folder: Path, recomputation: RecomputedEvaluation) -> ComparedPart:
    bundled: Any = NOT_THERE
    sentence = "The bundle has no report."
    try:
        # Compare the data embedded in the page and not its markup.
        bundled = document_in((folder / REPORT).read_text(encoding="utf-8"))
    except FileNotFoundError:
        if recomputation.page is None:
            return ComparedPart("report", None, "There is none, now as then.")
    except ValueError as error:
        bundled, sentence = "unreadable", f"The bundled page cannot be read: {error}."
    if isinstance(bundled, str):
        return ComparedPart("report", [Difference("report", bundled, "a page", None)], sentence)
    if recomputation.page is None:
        sentence = "The bundle has a report, and none can be made."
        return ComparedPart("report", [Difference("report", "a page", NOT_THERE, None)], sentence)
    document = document_in(recomputation.page)
    differs = _differences(bundled, document, REPORT_TOLERANCE)
    return ComparedPart("report", differs, f"{_numbers(document)} numbers of the page were made again.")


def document_in(page: str) -> Any:
    """Parse the document embedded in a report page. Raises ValueError: there is none."""
    match = _DOCUMENT.search(page)
    if match is None:
        raise ValueError("it holds no document")
    try:
        return json.loads(match[1])
    except RecursionError as error:
        raise ValueError("its document is nested too deeply") from error


def _calibrations(
    folder: Path, manifest: Manifest, recomputation: RecomputedEvaluation
) -> list[ComparedPart]:
    """Recompute and compare the bundle's certificate.

    The previous certificate is compared, too, if it was the one in force at the release.
    """
    inputs = manifest.evaluated
    if inputs.calibration is None:
        return [ComparedPart("calibration", None, "The bundle has no certificate.")]
    parts = []
    names = dict.fromkeys(
        [inputs.calibration, *([recomputation.certificate] if recomputation.certificate else [])]
    )
    for name in (name for name in names if name in manifest.files):
        try:
            robot = load_robot(None if inputs.robot is None else folder / inputs.robot)
            parts.append(_recalibrate(folder / name, robot, name))
        except TfsatError as error:
            parts.append(ComparedPart("calibration", None, error.what, lacking=True))
    return parts


def _recalibrate(certificate: Path, model: RobotModel, name: str) -> ComparedPart:
    """Recompute a certificate from its recordings and compare the two.

    The recordings lie in their folder next to it, or beside the certificate itself.

    Raises:
        CalibrationError: the certificate cannot be read.
    """
    calibration, archive_folder = read_calibration(certificate), recordings_folder(certificate)
    recordings = archive_folder if archive_folder.is_dir() else certificate.parent
    drawn_text = (
        f" Not recorded in a rehearsal, but drawn: {in_words(calibration.simulated_quantities)}."
        if calibration.simulated_quantities
        else ""
    )
    if not calibration.recordings:
        why = "The certificate names no recordings: its values cannot be recomputed."
        return ComparedPart("calibration", None, f"{name}: {why}{drawn_text}")
    try:
        evidence = [
            _evidence(recordings / recording.file, recording.sha256) for recording in calibration.recordings
        ]
        # Which landing it knew when it was computed is not recorded: solve with each, keep the closest.
        tried = [
            _solved_differently(calibration, evidence, model, landing) for landing in _landings(calibration)
        ]
    except CalibrationError as error:
        why = f"The calibration cannot be recomputed: {error.what}"
        return ComparedPart("calibration", None, f"{name}: {why}", lacking=True)
    of = f"{len(evidence)} recording{'' if len(evidence) == 1 else 's'}"
    sentence, unmeasured_names = f"The calibration was recomputed from {of}.", []
    if calibration.simulated_quantities:
        measured = measured_by(evidence)
        # Neither drawn by the rehearsal nor recorded: these values rest on nothing that was bundled.
        unmeasured_names = [
            quantity
            for quantity in QUANTITY_NAMES
            if quantity not in (*calibration.simulated_quantities, *measured)
        ]
        sentence = f"Recomputed from {of}: {in_words(measured)}.{drawn_text}"
        sentence += f" Neither recorded nor drawn: {in_words(unmeasured_names)}." if unmeasured_names else ""
    return ComparedPart("calibration", min(tried, key=len), f"{name}: {sentence}", bool(unmeasured_names))


def _landings(calibration: Calibration) -> list[datetime | None]:
    """List the landings that may have been the last one known when the certificate was computed.

    A landing noted later is in the certificate, too, but did not change its values.
    """
    newest = max(recording.recorded_at for recording in calibration.recordings)
    landing_times = [landing.at for landing in calibration.landings]
    before = [at for at in landing_times if at <= newest]
    # The likeliest first: the last one before the newest recording, then back to none.
    return list(dict.fromkeys([*reversed(before), None, *(at for at in landing_times if at > newest)]))


def _solved_differently(
    calibration: Calibration, evidence: Sequence[Evidence], model: RobotModel, landing: datetime | None
) -> list[Difference]:
    if calibration.simulated_quantities:
        again = with_measured(calibration, evidence, model)
    else:
        solution = solve(evidence, model, landing)
        servos = sorted(solution.servos, key=lambda servo: servo[0].step.joint or 0)
        again = replace(
            calibration,
            gyros=solution.gyros,
            joints=solution.joints,
            servo_maps=tuple(
                servo_map_of(servo_evidence, joints, model) for servo_evidence, joints in servos
            ),
            servo_recorded_at=tuple(servo_evidence.recorded_at for servo_evidence, _ in servos),
        )
    # Compare the values that the certificate's file holds.
    then, now = (_plain(certificate_values(version)) for version in (calibration, again))
    return differences(then, now, CERTIFICATE_TOLERANCE)


def _plain(value: Any) -> Any:
    """Times as text."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    return value.isoformat() if isinstance(value, datetime) else value


def _evidence(path: Path, expected_sha256: str) -> Evidence:
    data = path.read_bytes() if path.is_file() else None
    if data is not None and sha256(data) == expected_sha256:
        return from_bytes(data, source=path.name)
    why = "is not there" if data is None else "is not the one on which it rests: its SHA-256 differs"
    raise CalibrationError(
        what=f"the recording {path.name} {why}.",
        meaning="Its step cannot be computed again.",
        next_step="Copy it next to the certificate and bundle the run again.",
    )


def _differences(bundled: Any, recomputed: Any, tolerance: Tolerance) -> list[Difference]:
    return [
        difference
        for difference in differences(bundled, recomputed, tolerance)
        if difference.key not in _OF_ITS_TIME
    ]


def _load(path: Path) -> Any:
    """Read a JSON file of the bundle, whose hash is right; return `_UNREADABLE` if it is not JSON."""
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
