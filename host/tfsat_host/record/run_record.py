"""`record.json` in a run's folder: what vouches for which files, as a chain of hashes.

    sign(run, [run / "preflight.json"], "tfsat-host preflight 0.8.0: GO", datetime.now(UTC))
    for finding in verify(run): print(finding.sentence)

It tells what was changed by accident or in haste. It holds no secret: whoever rewrites all of it on purpose can; to
rule that out, write the hash of the last entry (`sha256_of_entry`) into a logbook.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import datetime
from pathlib import Path, PurePosixPath
from typing import Literal

from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import sha256_of
from tfsat_host.file_lock import one_at_a_time
from tfsat_host.record.entries import (
    Entry,
    Finding,
    SignedFile,
    format_record,
    parse_record,
    sha256_of_entry,
)
from tfsat_host.whole_file import write_whole

RECORD = "record.json"
_LOCK = ".record.lock"
_RECORD_BYTES_MAX = 64_000_000


class RecordError(TfsatError):
    """The record cannot be gone on with (exit code 1)."""


def sign(folder: Path, files: Sequence[Path], by: str, at: datetime) -> Entry:
    """Adds an entry to the record of a run: these files are as they are now.

    Args:
        folder: Of the run.
        files: In it or below; relative ones are relative to the current folder.
        by: What vouches for them: command, version, result in a word.
        at: When, with its time zone.

    Raises:
        RecordError: the record is damaged, or a file is none or lies elsewhere. Nothing was written.
        BusyError: another program is writing the record.
        OSError: something cannot be read or written.
    """
    if at.tzinfo is None:
        raise ValueError("the time of an entry needs its time zone")
    signed = tuple(_signed(folder, file) for file in files)
    with one_at_a_time(folder / _LOCK, f"the record of {folder}"):
        entries = entries_of(folder)
        previous = sha256_of_entry(entries[-1]) if entries else ""
        entry = Entry(at, by, signed, previous)
        write_whole(folder / RECORD, format_record((*entries, entry)).encode())
    return entry


def entries_of(folder: Path) -> tuple[Entry, ...]:
    """The entries of a run's record; none where there is no record.

    Raises:
        RecordError: it is damaged.
        OSError: it cannot be read.
    """
    if not (folder / RECORD).exists():
        return ()
    entries, findings = _read(folder)
    if findings:
        raise RecordError(
            what=" ".join(finding.sentence for finding in findings),
            meaning="Nothing was added to it: an entry after a broken one vouches for nothing.",
            next_step=f"Copy {RECORD} back from where it is whole, or move it away to begin a new one.",
        )
    return entries


def verify(folder: Path, *, closed_by: str = "") -> tuple[Finding, ...]:
    """What is not as the record says; nothing: all is. Without a record nothing can be.

    A file that was signed several times is held against the last time. Files that nobody signed are not looked at.

    Args:
        folder: Of the run.
        closed_by: How `by` begins of the entry with which the run was closed. What was signed after the last such entry
            counts for nothing, and is named; empty, or there is none: the run is open.

    Raises:
        OSError: something cannot be read.
    """
    if not (folder / RECORD).exists():
        return ()
    entries, findings = _read(folder)
    closing = [
        number for number, entry in enumerate(entries, 1) if closed_by and entry.by.startswith(closed_by)
    ]
    count = closing[-1] if closing else len(entries)
    last = {file.name: (file, entry) for entry in entries[:count] for file in entry.files}
    after = (_after(folder, entry) for entry in entries[count:])
    return (*findings, *_found(folder, last.values()), *after)


def _read(folder: Path) -> tuple[tuple[Entry, ...], tuple[Finding, ...]]:
    """Entries, as far as they can be read, and where the chain is broken."""
    path = folder / RECORD
    if path.stat().st_size > _RECORD_BYTES_MAX:
        return (), (_damaged(f"{path} is too large for a record."),)
    data = path.read_bytes()
    try:
        entries, last = parse_record(data.decode("utf-8"))
    except ValueError as error:
        return (), (_damaged(f"{path} is no record of a run, or it is damaged: {error}."),)
    findings = _breaks(path, entries, last)
    if not findings and format_record(entries).encode() != data:
        findings = [Finding("changed", RECORD, f"{path} was edited: it is not as tfsat-host writes it.")]
    return entries, tuple(findings)


def _breaks(path: Path, entries: Sequence[Entry], last: str) -> list[Finding]:
    hashes = [sha256_of_entry(entry) for entry in entries]
    named = [*(entry.previous for entry in entries), last]
    found = []
    for number, (before, entry_names) in enumerate(zip(["", *hashes], named, strict=True)):
        if before == entry_names:
            continue
        who = "Its last line" if number == len(entries) else f"Entry {number + 1} ({_of(entries[number])})"
        if number == 0:
            found.append(_break("missing", f"{path}: {who} names an entry before it that is not there."))
            continue
        last_of = f"{path}: entry {number} ({_of(entries[number - 1])})"
        if entry_names in ["", *hashes[:number]]:
            found.append(_break("inserted", f"{last_of} was inserted, or what follows was changed."))
        else:
            names_another = f"{who[:1].lower()}{who[1:]} names another"
            found.append(
                _break("changed", f"{last_of} was changed, or one that followed is missing: {names_another}.")
            )
    return found


def _found(folder: Path, signed: Iterable[tuple[SignedFile, Entry]]) -> list[Finding]:
    found = []
    for file, entry in signed:
        if not is_inside(file.name):
            found.append(
                Finding("changed", RECORD, f"{folder / RECORD} names a file outside: {file.name!r}.")
            )
            continue
        path = folder / file.name
        if not path.is_file():
            found.append(Finding("missing", file.name, f"{path} is missing; signed: {_of(entry)}."))
        elif path.stat().st_size != file.bytes or sha256_of(path) != file.sha256:
            found.append(
                Finding("changed", file.name, f"{path} was changed since it was signed: {_of(entry)}.")
            )
    return found


def _after(folder: Path, entry: Entry) -> Finding:
    names = ", ".join(file.name for file in entry.files) or "no file"
    return Finding(
        "inserted",
        RECORD,
        f"{folder / RECORD} was gone on with after it was closed: {_of(entry)}, for {names}.",
    )


def _signed(folder: Path, file: Path) -> SignedFile:
    try:
        name = file.resolve().relative_to(folder.resolve()).as_posix()
    except ValueError as error:
        raise _unsignable(f"{file} does not lie in {folder}.") from error
    if not file.is_file():
        raise _unsignable(f"{file} is not there, or no file.")
    if name in (RECORD, _LOCK):
        raise _unsignable(f"{file} is the record itself.")
    return SignedFile(name, sha256_of(file), file.stat().st_size)


def is_inside(name: str) -> bool:
    """Whether a name that somebody else wrote stays below the folder that it is relative to."""
    parts = PurePosixPath(name).parts
    return bool(parts) and not PurePosixPath(name).is_absolute() and ".." not in parts and "\0" not in name


def _of(entry: Entry) -> str:
    return f"{entry.by}, {entry.at:%Y-%m-%d %H:%M:%S} UTC"


def _damaged(sentence: str) -> Finding:
    return Finding("damaged", RECORD, sentence)


def _break(kind: Literal["changed", "missing", "inserted"], sentence: str) -> Finding:
    return Finding(kind, RECORD, sentence)


def _unsignable(what: str) -> RecordError:
    return RecordError(
        what=what,
        meaning="Nothing was signed.",
        next_step="Name files in the folder of the run.",
    )
