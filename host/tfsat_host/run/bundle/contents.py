"""Which files make up a drop, those of the run and of its evaluation, and what is doubtful."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tfsat_host.calibration.certificate.certificate import in_words
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.certificate.recordings_archive import recordings_folder
from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import change_of
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.plan.facility import default_facility_path
from tfsat_host.robot import find_robot
from tfsat_host.run.bundle.bundle_archive import collision_among, trouble_with_file, trouble_with_name
from tfsat_host.run.bundle.manifest import EvaluationInputs, Missing
from tfsat_host.run.certificate_check import origin_of_log
from tfsat_host.run.files import (
    PREFLIGHT,
    EvaluationOptions,
    find_certificate,
    is_inside,
    rehearsed_files,
    robot_beside,
    run_files,
)
from tfsat_host.run.held_maneuver import find_note
from tfsat_host.run.recorded_landing import time_of_day
from tfsat_host.run.signed_record import RECORD, parse_record
from tfsat_host.sdlog import DropLog, load

RUN = "run"
_BUNDLE = NextStep("bundle")
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
"""Of what may lie in the folder of a run: what people wrote, and results of then."""
_WRITTEN_AGAIN = (".csv", ".html")
"""Of a rehearsal's files: `decode` and `report` write them again."""
_TRUTH = "truth.csv"
_CHECKED = ("maneuver", "calibration", "robot", "facility")
MADE_AGAIN = "not needed: it can be made again from the recording, or is no part of the drop"


@dataclass
class BundleContents:
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
        real, root = path.resolve(), self.folder.resolve()
        inside = real.is_relative_to(root)
        name = f"{RUN}/{real.relative_to(root).as_posix()}" if inside else f"{kind}/{path.name}"
        # A name that some file system refuses or confuses gives way to a plain one with a number.
        if trouble_with_name(name) or collision_among({*self.files, name} - ({name} & self.files.keys())):
            name = f"{kind}/{len(self.files)}-{re.sub(r'[^A-Za-z0-9.-]+', '_', path.name).strip('._')}"
        self.files[name] = path
        return name

    def add_named(self, name: str, path: Path, root: Path | None = None) -> str | None:
        """Takes a file by a name; None: it is taken, otherwise why not, as in `left_out`."""
        if name in self.files:
            return None
        why = trouble_with_file(path, root or self.folder)
        if why is None and (trouble := trouble_with_name(name)):
            why = f"its name {trouble}"
        if why is None and collision_among((*self.files, name)):
            why = "its name is another's on some systems"
        if why:
            self.left_out[name] = why
        else:
            self.files[name] = path
        return why

    def lack(self, what: str, why: str, *, lost: bool = False) -> None:
        """Names what is not there."""
        self.missing.append(Missing(what, why, lost))


def collect(
    place: Path,
    options: EvaluationOptions,
    *,
    command: NextStep = _BUNDLE,
    nothing: str = "Nothing was bundled.",
) -> tuple[BundleContents, EvaluationInputs]:
    """Looks for all files of a drop (a recording, or its folder), as `evaluate` would.

    `command` asks for them, and `nothing`, a sentence, tells what it then did not do: for errors.

    Raises:
        TfsatError: there is no recording, a file that was named is not there, or one that was not named lies elsewhere.
    """
    files = run_files(place, options.maneuver, command=command, nothing=nothing)
    contents = BundleContents(files.recording.parent, files.recording)
    try:
        contents.log = load(files.recording, session=options.session)
    except TfsatError as error:
        contents.refusal = error
    # A recording that cannot be decoded does not say whether it was emulated: look for both certificates.
    kinds = (False, True) if contents.log is None else (origin_of_log(contents.log.header).emulated,)
    tried = (find_certificate(options.calibration, contents.folder, Path(), emulated=kind) for kind in kinds)
    certificate = next((candidate for candidate in tried if candidate is not None), None)
    for named in (files.maneuver, certificate, options.facility, options.video, options.laser):
        _require(named)
    robot = find_robot(options.robot or robot_beside(files.recording))
    named_ones = (options.maneuver, options.calibration, *([] if place.is_dir() else [place]))
    for path in (files.recording, files.maneuver, certificate, *([] if options.robot else [robot])):
        if path is not None and path not in named_ones and path.parent == contents.folder:
            _require_there(path, nothing)
    evaluated = EvaluationInputs(
        recording=str(contents.add(files.recording, RUN)),
        maneuver=contents.add(files.maneuver, "maneuver"),
        calibration=contents.add(certificate, "calibration"),
        robot=contents.add(robot, "robot"),
        facility=contents.add(options.facility or default_facility_path(), "facility"),
        video=contents.add(options.video, "witnesses"),
        laser=contents.add(options.laser, "witnesses"),
        session=None if options.session is None else f"{options.session:08x}",
        video_rate=options.video_rate,
        swarm=options.swarm,
    )
    note = None if contents.log is None else find_note(files.recording, contents.log.session)
    if note is not None:
        contents.add_named(f"{RUN}/{note.name}", note, note.parent)
    if certificate is not None and evaluated.calibration is not None:
        _add_recordings(contents, certificate, evaluated.calibration)
    _add_signed(contents)
    _add_others(contents, listed=place.is_dir())
    _name_absent(contents, evaluated, note)
    return contents, evaluated


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


def _add_recordings(contents: BundleContents, certificate: Path, name: str) -> None:
    """Add a certificate's recordings, kept in their place next to it.

    Recordings that the certificate rests on and that are gone are named as missing.
    """
    folder = recordings_folder(certificate)
    inside = f"{name.removesuffix('.toml')}-recordings"
    # Kept certificates too: the one that held at the release may be an earlier version.
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        if path.suffix in (".npz", ".toml") and not path.name.startswith("."):
            contents.add_named(f"{inside}/{path.name}", path, certificate.parent)
    raw_data = "raw data of the calibration"
    try:
        calibration = read_calibration(certificate)
    except TfsatError as error:
        contents.lack(raw_data, error.what, lost=True)
        return
    if not calibration.recordings:
        contents.lack(raw_data, "The certificate names no recordings that it was computed from.")
    elif calibration.simulated_quantities:
        contents.lack(
            "raw data of simulated calibration values",
            f"Simulated by a rehearsal, not measured: {in_words(calibration.simulated_quantities)}.",
        )
    # Each recording that the certificate rests on must be there unchanged, or it cannot be recomputed.
    for recording in calibration.recordings:
        path, bundle_name = folder / recording.file, f"{inside}/{recording.file}"
        why = {
            "missing": "is not there",
            "changed": "is not the recording that the certificate rests on: its SHA-256 differs",
            "": "" if bundle_name in contents.files else contents.left_out.get(bundle_name, "was not taken"),
        }[change_of(path, recording.sha256)]
        if why:
            contents.lack(bundle_name, f"{path} {why}.", lost=True)


def _add_signed(contents: BundleContents) -> None:
    """Add the files whose SHA-256 the run's record has, so that the bundle can be verified, too."""
    record = contents.folder / RECORD
    if not record.is_file():
        return
    try:
        entries, _ = parse_record(record.read_text(encoding="utf-8"))
    except ValueError:
        return  # named with all else that is wrong with the record
    for name in sorted({file.name for entry in entries for file in entry.files if is_inside(file.name)}):
        path = contents.folder / name
        if path.is_file() and (why := contents.add_named(f"{RUN}/{name}", path)):
            contents.lack(f"{RUN}/{name}", f"{path} {why}.", lost=True)


def _add_others(contents: BundleContents, *, listed: bool) -> None:
    """Add notes and results from the run's folder.

    If `listed`, everything else in the folder is named as left out.
    """
    # Real paths, as a file of another kind may lie in a folder that is listed here.
    bundled_paths = {os.path.realpath(path) for path in contents.files.values()}
    for path in sorted(contents.folder.iterdir()):
        if (
            path.name.startswith(".")
            or f"{RUN}/{path.name}" in contents.files.keys() | contents.left_out.keys()
        ):
            continue
        is_selected = any(path.match(pattern) for pattern in _TAKEN)
        trouble = trouble_with_file(path, contents.folder)
        if trouble and (listed or is_selected):
            contents.left_out[path.name] = trouble
        elif is_selected and path.is_file():
            contents.add_named(f"{RUN}/{path.name}", path)
        elif listed and not _holds_any(path, bundled_paths):
            contents.left_out[path.name + ("/" if path.is_dir() else "")] = MADE_AGAIN


def _holds_any(folder: Path, bundled_paths: Iterable[str]) -> bool:
    return folder.is_dir() and any(
        Path(path).is_relative_to(os.path.realpath(folder)) for path in bundled_paths
    )


def _name_absent(contents: BundleContents, evaluated: EvaluationInputs, note: Path | None) -> None:
    """Name the parts of a complete bundle that are absent."""
    if evaluated.maneuver is None and note is None:
        contents.lack("maneuver", "No maneuver.toml lies next to the recording, and none was named.")
    if evaluated.calibration is None:
        contents.lack("calibration", "No certificate was found, and none was named.")
    if f"{RUN}/{PREFLIGHT}" not in contents.files:
        contents.lack(PREFLIGHT, "The run has none: nothing tells what was checked before.")
    if f"{RUN}/{RECORD}" not in contents.files:
        contents.lack(RECORD, "The run has none: nothing in it was signed.")


@dataclass(frozen=True, slots=True)
class CheckedBefore:
    """What a run's `preflight.json` tells; all of it empty where there is none, or what it has is no preflight's.

    Attributes:
        boards: Each board's identity, by its name.
        files: Each file that was checked, with path and SHA-256, by its kind.
    """

    boards: Mapping[str, Any] = field(default_factory=dict)
    files: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def read(cls, folder: Path) -> CheckedBefore:
        """Read it from the folder of a run. Raises nothing: a bundle keeps the file unchanged, whatever it holds."""
        try:
            values = json.loads((folder / PREFLIGHT).read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError):
            values = None
        tables = (values.get(key) if isinstance(values, dict) else None for key in ("boards", "files"))
        return cls(*(table if isinstance(table, dict) else {} for table in tables))

    def identity(self, board: str) -> Mapping[str, Any]:
        """Return a board's identity; empty: it has none."""
        identity = self.boards.get(board)
        return identity if isinstance(identity, dict) else {}


def doubts_of(
    contents: BundleContents, inputs: EvaluationInputs, preflight: CheckedBefore
) -> tuple[str, ...]:
    """List the doubts about the drop, one sentence each.

    They are lost samples, files of another robot, and files changed since a rehearsal left them.
    """
    doubts: list[str] = []
    log = contents.log
    if log is not None:
        if log.verdict != "complete" or log.samples_lost:
            doubts.append(
                Advice(
                    f"{contents.recording.name} is {log.verdict}, {log.samples_lost} "
                    "samples are lost. What is missing: ",
                    NextStep("decode"),
                )
            )
        doubts += _of_other_robots(log, contents, inputs, preflight)
    return (*doubts, *_not_as_rehearsed(contents.folder))


def not_as_checked(
    preflight: CheckedBefore, at_hand: Mapping[str, str], inputs: EvaluationInputs
) -> list[str]:
    """List the files that are gone or have changed since the preflight checked them, one sentence each.

    A certificate is rewritten after the landing: the one that was checked is then among those that were kept.

    `at_hand` has the SHA-256 of every file, by its name in the bundle.
    """
    sentences = (
        _change_text(kind, preflight.files[kind], at_hand, getattr(inputs, kind))
        for kind in _CHECKED
        if kind in preflight.files
    )
    return [sentence for sentence in sentences if sentence]


def _change_text(kind: str, checked: Any, at_hand: Mapping[str, str], name: str | None) -> str:
    """Empty: it is there."""
    sha256 = checked.get("sha256") if isinstance(checked, dict) else None
    if not isinstance(sha256, str):
        return f"preflight.json does not say which {kind} was checked."
    # The landing has rewritten the certificate: the checked one may be among the kept versions.
    is_archived = kind == "calibration" and sha256 in at_hand.values()
    if is_archived or (name is not None and at_hand.get(name) == sha256):
        return ""
    then = f"{checked.get('path')}, SHA-256 {sha256[:12]}…"
    if name is None:
        return f"The {kind} that the preflight checked ({then}) is gone."
    copies = ", and none of the certificates that were kept is" if kind == "calibration" else ""
    return f"{name} is not the {kind} that the preflight checked ({then}){copies}."


def _of_other_robots(
    log: DropLog, contents: BundleContents, inputs: EvaluationInputs, preflight: CheckedBefore
) -> list[str]:
    """List the files that name another logger than the recording does, one sentence each."""
    serial = origin_of_log(log.header).logger_serial
    checked = preflight.identity("logger").get("serial")
    loggers = {"preflight.json": checked if isinstance(checked, str) else None}
    if inputs.calibration is not None:
        with suppress(TfsatError):  # one that cannot be read stands with what is missing
            certificate = read_calibration(contents.files[inputs.calibration])
            subject = certificate.subject_at(time_of_day(log, log.origin_us))
            loggers["the certificate"] = subject.logger_serial
    return [
        f"The recording is of logger {serial or 'without a serial number'}, {what} of logger "
        f"{other or 'without a serial number'}: they are of different robots."
        for what, other in loggers.items()
        if other is not None and other.lower() != serial.lower()
    ]


def _not_as_rehearsed(folder: Path) -> list[str]:
    """List the files that differ from the hashes in the rehearsal's mark, one sentence each.

    The list is empty if no rehearsal was run in the folder.
    """
    # Files that decode and report write again may differ; the emulator's hidden truth may not.
    return [
        f"{name} {'was changed since' if change == 'changed' else 'is gone:'} the rehearsal left it."
        for name, sha256 in rehearsed_files(folder).items()
        if sha256
        and (name == _TRUTH or not name.endswith(_WRITTEN_AGAIN))
        and (change := change_of(folder / name, sha256))
    ]
