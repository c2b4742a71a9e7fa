"""A bundle: a drop's files, its evaluation and report as of now, and a manifest of them, in one archive."""

from __future__ import annotations

import json
import shutil
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from tfsat_host import __version__
from tfsat_host.file_hash import sha256_of
from tfsat_host.notices import SILENT, Notices
from tfsat_host.output_files import OutputFile, check_may_write, new_folder_of, tell_new_folder, write_all
from tfsat_host.run.bundle import recomputing
from tfsat_host.run.bundle.archive import MARKER, write_archive
from tfsat_host.run.bundle.collecting import RUN, Collected, collect
from tfsat_host.run.bundle.doubts import doubts_of, not_as_checked
from tfsat_host.run.bundle.environment import environment
from tfsat_host.run.bundle.manifest import (
    ENVIRONMENT,
    EVALUATION,
    MANIFEST,
    NAME_CHARACTERS_MAX,
    REPORT,
    BundledFile,
    Evaluated,
    Manifest,
    Missing,
    format_manifest,
)
from tfsat_host.run.certificate import origin_of_log
from tfsat_host.run.files import PREFLIGHT, names_of
from tfsat_host.run.options import AS_FOUND, EvaluationOptions
from tfsat_host.run.record import verify
from tfsat_host.sdlog import DropLog

ENDING = ".tfsat.zip"


@dataclass(frozen=True, eq=False)
class Bundled:
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


def bundle(
    place: Path,
    options: EvaluationOptions = AS_FOUND,
    target: Path | None = None,
    *,
    force: bool = False,
    notices: Notices = SILENT,
) -> Bundled:
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
            manifest = _staged(folder, found, used, name)
        files = {inside: folder / inside for inside in (*manifest.files, MANIFEST)}
        write_all([OutputFile(target, MARKER, partial(write_archive, files=files))], force=force)
        manifest_sha256 = sha256_of(folder / MANIFEST)
    tell_new_folder(new_folder, notices)
    log = found.log
    recording = (
        f"{log.verdict}: {len(log)} samples, {log.samples_lost} lost"
        if log is not None
        else "cannot be decoded"
    )
    return Bundled(target, manifest, manifest_sha256, recording)


def _staged(folder: Path, found: Collected, used: Evaluated, name: str) -> Manifest:
    """Lays out the bundle in a folder and evaluates it there, as `reproduce` will."""
    for inside, path in found.files.items():
        (folder / inside).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, folder / inside)
    done = recomputing.recompute(folder, name, used)
    missing = list(found.missing)
    made = {EVALUATION: _json(done.evaluation), ENVIRONMENT: _json(environment())}
    if done.page is None:
        why = f"The drop cannot be evaluated: {done.evaluation['error']['what']}"
        missing.append(Missing(REPORT, why, lost=True))
    else:
        made[REPORT] = done.page
    for inside, text in made.items():
        (folder / inside).write_bytes(text.encode())
    preflight = _preflight(folder)
    images, without = _images(found.log, preflight)
    files = {
        inside: BundledFile(sha256_of(folder / inside), (folder / inside).stat().st_size)
        for inside in sorted((*found.files, *made))
    }
    checked = not_as_checked(preflight, {name: file.sha256 for name, file in files.items()}, used)
    manifest = Manifest(
        f"tfsat-host bundle {__version__}",
        name,
        used,
        images,
        files,
        (*missing, *without),
        (*(finding.sentence for finding in verify(found.folder)), *checked),
        found.left_out,
        doubts_of(found, used, preflight),
    )
    (folder / MANIFEST).write_bytes(format_manifest(manifest).encode())
    return manifest


def _preflight(folder: Path) -> Any:
    """What it says; None if it cannot be read: it is in the bundle as it is."""
    try:
        return json.loads((folder / RUN / PREFLIGHT).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None


def _json(value: Any) -> str:
    return json.dumps(value, indent=1, allow_nan=False) + "\n"


def _images(log: DropLog | None, preflight: Any) -> tuple[dict[str, Any], list[Missing]]:
    """Hashes of the firmware that flew: the logger's from the recording, the sequencer's from the preflight."""
    images: dict[str, Any] = {}
    missing = []
    if log is None:
        missing.append(Missing("image of the logger", "The recording that would tell it cannot be decoded."))
    else:
        origin = origin_of_log(log.header)
        images["logger"] = {
            "firmware": origin.firmware,
            "image_crc": origin.image_crc,
            "serial": origin.logger_serial,
            "emulated": origin.emulated,
        }
    sequencer = _identity_in(preflight, "sequencer")
    if sequencer is None:
        missing.append(Missing("image of the sequencer", "No preflight.json tells it."))
    else:
        images["sequencer"] = sequencer
    return images, missing


def _identity_in(value: Any, board: str) -> dict[str, Any] | None:
    """What is said of a board that has an `image_crc`, wherever it stands."""
    if isinstance(value, list):
        return next((one for item in value if (one := _identity_in(item, board)) is not None), None)
    if not isinstance(value, dict):
        return None
    one = value.get(board)
    if isinstance(one, dict) and "image_crc" in one:
        return one
    return _identity_in(list(value.values()), board)
