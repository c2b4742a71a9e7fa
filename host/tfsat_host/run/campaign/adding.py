"""A run becomes the next drop of a campaign, whole or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from tfsat_host import __version__
from tfsat_host.calibration.certificate.file import read_calibration
from tfsat_host.calibration.certificate.recordings_archive import recordings_folder
from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import sha256_of
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.notices import SILENT, Notices, printable
from tfsat_host.quantity import Columns, columns_of, fields
from tfsat_host.run.bundle.bundle_archive import trouble_with_file
from tfsat_host.run.bundle.contents import MADE_AGAIN, BundleContents, collect
from tfsat_host.run.campaign import campaign_folder
from tfsat_host.run.campaign.entries import ENTRY, DropEntry
from tfsat_host.run.certificate_check import is_of_robot, origin_of_log
from tfsat_host.run.files import (
    AS_FOUND,
    CERTIFICATE,
    EMULATED,
    EMULATED_CERTIFICATE,
    MANEUVER,
    PREFLIGHT,
    REAL,
    RECORDING,
    REHEARSED,
    ROBOT,
    UNKNOWN,
)
from tfsat_host.run.recorded_landing import note_landing_of, time_of_day
from tfsat_host.run.signed_record import RecordError, sign, verify
from tfsat_host.sdlog import load
from tfsat_host.sdlog.log_errors import NoBlockError

_NOTHING = "Nothing was added."


@dataclass(frozen=True, eq=False)
class AddedDrop:
    """A drop that came in.

    Attributes:
        entry: What the campaign knows of it.
        origin: The run.
        place: Its folder.
        moved: The run's own folder is gone.
        left_out: Files that were not copied, and why.
        changed: What was changed since it was signed, before it came in; sentences.
        doubts: These, and what is wrong with the recording; sentences.
    """

    entry: DropEntry
    origin: Path
    place: Path
    moved: bool
    left_out: dict[str, str]
    changed: list[str]
    doubts: list[str]

    @property
    def sentence(self) -> str:
        """For people."""
        origin = f"{'moved from' if self.moved else 'a copy of'} {self.origin}"
        fell = ", emulated robot" if self.entry.robot == EMULATED else ""
        return f"Drop {self.entry.number}: {self.place} ({origin}{fell})"


ADDED: Columns = (
    *columns_of("entry", ENTRY),
    *fields("path=place moved left_out changed"),
)
"""Of `campaign add --json`."""


def add(
    folder: Path, run: Path, *, note: str | None = None, move: bool = False, notices: Notices = SILENT
) -> AddedDrop:
    """Copies a run, then gives it a number.

    Args:
        folder: Of the campaign.
        run: A folder with a recording, or a recording.
        note: What is to be remembered of it, one line.
        move: Whether the folder `run` goes when its copy is in its place.
        notices: For progress, and for what could not be done.

    Raises:
        TfsatError: it is no campaign or no run, or the campaign has this drop. Nothing was added.
        OSError: something cannot be read or written.
    """
    campaign_folder.read(folder)
    if note is not None:
        example = NextStep("campaign add", (str(folder), str(run)))
        campaign_folder.check_note(note, Advice(example, ' --note "wind from the west"'))
    _check_places(folder, run, move=move)
    contents, _ = collect(run, AS_FOUND, command=NextStep("campaign add", (str(folder),)), nothing=_NOTHING)
    if isinstance(contents.refusal, NoBlockError):  # no drop: its number could never be given again
        raise TfsatError(what=contents.refusal.what, meaning=_NOTHING, next_step=contents.refusal.next_step)
    _require_text_name(contents.recording)
    # Staged inside of the campaign, so that the final rename stays on one file system.
    staged = Path(tempfile.mkdtemp(prefix=campaign_folder.STAGING, dir=folder))
    try:
        with notices.progress(f"Copying {run}"):
            left_out = _copy(run, contents, staged)
        changed = _sign(staged, contents, notices)
        entry = campaign_folder.add(
            folder, staged, lambda number: _entry(number, run, contents, staged, note)
        )
    except campaign_folder.SameDropError as error:
        raise _with_samples(error, contents, folder) from error
    finally:
        # After the rename there is nothing left here; after an error nothing of the copy stays.
        shutil.rmtree(staged, ignore_errors=True)
    place = folder / entry.folder
    # mkdtemp() makes a folder that only its owner may read.
    with suppress(OSError):  # a file system without permissions keeps its own
        place.chmod(0o755)
    # A run of which anything was left out is not deleted.
    moved = move and not left_out
    if moved:
        try:
            shutil.rmtree(run)
        except OSError as error:
            notices.warn(f"{place} is whole, but {error.filename} could not be removed: {error.strerror}.")
    for name, why in left_out.items():
        notices.warn(f"{printable(name)} {printable(why)}: it was left out.")
    if move and left_out:
        notices.warn(f"{run} was not removed: not all of it is in the campaign.")
    return AddedDrop(entry, run, place, moved, left_out, changed, [*changed, *_doubts_of(contents, place)])


def _doubts_of(contents: BundleContents, place: Path) -> list[str]:
    """List what is wrong with the recording, which lies in `place` by now; sentences."""
    if contents.log is None:
        why = "" if contents.refusal is None else f" {contents.refusal.what}"
        return [f"Its recording cannot be decoded: it is kept, and left out of the report.{why}"]
    if contents.log.verdict == "complete":
        return []
    decode = NextStep("decode", (str(place / contents.recording.name),))
    return [Advice(f"Its recording is {contents.log.verdict}. What is missing: ", decode)]


def _with_samples(error: campaign_folder.SameDropError, contents: BundleContents, folder: Path) -> TfsatError:
    """Add to the error which of the two copies holds more samples."""
    try:
        there = len(load(folder / error.drop.folder / error.drop.recording))
    except TfsatError:
        there = 0
    here = 0 if contents.log is None else len(contents.log)
    if here <= there:
        return error
    more = f"This copy has more samples ({here}) than that one ({there})."
    return error.with_words(meaning=f"{more} {error.meaning}")


def _check_places(folder: Path, run: Path, *, move: bool) -> None:
    if run.is_dir() and (
        folder.resolve().is_relative_to(run.resolve()) or run.resolve().is_relative_to(folder.resolve())
    ):
        raise TfsatError(
            what=f"Of {run} and {folder}, one lies in the other.",
            meaning=f"A campaign would copy itself. {_NOTHING}",
            next_step="Name a run that lies outside of the campaign.",
        )
    if move and (not run.is_dir() or run.is_symlink()):
        raise TfsatError(
            what=f"{run} is no folder: only a folder can be moved whole.",
            meaning=_NOTHING,
            next_step="Leave out --move; the recording is copied with what lies next to it.",
        )


def _copy(run: Path, contents: BundleContents, staged: Path) -> dict[str, str]:
    """Copy a run into the staged folder.

    A folder is copied whole, a recording with the files that belong to it; the certificate and its recordings
    always lie next to it.

    Returns the files that were left out, each with the reason.
    """
    left_out = {
        name.removeprefix("run/"): why for name, why in contents.left_out.items() if why != MADE_AGAIN
    }
    # A folder is copied whole: names that a bundle could not hold are no obstacle here.
    if run.is_dir():
        named = {name: why for name, why in left_out.items() if "its name" not in why}
        left_out = named | _copy_folder(run, staged)
    # What was found elsewhere, as the certificate may be, comes to lie beside the recording.
    for name, path in contents.files.items():
        kind, _, inside = name.partition("/")
        if kind in ("run", "calibration") and not (staged / inside).exists():
            (staged / inside).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, staged / inside)
    return left_out


def _copy_folder(run: Path, staged: Path) -> dict[str, str]:
    """Files and folders, but no locks; gives what is neither, or lies elsewhere, and why it was left out.

    Nor the mark by which a rehearsal knows a folder that it may make again: a drop of a campaign is none.
    """
    left_out = {}
    # os.walk() passes over errors by default: half a run must not pass for a whole one.
    for here, folders, files in os.walk(run, onerror=_stop):
        below = Path(here).relative_to(run)
        (staged / below).mkdir(exist_ok=True)
        for name in sorted((*folders, *files)):
            path = Path(here) / name
            if name.endswith(".lock") or name == REHEARSED:
                continue
            why = trouble_with_file(path, run)
            if why:
                left_out[(below / name).as_posix()] = why
            elif path.is_file():
                shutil.copy2(path, staged / below / name)
    return dict(sorted(left_out.items()))


def _stop(error: OSError) -> None:
    raise error


def _sign(staged: Path, contents: BundleContents, notices: Notices) -> list[str]:
    """Vouches for all that the drop's evaluation rests on; gives what was changed since it was signed before.

    That is not signed again: it would look as if it had always been so.
    """
    # Verify first: a new signature would hide what was changed since the old one.
    findings = verify(staged)
    certificates = []
    for name in (CERTIFICATE, EMULATED_CERTIFICATE):
        # Before the hash is taken, as any later evaluation would write the landing into it.
        _teach_landing(staged / name, contents)
        certificates += [staged / name, *sorted(recordings_folder(staged / name).glob("[!.]*"))]
    named = (contents.recording.name, MANEUVER, ROBOT, PREFLIGHT)
    changed = {staged / finding.name for finding in findings}
    files = [*(staged / name for name in named), *certificates]
    try:
        there = [path for path in files if path.is_file() and path not in changed]
        sign(staged, there, f"{campaign_folder.SIGNED_BY} {__version__}", datetime.now(UTC))
    except RecordError as error:
        notices.warn(Advice(f"The drop's record was not gone on with. {error.what} ", error.next_step))
    return [finding.sentence.replace(f"{staged}{os.sep}", "") for finding in findings]


def _teach_landing(certificate: Path, contents: BundleContents) -> None:
    """Lets a certificate know of this drop's landing, as `evaluate` would: after that no evaluation changes it."""
    log = contents.log
    if log is None or not certificate.is_file():
        return
    try:
        present = read_calibration(certificate)
    except TfsatError:
        return  # it is kept as it is; the evaluation says what is wrong with it
    if is_of_robot(present, origin_of_log(log.header), time_of_day(log, log.origin_us)):
        note_landing_of(log, certificate, present)


def _require_text_name(recording: Path) -> None:
    """Refuse a recording whose name is not UTF-8 text: a campaign names its recordings in text files."""
    try:
        recording.name.encode()
    except UnicodeEncodeError:
        raise TfsatError(
            what=f"The name of the recording {printable(recording.name)} is not UTF-8 text.",
            meaning=_NOTHING,
            next_step=f"Rename it to {RECORDING}, then run the same command again.",
        ) from None


def _entry(number: int, run: Path, contents: BundleContents, staged: Path, note: str | None) -> DropEntry:
    log, now = contents.log, datetime.now(UTC)
    entry = DropEntry(
        number=number,
        recording=contents.recording.name,
        sha256=sha256_of(staged / contents.recording.name),
        session=None if log is None else f"{log.session:08x}",
        released=None if log is None else time_of_day(log, log.release_us),
        added=now,
        origin=printable(run),
        robot=UNKNOWN if log is None else EMULATED if origin_of_log(log.header).emulated else REAL,
    )
    return entry if note is None else entry.with_note(now, note)
