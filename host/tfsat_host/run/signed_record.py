"""`record.json` in a run's folder: which command signed which files, as a chain of hashes.

    sign(run, [run / "preflight.json"], "tfsat-host preflight 0.8.0: GO", datetime.now(UTC))
    for finding in verify(run): print(finding.sentence)

It shows what was changed by accident or in haste. It holds no secret: whoever rewrites all of it on purpose can; to
rule that out, write the hash of the last entry (`sha256_of_entry`) into a logbook.
"""

from __future__ import annotations

import hashlib
import json
import logging
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Literal

from tfsat_host import json_values
from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import change_of, sha256_of
from tfsat_host.file_lock import one_at_a_time
from tfsat_host.quantity import Column, Columns, fields, record, records
from tfsat_host.run.files import is_inside
from tfsat_host.whole_file import write_whole

_LOG = logging.getLogger(__name__)

RECORD = "record.json"
_LOCK = ".record.lock"
_RECORD_BYTES_MAX = 64_000_000
_MADE_BY = "tfsat-host: each entry names files by SHA-256, and the entry before it by its own"
_FORMAT = 1


class RecordError(TfsatError):
    """The record cannot be gone on with (exit code 1)."""


def _hash_before(value: object) -> str:
    """Check the hash of an entry, or the empty text that stands before the first one."""
    return "" if value == "" else json_values.sha256(value)


def _some_text(value: object) -> str:
    return json_values.text(value, empty=False)


_SomeText = Annotated[str, _some_text]
_Sha256 = Annotated[str, json_values.sha256]


@dataclass(frozen=True, slots=True)
class SignedFile:
    """A file as it was when an entry was made.

    Attributes:
        name: Below the run's folder, with `/` between folders.
        sha256: Of its bytes, hexadecimal.
        bytes: How many.
    """

    name: _SomeText
    sha256: _Sha256
    bytes: int


@dataclass(frozen=True, slots=True)
class Entry:
    """Something was done.

    Attributes:
        at: When, with its time zone.
        by: What did it, such as `tfsat-host preflight 0.8.0: GO`.
        files: That it signs.
        previous: SHA-256 of the entry before it; empty in the first.
    """

    at: datetime
    by: _SomeText
    files: tuple[SignedFile, ...]
    previous: Annotated[str, _hash_before]


ENTRY: Columns = (
    Column("at", of=lambda entry: entry.at.astimezone(UTC).isoformat().replace("+00:00", "Z")),
    Column("by"),
    Column("files", columns=fields("name sha256 bytes")),
    Column("previous"),
)
"""Of an entry in `record.json`; its hash depends on them."""


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that is not as the record says.

    Attributes:
        kind: What happened to it.
        name: The file, or the record itself.
        sentence: For people.
    """

    kind: Literal["changed", "missing", "inserted", "damaged"]
    name: str
    sentence: str


def sign(folder: Path, files: Sequence[Path], by: str, at: datetime) -> Entry:
    """Adds an entry to the record of a run: these files are as they are now.

    Args:
        folder: Of the run.
        files: In it or below; relative ones are relative to the current folder.
        by: Who signs them: command, version, result in a word.
        at: When, with its time zone.

    Raises:
        RecordError: the record is damaged, or a file is none or lies elsewhere. Nothing was written.
        BusyError: another program is writing the record.
        OSError: something cannot be read or written.
    """
    if at.tzinfo is None:
        raise ValueError("the time of an entry needs its time zone")
    # Hash outside of the lock: only the chain must not change between its reading and writing.
    signed = tuple(_sign_file(folder, file) for file in files)
    with one_at_a_time(folder / _LOCK, f"the record of {folder}"):
        # Read under the lock, so that two programs cannot append to the same last entry.
        entries = entries_of(folder)
        previous = sha256_of_entry(entries[-1]) if entries else ""
        entry = Entry(at, by, signed, previous)
        write_whole(folder / RECORD, format_record((*entries, entry)).encode())
    return entry


def entries_of(folder: Path) -> tuple[Entry, ...]:
    """Read the entries of a run's record; none where there is no record.

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
            meaning="Nothing was added to it: an entry after a broken one proves nothing.",
            next_step=f"Copy {RECORD} back from where it is whole, or move it away to begin a new one.",
        )
    return entries


def verify(folder: Path, *, closed_by: str = "") -> tuple[Finding, ...]:
    """Verify a run's files against its record and return the deviations; empty if there are none.

    Without a record nothing can be verified, and nothing is returned. A file that was signed several times is
    compared with its last signature. Files that were not signed are not checked.

    Args:
        folder: Of the run.
        closed_by: The prefix of `by` in the entry with which the run was closed. Anything signed after the
            last such entry does not count, and is named. If empty, or without such an entry, the run is open.

    Raises:
        OSError: something cannot be read.
    """
    if not (folder / RECORD).exists():
        return ()
    entries, findings = _read(folder)
    # Signatures after the last closing do not count: they could sign a file changed since.
    closing = [
        number for number, entry in enumerate(entries, 1) if closed_by and entry.by.startswith(closed_by)
    ]
    count = closing[-1] if closing else len(entries)
    # Of each name the last signature stays: a file may rightly change between two of them.
    last = {file.name: (file, entry) for entry in entries[:count] for file in entry.files}
    after = (_after(folder, entry) for entry in entries[count:])
    return (*findings, *_find_changes(folder, last.values()), *after)


def _read(folder: Path) -> tuple[tuple[Entry, ...], tuple[Finding, ...]]:
    """Entries, as far as they can be read, and where the chain is broken."""
    path = folder / RECORD
    try:
        if path.stat().st_size > _RECORD_BYTES_MAX:
            raise ValueError("it is too large")
        data = path.read_bytes()
        _LOG.debug("read %s: a run's record", path)
        entries, last = parse_record(data.decode("utf-8"))
    except ValueError as error:
        sentence = f"{path} is no record of a run, or it is damaged: {error}."
        return (), (Finding("damaged", RECORD, sentence),)
    findings = _breaks(path, entries, last)
    # The chain holds, but only the canonical text is ours: whatever else differs was edited by hand.
    if not findings and format_record(entries).encode() != data:
        findings = [Finding("changed", RECORD, f"{path} was edited: it is not as tfsat-host writes it.")]
    return entries, tuple(findings)


def _breaks(path: Path, entries: Sequence[Entry], last: str) -> list[Finding]:
    # Shifted by one: each entry names the hash of the one before, the last line that of the last entry.
    hashes = [sha256_of_entry(entry) for entry in entries]
    named = [*(entry.previous for entry in entries), last]
    findings = []
    for number, (before, entry_names) in enumerate(zip(["", *hashes], named, strict=True)):
        if before == entry_names:
            continue
        who = "Its last line" if number == len(entries) else f"Entry {number + 1} ({_of(entries[number])})"
        if number == 0:
            sentence = f"{path}: {who} names an entry before it that is not there."
            findings.append(Finding("missing", RECORD, sentence))
            continue
        last_of = f"{path}: entry {number} ({_of(entries[number - 1])})"
        # The next link passes this entry over and names an earlier one.
        if entry_names in ["", *hashes[:number]]:
            sentence = f"{last_of} was inserted, or what follows was changed."
            findings.append(Finding("inserted", RECORD, sentence))
        else:
            follows = f"{who[:1].lower()}{who[1:]} names another"
            sentence = f"{last_of} was changed, or one that followed is missing: {follows}."
            findings.append(Finding("changed", RECORD, sentence))
    return findings


def _find_changes(folder: Path, signed: Iterable[tuple[SignedFile, Entry]]) -> Iterator[Finding]:
    for file, entry in signed:
        path = folder / file.name
        # Names in the record are not trusted: nothing outside of the run's folder is opened.
        if not is_inside(file.name):
            yield Finding("changed", RECORD, f"{folder / RECORD} names a file outside: {file.name!r}.")
        elif change := change_of(path, file.sha256):
            what = "was changed since it was signed:" if change == "changed" else "is missing; signed:"
            yield Finding(change, file.name, f"{path} {what} {_of(entry)}.")


def _after(folder: Path, entry: Entry) -> Finding:
    names = ", ".join(file.name for file in entry.files) or "no file"
    what = f"{folder / RECORD} was gone on with after it was closed: {_of(entry)}, for {names}."
    return Finding("inserted", RECORD, what)


def _sign_file(folder: Path, file: Path) -> SignedFile:
    # Resolve links first: a file that lies elsewhere would not move with the run.
    try:
        name = file.resolve().relative_to(folder.resolve()).as_posix()
    except ValueError as error:
        raise _unsignable(f"{file} does not lie in {folder}.") from error
    if not file.is_file():
        raise _unsignable(f"{file} is not there, or no file.")
    if name in (RECORD, _LOCK):
        raise _unsignable(f"{file} is the record itself.")
    return SignedFile(name, sha256_of(file), file.stat().st_size)


def _of(entry: Entry) -> str:
    return f"{entry.by}, {entry.at:%Y-%m-%d %H:%M:%S} UTC"


def _unsignable(what: str) -> RecordError:
    return RecordError(
        what=what,
        meaning="Nothing was signed.",
        next_step="Name files in the folder of the run.",
    )


def sha256_of_entry(entry: Entry) -> str:
    """Compute the hexadecimal SHA-256 of an entry's JSON, without spaces and with sorted keys."""
    # A canonical form, so that the hash depends on the values and not on the layout of the file.
    text = json.dumps(record(ENTRY, entry), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def format_record(entries: tuple[Entry, ...]) -> str:
    """Format the record's text; `last` is the hash of the last entry, which no other entry names."""
    last = sha256_of_entry(entries[-1]) if entries else ""
    document = {"made_by": _MADE_BY, "format": _FORMAT, "entries": records(ENTRY, entries), "last": last}
    return json_values.format_json(document)


def parse_record(text: str) -> tuple[tuple[Entry, ...], str]:
    """Parse a record into its entries and the hash it states for the last one.

    Raises ValueError: it is no record.
    """
    try:
        document = json.loads(text)
        if document["format"] != _FORMAT:
            raise ValueError(f"its format is {document['format']!r}, this program reads {_FORMAT}")
        entries = tuple(json_values.parse_dataclass(Entry, raw_entry) for raw_entry in document["entries"])
        return entries, _hash_before(document["last"])
    except (KeyError, TypeError, RecursionError, OverflowError) as error:
        raise ValueError(f"{type(error).__name__} at {error}") from error
