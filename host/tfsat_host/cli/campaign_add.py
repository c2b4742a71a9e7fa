"""`tfsat-host campaign add`: a run becomes the next drop of a campaign, whole or not at all."""

from __future__ import annotations

import argparse
import shutil
import tempfile
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from tfsat_host import __version__
from tfsat_host.cli.output import Output
from tfsat_host.errors import TfsatError

if TYPE_CHECKING:
    from tfsat_host.campaign.entries import DropEntry
    from tfsat_host.cli.bundle_files import Collected

_NOTHING = "Nothing was added."


def add(args: argparse.Namespace, out: Output) -> int:
    """Copies, then gives a number; with `--move` the original goes when the copy is in its place."""
    from tfsat_host.campaign import folder as campaign
    from tfsat_host.cli.bundle_files import collect

    campaign.read(args.dir)
    if args.note is not None:
        check_note(args.note)
    _check_places(args.dir, args.run, move=args.move)
    found, _ = collect(args.run, no_options())
    staged = Path(tempfile.mkdtemp(prefix=campaign.STAGING, dir=args.dir))
    try:
        with out.progress(f"Copying {args.run}"):
            _copy(args.run, found, staged)
        _sign(staged, found, out)
        entry = campaign.add(args.dir, staged, lambda number: _entry(number, found, staged, args))
    finally:
        campaign.remove_staged(staged)
    (args.dir / entry.folder).chmod(0o755)
    place = args.dir / entry.folder
    if args.move:
        try:
            shutil.rmtree(args.run)
        except OSError as error:
            out.warn(f"{place} is whole, but {error.filename} could not be removed: {error.strerror}.")
    result = {**entry.as_dict(), "path": str(place), "moved": args.move}
    out.result(result, f"Drop {entry.number}  {place}{'' if args.move else f', a copy of {args.run}'}")
    if found.log is None:
        out.warn("Its recording cannot be decoded: it is kept, and left out of the report.")
    return 0


def check_note(text: str) -> None:
    """Raises TfsatError: it says nothing, or is no line of text."""
    if not text.strip() or not text.isprintable():
        raise TfsatError(
            what="A note is one line of printable text.",
            meaning="Nothing was changed.",
            next_step='Write it in quotes: --note "wind from the west"',
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


def _copy(place: Path, found: Collected, staged: Path) -> None:
    """A folder whole, of a recording what belongs to it; the certificate and its recordings always beside it."""
    if place.is_dir():
        shutil.copytree(place, staged, dirs_exist_ok=True, ignore=_ignored)
    for name, path in found.files.items():
        kind, _, inside = name.partition("/")
        if kind in ("run", "calibration") and not (staged / inside).exists():
            (staged / inside).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, staged / inside)


def _ignored(folder: str, names: list[str]) -> list[str]:
    """Locks, and what is no file: a pipe would never end."""
    paths = {name: Path(folder) / name for name in names}
    return [
        name
        for name, path in paths.items()
        if name.endswith(".lock") or not (path.is_file() or path.is_dir())
    ]


def _sign(staged: Path, found: Collected, out: Output) -> None:
    """The recording and the maneuver do not change any more; a certificate does, with each landing."""
    from tfsat_host.cli.evaluate.run_files import MANEUVER
    from tfsat_host.record.run_record import RecordError, sign

    files = [staged / found.recording.name, staged / MANEUVER]
    there = [path for path in files if path.is_file()]
    try:
        sign(staged, there, f"tfsat-host campaign add {__version__}", datetime.now(UTC))
    except RecordError as error:
        out.warn(f"The drop's record was not gone on with. {error.what} {error.next_step}")


def _entry(number: int, found: Collected, staged: Path, args: argparse.Namespace) -> DropEntry:
    from tfsat_host.campaign.entries import DropEntry
    from tfsat_host.cli.decode_landing import time_of_day
    from tfsat_host.record.run_record import sha256_of

    log, now = found.log, datetime.now(UTC)
    entry = DropEntry(
        number=number,
        recording=found.recording.name,
        sha256=sha256_of(staged / found.recording.name),
        session=None if log is None else f"{log.session:08x}",
        released=None if log is None else time_of_day(log, log.release_us),
        added=now,
        origin=str(args.run),
    )
    return entry if args.note is None else entry.with_note(now, args.note)
