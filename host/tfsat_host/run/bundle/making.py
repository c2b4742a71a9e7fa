"""A bundle: a drop's files, its evaluation and report as of now, and a manifest of them, in one archive."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

from tfsat_host import __version__
from tfsat_host.calibration.certificate.recordings_archive import recordings_folder
from tfsat_host.error_columns import error_columns
from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import sha256_of
from tfsat_host.json_values import format_json, jsonable
from tfsat_host.notices import SILENT, Notices
from tfsat_host.output_files import OutputFile, check_may_write, new_folder_of, tell_new_folder, write_all
from tfsat_host.quantity import Columns, fields, record
from tfsat_host.report import render
from tfsat_host.report.contents.document_builder import Source, document_of
from tfsat_host.run import drop_evaluation
from tfsat_host.run.bundle.bundle_archive import MARKER, write_archive
from tfsat_host.run.bundle.contents import (
    RUN,
    BundleContents,
    CheckedBefore,
    collect,
    doubts_of,
    not_as_checked,
)
from tfsat_host.run.bundle.manifest import (
    ENVIRONMENT,
    EVALUATION,
    MANIFEST,
    NAME_CHARACTERS_MAX,
    REPORT,
    BundledFile,
    EvaluationInputs,
    Manifest,
    environment,
    format_manifest,
)
from tfsat_host.run.certificate_check import origin_of_log
from tfsat_host.run.drop_evaluation import EVALUATED_RUN, MADE_BY
from tfsat_host.run.drop_report import report_drop
from tfsat_host.run.files import AS_FOUND, MANEUVER, EvaluationOptions, names_of
from tfsat_host.run.signed_record import verify

ENDING = ".tfsat.zip"
# For a recording without a time of day: a fixed date keeps the bundle's bytes reproducible.
_NO_TIME = datetime(1980, 1, 1, tzinfo=UTC)
_SOURCES = ("robot", "calibration", "maneuver", "video", "laser", "facility")
"""In the order in which a report names them."""


@dataclass(frozen=True, eq=False)
class WrittenBundle:
    """A bundle that was written.

    Attributes:
        target: The archive.
        manifest: What is in it.
        manifest_sha256: Of the manifest's file, which has the SHA-256 of all files.
        recording: What of the recording is there, for people.
    """

    target: Path
    manifest: Manifest
    manifest_sha256: str
    recording: str

    @property
    def bytes(self) -> int:
        """Size of the archive."""
        return self.target.stat().st_size

    @property
    def is_whole(self) -> bool:
        """Whether nothing was lost, changed, or is doubtful."""
        return not (self.manifest.record or self.manifest.doubts or self.manifest.lost)


BUNDLE: Columns = fields("bundle=target recording bytes manifest_sha256")
"""Of `bundle --json`, before the manifest's."""
_LOGGER_IMAGE = fields("firmware image_crc serial=logger_serial emulated")


@dataclass(frozen=True)
class RecomputedEvaluation:
    """What an evaluation from the raw data gave.

    Attributes:
        evaluation: The object of `evaluate --json`, with paths relative to the bundle; of a drop that cannot be
            evaluated, `error`.
        page: The report; None: there is nothing to report.
        certificate: The certificate that held at the release, relative to the bundle; None: there is none.
    """

    evaluation: dict[str, Any]
    page: str | None
    certificate: str | None


def bundle(
    place: Path,
    options: EvaluationOptions = AS_FOUND,
    target: Path | None = None,
    *,
    force: bool = False,
    notices: Notices = SILENT,
) -> WrittenBundle:
    """Collects, evaluates with these options, writes. The same run gives the same bytes.

    `place` is a recording, or its folder; `target` None: the archive's name and `ENDING` in the current
    folder. With `force` a file that is no bundle may be overwritten.

    Raises:
        TfsatError: a file that was named is not there, or something is in the way. Nothing was written.
    """
    contents, inputs = collect(place, options)
    name = names_of([contents.recording])[0][:NAME_CHARACTERS_MAX]
    target = target or Path(f"{name}{ENDING}")
    check_may_write(target, marker=MARKER, force=force)
    new_folder = new_folder_of(target)
    with tempfile.TemporaryDirectory(prefix="tfsat-bundle-") as temporary_folder:
        folder = Path(temporary_folder)
        with notices.progress(f"Evaluating {name}"):
            manifest = _stage_bundle(folder, contents, inputs, name)
        files = {inside: folder / inside for inside in (*manifest.files, MANIFEST)}
        write_all([OutputFile(target, MARKER, partial(write_archive, files=files))], force=force)
        manifest_sha256 = sha256_of(folder / MANIFEST)
    tell_new_folder(new_folder, notices)
    log, recording = contents.log, "cannot be decoded"
    if log is not None:
        recording = f"{log.verdict}: {len(log)} samples, {log.samples_lost} lost"
    return WrittenBundle(target, manifest, manifest_sha256, recording)


def _stage_bundle(folder: Path, contents: BundleContents, inputs: EvaluationInputs, name: str) -> Manifest:
    """Lays out the bundle in a folder and evaluates it there, as `reproduce` will."""
    for inside, path in contents.files.items():
        (folder / inside).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, folder / inside)
    # Evaluate the copies and not the originals: what is bundled is what was computed from.
    recomputation = recompute(folder, name, inputs)
    computed_texts = {
        EVALUATION: format_json(recomputation.evaluation),
        ENVIRONMENT: format_json(environment()),
    }
    if recomputation.page is None:
        contents.lack(
            REPORT, f"The drop cannot be evaluated: {recomputation.evaluation['error']['what']}", lost=True
        )
    else:
        computed_texts[REPORT] = recomputation.page
    for inside, text in computed_texts.items():
        # As bytes: ends of lines must not depend on the system.
        (folder / inside).write_bytes(text.encode())
    files = {
        inside: BundledFile(sha256_of(folder / inside), (folder / inside).stat().st_size)
        for inside in sorted((*contents.files, *computed_texts))
    }
    preflight = CheckedBefore.read(folder / RUN)
    checked = not_as_checked(preflight, {name: file.sha256 for name, file in files.items()}, inputs)
    manifest = Manifest(
        f"tfsat-host bundle {__version__}",
        name,
        inputs,
        _images(contents, preflight),
        files,
        tuple(contents.missing),
        (*(finding.sentence for finding in verify(contents.folder)), *checked),
        contents.left_out,
        doubts_of(contents, inputs, preflight),
    )
    (folder / MANIFEST).write_bytes(format_manifest(manifest).encode())
    return manifest


def _images(contents: BundleContents, preflight: CheckedBefore) -> dict[str, Any]:
    """Hashes of the firmware that flew: the logger's from the recording, the sequencer's from the preflight."""
    images: dict[str, Any] = {}
    if contents.log is None:
        contents.lack("image of the logger", "The recording that would tell it cannot be decoded.")
    else:
        images["logger"] = record(_LOGGER_IMAGE, origin_of_log(contents.log.header))
    sequencer = preflight.identity("sequencer")
    if "image_crc" not in sequencer:
        contents.lack("image of the sequencer", "No preflight.json tells it.")
    else:
        images["sequencer"] = sequencer
    return images


def recompute(folder: Path, name: str, inputs: EvaluationInputs) -> RecomputedEvaluation:
    """Decodes, calibrates, evaluates, draws; no file of the bundle changes.

    An evaluation notes the landing of the drop in the certificate: it gets a copy.

    `folder` is the bundle, unpacked; `name` the drop's. Raises OSError: a file cannot be read.
    """
    folder = folder.resolve()
    with tempfile.TemporaryDirectory(prefix="tfsat-certificate-") as temporary_folder:
        scratch = Path(temporary_folder).resolve()
        roots = (scratch, folder)
        options = _options(folder, scratch, inputs)
        try:
            robot = drop_evaluation.robot_of(options.robot)
            evaluated_run = drop_evaluation.evaluate_run(folder / inputs.recording, options, robot)
        except TfsatError as error:
            # A refusal is a result as well, and is compared like one.
            return RecomputedEvaluation(
                _relative({"error": jsonable(record(error_columns(error), error))}, roots), None, None
            )
        result = jsonable(record((*MADE_BY, *EVALUATED_RUN), evaluated_run))
        certificate = None if evaluated_run.held is None else evaluated_run.held.path
        sources = tuple(
            Source(f"file of the {what}", Path(inputs.files[what]), sha256_of(folder / inputs.files[what]))
            for what in _SOURCES
            if what in inputs.files
        )
        drop = replace(report_drop(name, evaluated_run), sources=sources, options=options.as_arguments())
        # The time in it is the drop's own, so that it does not hang on when it was made.
        # No path of this computer may show: the same drop gives the same bytes anywhere.
        page = render(_relative(document_of([drop], evaluated_run.recorded or _NO_TIME), roots))
        certificate_name = None if certificate is None else _relative(str(certificate), roots)
        return RecomputedEvaluation(_relative(result, roots), page, certificate_name)


def _options(folder: Path, scratch: Path, inputs: EvaluationInputs) -> EvaluationOptions:
    files = {kind: folder / name for kind, name in inputs.files.items()}
    if inputs.maneuver == f"{RUN}/{MANEUVER}":
        del files["maneuver"]  # evaluate finds it, and holds it against what the sequencer held
    if inputs.calibration is not None:
        files["calibration"] = _copy_certificate(folder, scratch, inputs.calibration)
    return EvaluationOptions(
        **files,
        session=None if inputs.session is None else int(inputs.session, 16),
        video_rate=inputs.video_rate,
        swarm=inputs.swarm,
    )


def _copy_certificate(folder: Path, scratch: Path, certificate: str) -> Path:
    """Copy the certificate and its earlier versions, and return the path of the copy."""
    # With its kept versions: which of them held at the release is decided again.
    copy = scratch / certificate
    copy.parent.mkdir(parents=True)
    shutil.copyfile(folder / certificate, copy)
    recordings_folder(copy).mkdir()
    for archived_certificate in recordings_folder(folder / certificate).glob("certificate-*.toml"):
        shutil.copyfile(archived_certificate, recordings_folder(copy) / archived_certificate.name)
    return copy


def _relative(value: Any, roots: tuple[Path, ...]) -> Any:
    """Make every path in every text of a JSON value relative to the bundle.

    The result is the same on every system: path separators and quotes around paths with spaces are normalized.
    """
    if isinstance(value, dict):
        return {key: _relative(item, roots) for key, item in value.items()}
    if isinstance(value, list):
        return [_relative(item, roots) for item in value]
    for root in roots if isinstance(value, str) else ():
        if str(root) in value:
            plain = value.replace("\\", "/").replace("'", "")
            value = plain.replace(f"{root.as_posix()}/", "").replace(root.as_posix(), ".")
    return value
