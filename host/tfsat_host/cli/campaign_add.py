"""`tfsat-host campaign add`: a run becomes the next drop of a campaign, whole or not at all."""

from __future__ import annotations

import argparse
import io
import os
import shlex
import shutil
import tempfile
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host import __version__
from tfsat_host.cli.output import Output
from tfsat_host.errors import DataLossError, TfsatError
from tfsat_host.file_hash import sha256_of

if TYPE_CHECKING:
    from tfsat_host.campaign.entries import DropEntry
    from tfsat_host.campaign.errors import SameDropError
    from tfsat_host.cli.bundle_files import Collected

_NOTHING = "Nothing was added."


def add(args: argparse.Namespace, out: Output) -> int:
    """Copies, then gives a number; with `--move` the original goes when the copy is in its place."""
    from tfsat_host.campaign import folder as campaign
    from tfsat_host.campaign.entries import EMULATED
    from tfsat_host.campaign.errors import SameDropError
    from tfsat_host.cli.bundle_files import collect

    campaign.read(args.dir)
    command = f"campaign add {shlex.quote(str(args.dir))}"
    if args.note is not None:
        check_note(
            args.note, f'tfsat-host {command} {shlex.quote(str(args.run))} --note "wind from the west"'
        )
    _check_places(args.dir, args.run, move=args.move)
    found, _ = collect(args.run, no_options(), command=command, nothing=_NOTHING)
    _require_blocks(found)
    staged = Path(tempfile.mkdtemp(prefix=campaign.STAGING, dir=args.dir))
    try:
        with out.progress(f"Copying {args.run}"):
            left_out = _copy(args.run, found, staged)
        changed = _sign(staged, found, out)
        entry = campaign.add(args.dir, staged, lambda number: _entry(number, found, staged, args))
    except SameDropError as error:
        raise _with_samples(error, found, args.dir) from error
    finally:
        campaign.remove_staged(staged)
    (args.dir / entry.folder).chmod(0o755)
    place = args.dir / entry.folder
    moved = args.move and not left_out
    if moved:
        try:
            shutil.rmtree(args.run)
        except OSError as error:
            out.warn(f"{place} is whole, but {error.filename} could not be removed: {error.strerror}.")
    result = {**entry.as_dict(), "path": str(place), "moved": moved, "left_out": left_out, "changed": changed}
    copy = "" if moved else f", a copy of {args.run}"
    fell = " (EMULATED: no robot fell)" if entry.robot == EMULATED else ""
    out.result(result, f"Drop {entry.number}  {place}{copy}{fell}")
    _tell_left_out(args.run, left_out, out, move=args.move)
    doubts = [*changed, *_doubts_of(found)]
    for sentence in doubts:
        out.warn(sentence)
    return DataLossError.exit_code if doubts else 0


def _require_blocks(found: Collected) -> None:
    """Whatever holds not one block of a logger is no drop: its number could never be given again."""
    from tfsat_host.sdlog.errors import NoBlockError

    if isinstance(found.refusal, NoBlockError):
        raise TfsatError(what=found.refusal.what, meaning=_NOTHING, next_step=found.refusal.next_step)


def _doubts_of(found: Collected) -> list[str]:
    if found.log is None:
        why = "" if found.refusal is None else f" {found.refusal.what}"
        return [f"Its recording cannot be decoded: it is kept, and left out of the report.{why}"]
    if found.log.verdict == "complete":
        return []
    return [f"Its recording is {found.log.verdict}. What is missing: tfsat-host decode"]


def _tell_left_out(run: Path, left_out: dict[str, str], out: Output, *, move: bool) -> None:
    from tfsat_host.cli.evaluate.phrases import printable

    for name, why in left_out.items():
        out.warn(f"{printable(name)} {printable(why)}: it was left out.")
    if left_out and move:
        out.warn(f"{run} was not removed: not all of it is in the campaign.")


def _with_samples(error: SameDropError, found: Collected, folder: Path) -> TfsatError:
    """The same with which of the two copies holds more."""
    from tfsat_host.sdlog.load import load

    try:
        there = len(load(folder / error.drop.folder / error.drop.recording))
    except TfsatError:
        there = 0
    here = 0 if found.log is None else len(found.log)
    if here > there:
        error.meaning = f"This copy has more samples ({here}) than that one ({there}). {error.meaning}"
    return error


def check_note(text: str, example: str) -> None:
    """Raises TfsatError: it says nothing, or is no line of text."""
    if not text.strip() or not text.isprintable():
        raise TfsatError(
            what="A note is one line of printable text.",
            meaning="Nothing was changed.",
            next_step=f"Write it in quotes: {example}",
        )


def _check_places(folder: Path, place: Path, *, move: bool) -> None:
    if place.is_dir() and (
        folder.resolve().is_relative_to(place.resolve()) or place.resolve().is_relative_to(folder.resolve())
    ):
        raise TfsatError(
            what=f"Of {place} and {folder}, one lies in the other.",
            meaning=f"A campaign would copy itself. {_NOTHING}",
            next_step="Name a run that lies outside of the campaign.",
        )
    if move and (not place.is_dir() or place.is_symlink()):
        raise TfsatError(
            what=f"{place} is no folder: only a folder can be moved whole.",
            meaning=_NOTHING,
            next_step="Leave out --move; the recording is copied with what lies beside it.",
        )


def no_options() -> argparse.Namespace:
    """`evaluate` without any."""
    named = ("maneuver", "calibration", "robot", "video", "laser", "facility", "session")
    return argparse.Namespace(**dict.fromkeys(named), **dict.fromkeys(("masses", "inertias", "swarm"), False))


def _copy(place: Path, found: Collected, staged: Path) -> dict[str, str]:
    """A folder whole, of a recording what belongs to it; the certificate and its recordings always beside it.

    Gives what was left out, and why.
    """
    from tfsat_host.cli.bundle_files import MADE_AGAIN

    left_out = {name.removeprefix("run/"): why for name, why in found.left_out.items() if why != MADE_AGAIN}
    if place.is_dir():
        left_out = {name: why for name, why in left_out.items() if "its name" not in why} | _copy_folder(
            place, staged
        )
    for name, path in found.files.items():
        kind, _, inside = name.partition("/")
        if kind in ("run", "calibration") and not (staged / inside).exists():
            (staged / inside).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, staged / inside)
    return left_out


def _copy_folder(place: Path, staged: Path) -> dict[str, str]:
    """Files and folders, but no locks; gives what is neither, or lies elsewhere, and why it was left out.

    Nor the mark by which a rehearsal knows a folder that it may make again: a drop of a campaign is none.
    """
    from tfsat_host.bundle.links import trouble_with_file
    from tfsat_host.cli.rehearse.result_folder import MARK_FILE

    left_out = {}
    for here, folders, files in os.walk(place, onerror=_stop):
        below = Path(here).relative_to(place)
        (staged / below).mkdir(exist_ok=True)
        for name in sorted((*folders, *files)):
            path = Path(here) / name
            if name.endswith(".lock") or name == MARK_FILE:
                continue
            why = trouble_with_file(path, place)
            if why:
                left_out[(below / name).as_posix()] = why
            elif path.is_file():
                shutil.copy2(path, staged / below / name)
    return dict(sorted(left_out.items()))


def _stop(error: OSError) -> None:
    raise error


def _sign(staged: Path, found: Collected, out: Output) -> list[str]:
    """Vouches for all that the drop's evaluation rests on; gives what was changed since it was signed before.

    That is not signed again: it would look as if it had always been so.
    """
    from tfsat_host.campaign.changes import SIGNED_BY
    from tfsat_host.cli.calibrate.options import CERTIFICATE, EMULATED_CERTIFICATE
    from tfsat_host.cli.evaluate.run_files import MANEUVER, ROBOT
    from tfsat_host.record.run_record import RecordError, sign, verify

    findings = verify(staged)
    names = (CERTIFICATE, EMULATED_CERTIFICATE)
    for name in names:
        _teach_landing(staged / name, found)
    certificates = [path for name in names for path in _with_recordings(staged / name)]
    named = (found.recording.name, MANEUVER, ROBOT, "preflight.json")
    files = [*(staged / name for name in named), *certificates]
    changed = {staged / finding.name for finding in findings}
    there = [path for path in files if path.is_file() and path not in changed]
    try:
        sign(staged, there, f"{SIGNED_BY} {__version__}", datetime.now(UTC))
    except RecordError as error:
        out.warn(f"The drop's record was not gone on with. {error.what} {error.next_step}")
    return [finding.sentence.replace(f"{staged}{os.sep}", "") for finding in findings]


def _with_recordings(certificate: Path) -> list[Path]:
    from tfsat_host.calibration.certificate.archive import recordings_folder

    return [certificate, *sorted(recordings_folder(certificate).glob("[!.]*"))]


def _teach_landing(certificate: Path, found: Collected) -> None:
    """Lets a certificate know of this drop's landing, as `evaluate` would: after that no evaluation changes it."""
    from tfsat_host.calibration.certificate.file import read_calibration
    from tfsat_host.cli.calibration_notice import is_of_robot, origin_of_log
    from tfsat_host.cli.decode_landing import note_landing_of

    if found.log is None or not certificate.is_file():
        return
    try:
        present = read_calibration(certificate)
    except TfsatError:
        return  # it is kept as it is; the evaluation says what is wrong with it
    if is_of_robot(present, origin_of_log(found.log.header)):
        quiet = Output(json_mode=True, stdout=io.StringIO(), stderr=io.StringIO())
        note_landing_of(found.log, certificate, present, quiet)


def _entry(number: int, found: Collected, staged: Path, args: argparse.Namespace) -> DropEntry:
    from tfsat_host.campaign.entries import EMULATED, REAL, UNKNOWN, DropEntry
    from tfsat_host.cli.calibration_notice import origin_of_log
    from tfsat_host.cli.decode_landing import time_of_day

    log, now = found.log, datetime.now(UTC)
    entry = DropEntry(
        number=number,
        recording=found.recording.name,
        sha256=sha256_of(staged / found.recording.name),
        session=None if log is None else f"{log.session:08x}",
        released=None if log is None else time_of_day(log, log.release_us),
        added=now,
        origin=str(args.run),
        robot=UNKNOWN if log is None else EMULATED if origin_of_log(log.header).emulated else REAL,
    )
    return entry if args.note is None else entry.with_note(now, args.note)
