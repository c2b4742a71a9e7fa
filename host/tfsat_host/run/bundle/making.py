"""A bundle: a drop's files, its evaluation and report as of now, and a manifest of them, in one archive."""

from __future__ import annotations

import json
import shutil
import tempfile
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

from tfsat_host import __version__
from tfsat_host.calibration.certificate.archive import recordings_folder
from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import sha256_of
from tfsat_host.json_values import error_as_dict, jsonable
from tfsat_host.notices import SILENT, Notices
from tfsat_host.output_files import OutputFile, check_may_write, new_folder_of, tell_new_folder, write_all
from tfsat_host.report import render
from tfsat_host.report.contents.document_builder import ReportedDrop, Source, document_of
from tfsat_host.run import drop_evaluation
from tfsat_host.run.bundle.archive import MARKER, write_archive
from tfsat_host.run.bundle.contents import RUN, BundleContents, collect, doubts_of, not_as_checked
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
from tfsat_host.run.certificate import origin_of_log
from tfsat_host.run.files import (
    AS_FOUND,
    MADE_BY_EVALUATE,
    MANEUVER,
    PREFLIGHT,
    EvaluationOptions,
    names_of,
)
from tfsat_host.run.record import verify

ENDING = ".tfsat.zip"
_NO_TIME = datetime(1980, 1, 1, tzinfo=UTC)
_SOURCES = ("robot", "calibration", "maneuver", "video", "laser", "facility")
"""In the order in which a report names them."""


@dataclass(frozen=True, eq=False)
class WrittenBundle:
    """A bundle that was written.

    Attributes:
        target: The archive.
        manifest: What is in it.
        manifest_sha256: Of the manifest's file: it vouches for every other one.
        recording: What of the recording is there, for people.
    """

    target: Path
    manifest: Manifest
    manifest_sha256: str
    recording: str

    @property
    def lost(self) -> bool:
        """Something was lost, changed, or is doubtful."""
        manifest = self.manifest
        return bool(manifest.record or manifest.doubts) or any(one.lost for one in manifest.missing)


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
    """Collects, evaluates, writes. The same run gives the same bytes.

    Args:
        place: A recording, or its folder.
        options: With what it is evaluated.
        target: The archive; None: its name and `ENDING` in the current folder.
        force: Whether a file that is no bundle may be overwritten.
        notices: For progress.

    Raises:
        TfsatError: a file that was named is not there, or something is in the way. Nothing was written.
    """
    found, used = collect(place, options)
    name = names_of([found.recording])[0][:NAME_CHARACTERS_MAX]
    target = target or Path(f"{name}{ENDING}")
    check_may_write(target, marker=MARKER, force=force)
    new_folder = new_folder_of(target)
    with tempfile.TemporaryDirectory(prefix="tfsat-bundle-") as made:
        folder = Path(made)
        with notices.progress(f"Evaluating {name}"):
            manifest = _stage_bundle(folder, found, used, name)
        files = {inside: folder / inside for inside in (*manifest.files, MANIFEST)}
        write_all([OutputFile(target, MARKER, partial(write_archive, files=files))], force=force)
        manifest_sha256 = sha256_of(folder / MANIFEST)
    tell_new_folder(new_folder, notices)
    log, recording = found.log, "cannot be decoded"
    if log is not None:
        recording = f"{log.verdict}: {len(log)} samples, {log.samples_lost} lost"
    return WrittenBundle(target, manifest, manifest_sha256, recording)


def _stage_bundle(folder: Path, found: BundleContents, used: EvaluationInputs, name: str) -> Manifest:
    """Lays out the bundle in a folder and evaluates it there, as `reproduce` will."""
    for inside, path in found.files.items():
        (folder / inside).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, folder / inside)
    done = recompute(folder, name, used)
    made = {EVALUATION: _json(done.evaluation), ENVIRONMENT: _json(environment())}
    if done.page is None:
        found.lack(REPORT, f"The drop cannot be evaluated: {done.evaluation['error']['what']}", lost=True)
    else:
        made[REPORT] = done.page
    for inside, text in made.items():
        (folder / inside).write_bytes(text.encode())
    files = {
        inside: BundledFile(sha256_of(folder / inside), (folder / inside).stat().st_size)
        for inside in sorted((*found.files, *made))
    }
    preflight = _preflight(folder)
    checked = not_as_checked(preflight, {name: file.sha256 for name, file in files.items()}, used)
    manifest = Manifest(
        f"tfsat-host bundle {__version__}",
        name,
        used,
        _images(found, preflight),
        files,
        tuple(found.missing),
        (*(finding.sentence for finding in verify(found.folder)), *checked),
        found.left_out,
        doubts_of(found, used, preflight),
    )
    (folder / MANIFEST).write_bytes(format_manifest(manifest).encode())
    return manifest


def _preflight(folder: Path) -> Any:
    """Read `preflight.json`; return None if it cannot be read, as the bundle keeps it unchanged."""
    try:
        return json.loads((folder / RUN / PREFLIGHT).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None


def _json(value: Any) -> str:
    return json.dumps(value, indent=1, allow_nan=False) + "\n"


def _images(found: BundleContents, preflight: Any) -> dict[str, Any]:
    """Hashes of the firmware that flew: the logger's from the recording, the sequencer's from the preflight."""
    images: dict[str, Any] = {}
    if found.log is None:
        found.lack("image of the logger", "The recording that would tell it cannot be decoded.")
    else:
        origin = origin_of_log(found.log.header)
        images["logger"] = {
            "firmware": origin.firmware,
            "image_crc": origin.image_crc,
            "serial": origin.logger_serial,
            "emulated": origin.emulated,
        }
    sequencer = _identity_in(preflight, "sequencer")
    if sequencer is None:
        found.lack("image of the sequencer", "No preflight.json tells it.")
    else:
        images["sequencer"] = sequencer
    return images


def _identity_in(value: Any, board: str) -> dict[str, Any] | None:
    """Find a board's identity, a dict with an `image_crc`, at any depth of a JSON value."""
    if isinstance(value, dict):
        one = value.get(board)
        if isinstance(one, dict) and "image_crc" in one:
            return one
        value = list(value.values())
    below = (_identity_in(item, board) for item in value) if isinstance(value, list) else ()
    return next((one for one in below if one is not None), None)


def recompute(folder: Path, name: str, used: EvaluationInputs) -> RecomputedEvaluation:
    """Decodes, calibrates, evaluates, draws; no file of the bundle changes.

    An evaluation notes the landing of the drop in the certificate: it gets a copy.

    Args:
        folder: The bundle, unpacked.
        name: Of the drop.
        used: How it is to be evaluated.

    Raises:
        OSError: a file cannot be read.
    """
    folder = folder.resolve()
    with tempfile.TemporaryDirectory(prefix="tfsat-certificate-") as made:
        scratch = Path(made).resolve()
        roots = (scratch, folder)
        options = _options(folder, scratch, used)
        try:
            robot = drop_evaluation.robot_of(options.robot)
            done = drop_evaluation.evaluate_run(folder / used.recording, options, robot)
        except TfsatError as error:
            return RecomputedEvaluation(
                _relative({"error": jsonable(error_as_dict(error))}, roots), None, None
            )
        result = {**MADE_BY_EVALUATE, **jsonable(done.as_dict())}
        certificate = None if done.held is None else done.held.path
        # The time in it is the drop's own, so that it does not hang on when it was made.
        drop = ReportedDrop(
            name,
            done.found,
            done.verdict,
            sha256_of(done.files.recording),
            certificate,
            done.remarks,
            tuple(
                Source(f"file of the {what}", Path(used.files[what]), sha256_of(folder / used.files[what]))
                for what in _SOURCES
                if what in used.files
            ),
            options.as_arguments(),
        )
        page = render(_relative(document_of([drop], done.recorded or _NO_TIME), roots))
        held = None if certificate is None else _relative(str(certificate), roots)
        return RecomputedEvaluation(_relative(result, roots), page, held)


def _options(folder: Path, scratch: Path, used: EvaluationInputs) -> EvaluationOptions:
    files = {kind: folder / name for kind, name in used.files.items()}
    if used.maneuver == f"{RUN}/{MANEUVER}":
        del files["maneuver"]  # evaluate finds it, and holds it against what the sequencer held
    if used.calibration is not None:
        files["calibration"] = _copy_certificate(folder, scratch, used.calibration)
    return EvaluationOptions(
        **files,
        session=None if used.session is None else int(used.session, 16),
        video_rate=used.video_rate,
        swarm=used.swarm,
    )


def _copy_certificate(folder: Path, scratch: Path, certificate: str) -> Path:
    """Copy the certificate and its earlier versions, and return the path of the copy."""
    copy = scratch / certificate
    copy.parent.mkdir(parents=True)
    shutil.copyfile(folder / certificate, copy)
    recordings_folder(copy).mkdir()
    for kept in recordings_folder(folder / certificate).glob("certificate-*.toml"):
        shutil.copyfile(kept, recordings_folder(copy) / kept.name)
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
