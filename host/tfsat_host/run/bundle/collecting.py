"""Which files make up a drop: those of the run, and those that its evaluation rests on wherever they lie."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from tfsat_host.calibration.certificate.archive import recordings_folder
from tfsat_host.calibration.certificate.drawn import in_words
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import sha256_of
from tfsat_host.plan.facility import default_facility_path
from tfsat_host.robot import find_robot
from tfsat_host.run.bundle.manifest import Evaluated, Missing
from tfsat_host.run.bundle.names import collision_among, trouble_with_file, trouble_with_name
from tfsat_host.run.certificate import origin_of_log
from tfsat_host.run.files import PREFLIGHT, find_certificate, is_inside, robot_beside, run_files
from tfsat_host.run.options import EvaluationOptions
from tfsat_host.run.record import RECORD, parse_record
from tfsat_host.sdlog import DropLog, load

RUN = "run"
_TAKEN = (
    RECORD,
    PREFLIGHT,
    "drop.json",
    "evaluation.json",
    "report.html",
    "summary.json",
    "truth.*",
    "*.md",
    "*.txt",
)
"""Of what may lie in the folder of a run: what people wrote, and what was said of it then."""
MADE_AGAIN = "not needed: it can be made again from the recording, or is no part of the drop"


@dataclass
class Collected:
    """What is to be bundled.

    Attributes:
        folder: Of the run.
        recording: The raw log.
        log: What it holds; None: it cannot be decoded.
        refusal: Why it cannot be.
        files: By their names in the bundle.
        missing: What is not there.
        left_out: Files of the run that are not taken, and why.
    """

    folder: Path
    recording: Path
    log: DropLog | None = None
    refusal: TfsatError | None = None
    files: dict[str, Path] = field(default_factory=dict)
    missing: list[Missing] = field(default_factory=list)
    left_out: dict[str, str] = field(default_factory=dict)

    def add(self, path: Path | None, kind: str) -> str | None:
        """Takes a file, under `run/` if it lies there, else in a folder of its kind; gives its name in the bundle."""
        if path is None:
            return None
        inside = path.resolve().is_relative_to(self.folder.resolve())
        name = (
            f"{RUN}/{path.resolve().relative_to(self.folder.resolve()).as_posix()}"
            if inside
            else f"{kind}/{path.name}"
        )
        if trouble_with_name(name) or collision_among({*self.files, name} - ({name} & self.files.keys())):
            name = f"{kind}/{len(self.files)}-{re.sub(r'[^A-Za-z0-9.-]+', '_', path.name).strip('._')}"
        self.files[name] = path
        return name


def collect(
    place: Path,
    options: EvaluationOptions,
    *,
    command: str = "bundle",
    nothing: str = "Nothing was bundled.",
) -> tuple[Collected, Evaluated]:
    """Looks for all files of a drop, as `evaluate` would.

    Args:
        place: A recording, or its folder.
        options: What else is known of the drop.
        command: Which asks; for errors.
        nothing: What it then did not do; a sentence.

    Raises:
        TfsatError: there is no recording, a file that was named is not there, or one that was not named lies elsewhere.
    """
    files = run_files(place, options.maneuver, command=command, nothing=nothing)
    found = Collected(files.recording.parent, files.recording)
    try:
        found.log = load(files.recording, session=options.session)
    except TfsatError as error:
        found.refusal = error
    kinds = (False, True) if found.log is None else (origin_of_log(found.log.header).emulated,)
    tried = (find_certificate(options.calibration, found.folder, Path(), emulated=kind) for kind in kinds)
    certificate = next((one for one in tried if one is not None), None)
    for named in (files.maneuver, certificate, options.facility, options.video, options.laser):
        _require(named)
    robot = find_robot(options.robot or robot_beside(files.recording))
    named_ones = (options.maneuver, options.calibration, *([] if place.is_dir() else [place]))
    for path in (files.recording, files.maneuver, certificate, *([] if options.robot else [robot])):
        if path is not None and path not in named_ones and path.parent == found.folder:
            _require_there(path, nothing)
    evaluated = Evaluated(
        recording=str(found.add(files.recording, RUN)),
        maneuver=found.add(files.maneuver, "maneuver"),
        calibration=found.add(certificate, "calibration"),
        robot=found.add(robot, "robot"),
        facility=found.add(options.facility or default_facility_path(), "facility"),
        video=found.add(options.video, "witnesses"),
        laser=found.add(options.laser, "witnesses"),
        session=None if options.session is None else f"{options.session:08x}",
        masses=options.masses,
        inertias=options.inertias,
        swarm=options.swarm,
    )
    if certificate is not None and evaluated.calibration is not None:
        _add_recordings(found, certificate, evaluated.calibration)
    _add_signed(found)
    _add_others(found, listed=place.is_dir())
    found.missing += _not_there(found, evaluated)
    return found, evaluated


def _require(path: Path | None) -> None:
    if path is not None and not path.is_file():
        raise TfsatError(
            what=f"There is no file {path}.",
            meaning="The drop cannot be bundled without it; nothing was written.",
            next_step="Name a file that exists.",
        )


def _require_there(path: Path, nothing: str) -> None:
    trouble = trouble_with_file(path, path.parent)
    if trouble:
        raise TfsatError(
            what=f"{path} {trouble}.",
            meaning=f"What is not in the run's folder is taken only if it is named. {nothing}",
            next_step="Copy the file itself into the folder, or name it on the command line.",
        )


def _add_recordings(found: Collected, certificate: Path, name: str) -> None:
    """The recordings beside a certificate keep their place beside it; what it rests on and is gone is named."""
    folder = recordings_folder(certificate)
    inside = f"{name.removesuffix('.toml')}-recordings"
    if folder.is_dir():
        for path in sorted(folder.iterdir()):
            if path.suffix in (".npz", ".toml") and not path.name.startswith("."):
                _add_named(found, f"{inside}/{path.name}", path, certificate.parent)
    try:
        calibration = read_calibration(certificate)
    except TfsatError as error:
        found.missing.append(Missing("raw data of the calibration", error.what, lost=True))
        return
    if not calibration.papers:
        why = "The certificate names no recordings that it was computed from."
        found.missing.append(Missing("raw data of the calibration", why))
    elif calibration.drawn:
        why = f"Nobody measured these, a rehearsal drew them: {in_words(calibration.drawn)}."
        found.missing.append(Missing("raw data of some of the calibration", why))
    for paper in calibration.papers:
        path = folder / paper.file
        if not path.is_file():
            found.missing.append(Missing(f"{inside}/{paper.file}", f"{path} is not there.", lost=True))
        elif f"{inside}/{paper.file}" not in found.files:
            why = f"{path} {found.left_out.get(f'{inside}/{paper.file}', 'was not taken')}."
            found.missing.append(Missing(f"{inside}/{paper.file}", why, lost=True))
        elif sha256_of(path) != paper.sha256:
            why = f"{path} is not the recording that the certificate rests on: its SHA-256 differs."
            found.missing.append(Missing(f"{inside}/{paper.file}", why, lost=True))


def _add_signed(found: Collected) -> None:
    """What the run's record vouches for, so that it can be verified in the bundle, too."""
    record = found.folder / RECORD
    if not record.is_file():
        return
    try:
        entries, _ = parse_record(record.read_text(encoding="utf-8"))
    except ValueError:
        return  # told with all else that is wrong with the record
    for name in sorted({file.name for entry in entries for file in entry.files if is_inside(file.name)}):
        inside = f"{RUN}/{name}"
        if (found.folder / name).is_file() and not _add_named(found, inside, found.folder / name):
            why = f"{found.folder / name} {found.left_out[inside]}."
            found.missing.append(Missing(inside, why, lost=True))


def _add_others(found: Collected, *, listed: bool) -> None:
    """What people wrote and said; everything else in the folder of a run is named as left out."""
    taken = {os.path.realpath(path) for path in found.files.values()}
    for path in sorted(found.folder.iterdir()):
        if path.name.startswith(".") or f"{RUN}/{path.name}" in found.files.keys() | found.left_out.keys():
            continue
        wanted = any(path.match(pattern) for pattern in _TAKEN)
        trouble = trouble_with_file(path, found.folder)
        if trouble and (listed or wanted):
            found.left_out[path.name] = trouble
        elif wanted and path.is_file():
            _add_named(found, f"{RUN}/{path.name}", path)
        elif listed and not _holds_any(path, taken):
            found.left_out[path.name + ("/" if path.is_dir() else "")] = MADE_AGAIN


def _add_named(found: Collected, name: str, path: Path, root: Path | None = None) -> bool:
    """Whether it is taken; if not, why stands in `left_out`."""
    if name in found.files:
        return True
    why = trouble_with_file(path, root or found.folder)
    if why is None and (trouble := trouble_with_name(name)):
        why = f"its name {trouble}"
    if why is None and collision_among((*found.files, name)):
        why = "its name is another's on some systems"
    if why:
        found.left_out[name] = why
    else:
        found.files[name] = path
    return why is None


def _holds_any(folder: Path, taken: Iterable[str]) -> bool:
    return folder.is_dir() and any(Path(path).is_relative_to(os.path.realpath(folder)) for path in taken)


def _not_there(found: Collected, evaluated: Evaluated) -> list[Missing]:
    expected = {
        "maneuver": (evaluated.maneuver, "No maneuver.toml lies beside the recording, and none was named."),
        "calibration": (evaluated.calibration, "No certificate was found, and none was named."),
        PREFLIGHT: (
            f"{RUN}/{PREFLIGHT}",
            "The run has none: nothing tells what was checked before.",
        ),
        RECORD: (f"{RUN}/{RECORD}", "The run has none: nothing in it was signed."),
    }
    return [
        Missing(what, why)
        for what, (name, why) in expected.items()
        if name is None or (name.startswith(f"{RUN}/") and name not in found.files)
    ]
