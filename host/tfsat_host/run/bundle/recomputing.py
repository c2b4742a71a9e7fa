"""A bundled drop evaluated from its raw data, without changing a file of it."""

from __future__ import annotations

import json
import re
import shutil
import tempfile
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tfsat_host import __version__
from tfsat_host.calibration.certificate.archive import recordings_folder
from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import sha256_of
from tfsat_host.json_values import error_as_dict, jsonable
from tfsat_host.report import render
from tfsat_host.report.contents.building import document_of
from tfsat_host.report.contents.reported import Reported, Source
from tfsat_host.run import evaluated
from tfsat_host.run.bundle.manifest import Evaluated
from tfsat_host.run.evaluated import EvaluatedRun
from tfsat_host.run.options import EvaluationOptions

_NO_TIME = datetime(1980, 1, 1, tzinfo=UTC)
_DOCUMENT = re.compile(r'<script type="application/json" id="document">(.*?)</script>', re.DOTALL)
_SOURCES = ("robot", "calibration", "maneuver", "video", "laser", "facility")
"""In the order in which a report names them."""


@dataclass(frozen=True)
class Recomputed:
    """What an evaluation gave.

    Attributes:
        evaluation: The object of `evaluate --json`, with paths relative to the bundle; of a drop that cannot be
            evaluated, `error`.
        page: The report; None: there is nothing to report.
        certificate: The certificate that held at the release, relative to the bundle; None: there is none.
    """

    evaluation: dict[str, Any]
    page: str | None
    certificate: str | None


def recompute(folder: Path, name: str, used: Evaluated) -> Recomputed:
    """Decodes, calibrates, evaluates, draws.

    An evaluation notes the landing of the drop in the certificate: it gets a copy.

    Args:
        folder: The bundle, unpacked.
        name: Of the drop.
        used: How it is to be evaluated.

    Raises:
        OSError: a file cannot be read.
    """
    from tfsat_host.run.result import result_of

    folder = folder.resolve()
    with tempfile.TemporaryDirectory(prefix="tfsat-certificate-") as made:
        scratch = Path(made).resolve()
        roots = (scratch, folder)
        options = _options(folder, scratch, used)
        try:
            robot = evaluated.robot_of(options.robot)
            done = evaluated.evaluate_run(folder / used.recording, options, robot)
        except TfsatError as error:
            return Recomputed(_relative({"error": jsonable(error_as_dict(error))}, roots), None, None)
        result = {"made_by": f"tfsat-host evaluate {__version__}", **jsonable(result_of(done))}
        held = None if done.held is None else _relative_text(str(done.held.path), roots)
        return Recomputed(_relative(result, roots), _page(done, folder, name, used, roots), held)


def document_in(page: str) -> Any:
    """The document of a report page. Raises ValueError: there is none."""
    found = _DOCUMENT.search(page)
    if found is None:
        raise ValueError("it holds no document")
    try:
        return json.loads(found[1])
    except RecursionError as error:
        raise ValueError("its document is nested too deeply") from error


def _options(folder: Path, scratch: Path, used: Evaluated) -> EvaluationOptions:
    files = {kind: folder / name for kind, name in used.files.items()}
    if used.calibration is not None:
        files["calibration"] = _copied(folder, scratch, used.calibration)
    return EvaluationOptions(
        **files,
        session=None if used.session is None else int(used.session, 16),
        masses=used.masses,
        inertias=used.inertias,
        swarm=used.swarm,
    )


def _copied(folder: Path, scratch: Path, certificate: str) -> Path:
    """A copy of the certificate and of those that were kept before it."""
    copy = scratch / certificate
    copy.parent.mkdir(parents=True)
    shutil.copyfile(folder / certificate, copy)
    recordings = recordings_folder(folder / certificate)
    recordings_folder(copy).mkdir()
    for kept in recordings.glob("certificate-*.toml") if recordings.is_dir() else ():
        shutil.copyfile(kept, recordings_folder(copy) / kept.name)
    return copy


def _page(done: EvaluatedRun, folder: Path, name: str, used: Evaluated, roots: tuple[Path, ...]) -> str:
    """The report; the time in it is the drop's own, so that it does not hang on when it was made."""
    drop = _reported(done, folder, name, used)
    return render(_relative(document_of([drop], done.recorded or _NO_TIME), roots))


def _reported(done: EvaluatedRun, folder: Path, name: str, used: Evaluated) -> Reported:
    sources = tuple(
        Source(f"file of the {what}", Path(used.files[what]), sha256_of(folder / used.files[what]))
        for what in _SOURCES
        if what in used.files
    )
    certificate = None if done.held is None else done.held.path
    sha256 = sha256_of(done.files.recording)
    return Reported(
        name, done.found, done.verdict, sha256, certificate, done.remarks, sources, used.options()
    )


def _relative(value: Any, roots: tuple[Path, ...]) -> Any:
    """With every path in every text relative to the bundle."""
    if isinstance(value, dict):
        return {key: _relative(item, roots) for key, item in value.items()}
    if isinstance(value, list):
        return [_relative(item, roots) for item in value]
    return _relative_text(value, roots) if isinstance(value, str) else value


def _relative_text(text: str, roots: tuple[Path, ...]) -> str:
    """On every system the same: neither its separators nor its quotes about a path with spaces count."""
    for root in roots:
        if str(root) in text:
            plain = text.replace("\\", "/").replace("'", "")
            text = plain.replace(f"{root.as_posix()}/", "").replace(root.as_posix(), ".")
    return text
