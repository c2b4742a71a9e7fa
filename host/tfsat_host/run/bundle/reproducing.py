"""A bundled drop computed again from raw, and what differs."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import SILENT, Notices, printable
from tfsat_host.quantity import Column, Columns, fields
from tfsat_host.run.bundle import making
from tfsat_host.run.bundle.bundle_archive import unpack
from tfsat_host.run.bundle.contents import RUN, CheckedBefore, not_as_checked
from tfsat_host.run.bundle.json_comparison import (
    COMPARED,
    EVALUATION_TOLERANCE,
    NOT_THERE,
    REPORT_TOLERANCE,
    ComparedPart,
    Difference,
    Tolerance,
    count_numbers,
    differences,
)
from tfsat_host.run.bundle.making import RecomputedEvaluation
from tfsat_host.run.bundle.manifest import (
    ENVIRONMENT,
    EVALUATION,
    MISSING,
    REPORT,
    BundleError,
    Manifest,
    changed_since,
)
from tfsat_host.run.bundle.recalibration import recalibrate
from tfsat_host.run.signed_record import verify

_RESULTS = ("truth.*", "summary.json", "report.html", "evaluation.json")
"""Of a run's folder: results of a rehearsal or of an earlier evaluation."""
_DOCUMENT = re.compile(r'<script type="application/json" id="document">(.*?)</script>', re.DOTALL)
_UNREADABLE = object()
_OF_ITS_TIME = ("made_by", "made_at")
"""Of a result: who made it and when differs rightly."""
_PROGRAM = ("tfsat:", "sources_sha256:")
"""How a sentence on the environment begins that is of this program."""


@dataclass(frozen=True, eq=False)
class Reproduction:
    """A bundle, computed again.

    Attributes:
        bundle: The archive.
        folder: Where the bundle was unpacked.
        manifest: Of the bundle.
        manifest_sha256: Of its file.
        compared: Evaluation, report and calibration.
        record: What is not as the run's record and its preflight say; sentences.
        environment: With what else it was computed than then; sentences.
    """

    bundle: Path
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
            *(f"LOST: {part.what}: {part.why}" for part in self.manifest.lost),
            *(f"CHANGED: {sentence}" for sentence in self.record),
            *(f"DOUBTFUL: {sentence}" for sentence in self.manifest.doubts),
        ]

    @property
    def not_computed(self) -> list[str]:
        """Results of earlier commands in the run's folder: kept by their hash."""
        return [name for name in sorted(self.manifest.files) if _is_result(name)]

    @property
    def program_changed(self) -> bool:
        """Whether the bundle was made by other sources of tfsat than these."""
        return any(sentence.startswith(_PROGRAM) for sentence in self.environment)


REPRODUCTION: Columns = (
    *fields("bundle same"),
    Column("complete", of=lambda reproduction: not reproduction.incomplete),
    *fields("incomplete manifest_sha256 folder name=manifest.name"),
    Column("files", of=lambda reproduction: len(reproduction.manifest.files)),
    Column("compared", columns=COMPARED),
    *fields("not_computed record doubts=manifest.doubts"),
    Column("missing", of="manifest.missing", columns=MISSING),
    *fields("environment"),
)
"""Of `reproduce --json`."""


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
            *recalibrate(folder, manifest, recomputation.certificate),
        )
    # What was wrong when it was bundled stays wrong, even if it no longer shows in the copies.
    record = tuple(_find_changes(folder, manifest)) or manifest.record
    environment = tuple(changed_since(_load(folder / ENVIRONMENT)))
    return Reproduction(bundle, folder, manifest, manifest_sha256, compared, record, environment)


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
    checked = not_as_checked(CheckedBefore.read(run), at_hand, manifest.evaluated)
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
    count = count_numbers(recomputation.evaluation)
    sentence = f"{count} numbers were decoded and evaluated again."
    return ComparedPart("evaluation", differs, sentence, f"{count:,} numbers", EVALUATION_TOLERANCE)


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
    count = count_numbers(document)
    sentence = f"{count} numbers of the page were made again."
    return ComparedPart("report", differs, sentence, f"{count:,} numbers", REPORT_TOLERANCE)


def document_in(page: str) -> Any:
    """Parse the document embedded in a report page. Raises ValueError: there is none."""
    match = _DOCUMENT.search(page)
    if match is None:
        raise ValueError("it holds no document")
    try:
        return json.loads(match[1])
    except RecursionError as error:
        raise ValueError("its document is nested too deeply") from error


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
