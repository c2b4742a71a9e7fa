"""A campaign: a folder of numbered drops, with an index that people can read and a lock for two terminals at once.

Every drop's folder holds its own copy of its entry: an index that is lost or damaged is rebuilt from them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from tfsat_host.errors import TfsatError
from tfsat_host.file_hash import change_of
from tfsat_host.file_lock import one_at_a_time
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.quantity import Column, Columns, columns_of, fields
from tfsat_host.run.campaign.entries import (
    ENTRY,
    NUMBER_MAX,
    DropEntry,
    Note,
    folder_name,
    format_drop,
    format_index,
    number_of,
    parse_drop,
    parse_index,
)
from tfsat_host.run.files import PREFLIGHT, REHEARSED
from tfsat_host.run.signed_record import RECORD, verify
from tfsat_host.whole_file import write_whole

INDEX = "campaign.json"
DROP = "drop.json"
_OF_A_RUN = ("*.[bB][iI][nN]", DROP, PREFLIGHT, RECORD, REHEARSED)
"""What lies in the folder of a run that was checked, flown or rehearsed."""
STAGING = ".adding-"
SIGNED_BY = "tfsat-host campaign add"
"""How the entry of the record begins with which a run is closed: what is signed after it came later than the drop."""
_LOCK = ".campaign.lock"
_UNCHANGED = "Nothing was changed."
_INDEX_BYTES_MAX = 64_000_000


class CampaignError(TfsatError):
    """A campaign cannot be read, or must not be changed so (exit code 1)."""


class SameDropError(CampaignError):
    """A recording is of `drop`, which the campaign has (exit code 1)."""

    drop: DropEntry


@dataclass(frozen=True)
class Contents:
    """What a campaign holds.

    Attributes:
        drops: By number.
        findings: What is wrong with the index or the folders; a sentence each.
        numbers_seen: The greatest number that an entry or a folder has; 0: there is none.
        index_damaged: It cannot be read.
    """

    drops: tuple[DropEntry, ...]
    findings: tuple[str, ...]
    numbers_seen: int
    index_damaged: bool

    @property
    def next_number(self) -> int:
        """Of the next drop: one more than any before, whether it is still there or not."""
        return self.numbers_seen + 1


def init(folder: Path) -> None:
    """Makes an empty campaign.

    Raises:
        CampaignError: there is one already, or the folder holds drops of one, or a run.
        OSError: it cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with _lock_campaign(folder):
        # Numbered folders without an index are a campaign whose index was lost.
        if (folder / INDEX).exists() or _folders(folder):
            raise CampaignError(
                what=f"{folder} is a campaign already.",
                meaning=_UNCHANGED,
                next_step=Advice(NextStep("campaign list", (str(folder),))),
            )
        _require_no_run(folder)
        write_whole(folder / INDEX, format_index(()).encode())


def read(folder: Path) -> Contents:
    """Read a campaign's index and its drops' folders.

    Raises:
        CampaignError: it is no campaign.
        OSError: something cannot be read.
    """
    folders = _folders(folder) if folder.is_dir() else {}
    index = folder / INDEX
    if not index.is_file() and not folders:
        raise CampaignError(
            what=f"{folder} is no campaign: it holds neither {INDEX} nor drops.",
            meaning="Nothing was done.",
            next_step=Advice("To make it one: ", NextStep("campaign init", (str(folder),))),
        )
    index_entries, findings, damaged = _read_index(index)
    entries_by_number = {drop.number: drop for drop in index_entries}
    # What a lost or damaged index does not name is adopted from the folders' own entries.
    for number, path in sorted(folders.items()):
        if number not in entries_by_number:
            entry, sentence = _adopt_entry(path, number)
            findings.append(sentence)
            if entry is not None:
                entries_by_number[number] = entry
    findings += filter(None, (_gone_or_other(folder, drop, drop.number in folders) for drop in index_entries))
    drops = tuple(entries_by_number[number] for number in sorted(entries_by_number))
    # Folders that cannot be read count in the maximum, too: a number is never given twice.
    return Contents(drops, tuple(findings), max([*entries_by_number, *folders], default=0), damaged)


@dataclass(frozen=True)
class ListedDrop:
    """A drop of a campaign.

    Attributes:
        entry: As the index has it.
        changes: To its files since it was added, as sentences.
        gone: Its folder is not there any more.
    """

    entry: DropEntry
    changes: tuple[str, ...]
    gone: bool


@dataclass(frozen=True)
class CampaignList:
    """All drops of the campaign in `folder`, and what its index and folders hold."""

    folder: Path
    contents: Contents
    drops: tuple[ListedDrop, ...]


LISTED: Columns = (
    *columns_of("entry", ENTRY),
    Column(
        "changes", "unmodified", words=lambda drop: "GONE" if drop.gone else "NO" if drop.changes else "yes"
    ),
    *fields("gone"),
)
LIST: Columns = (
    *fields("campaign=folder"),
    Column("drops", columns=LISTED),
    *fields("next=contents.next_number findings=contents.findings"),
)
"""Of `campaign list --json`."""
NEXT: Columns = (
    Column("number", of="next_number"),
    Column("folder", of=lambda contents: folder_name(contents.next_number)),
    Column("findings"),
)
"""Of `campaign next --json`."""


def list_drops(folder: Path) -> CampaignList:
    """List all drops and the changes to each since it was added. Raises as `read` does."""
    contents = read(folder)
    drops = tuple(
        ListedDrop(drop, tuple(changes_in(folder, drop)), not (folder / drop.folder).is_dir())
        for drop in contents.drops
    )
    return CampaignList(folder, contents, drops)


def add(folder: Path, staged: Path, entry_of: Callable[[int], DropEntry]) -> DropEntry:
    """Gives a drop the next number and its place.

    `staged` is the drop's folder, whole, in the campaign's `folder` under a name that begins with `STAGING`;
    it is moved. `entry_of` makes the entry when the number is known.

    Raises:
        CampaignError: it is no campaign, it holds this recording already or another copy of it, or it is full.
            Nothing was changed.
        BusyError: another program is writing it.
        OSError: something cannot be written.
    """
    with _lock_campaign(folder):
        contents = read(folder)
        if contents.next_number > NUMBER_MAX:
            raise CampaignError(
                what=f"{folder} has had {NUMBER_MAX} drops.",
                meaning="Nothing was added.",
                next_step=Advice("Begin another one: ", NextStep("campaign init")),
            )
        entry = entry_of(contents.next_number)
        _check_new(folder, contents.drops, entry)
        # Its own entry goes in before the rename, so that the drop appears whole.
        (staged / DROP).write_text(format_drop(entry), encoding="utf-8")
        staged.rename(folder / entry.folder)
        # The index comes last: after a crash in between, read() adopts the folder.
        _write(folder, contents, (*contents.drops, entry), entry.added)
    return entry


def note(folder: Path, number: int, text: str) -> DropEntry:
    """Adds a note to a drop, one line of text.

    Raises:
        CampaignError: it is no campaign, there is no such drop, or this is no note.
        BusyError: another program is writing it.
        OSError: something cannot be written.
    """
    check_note(text, Advice(NextStep("campaign note", (str(folder), str(number))), ' "wind from the west"'))
    return _change_entry(folder, number, lambda drop, at: drop.with_note(at, text))


def void(folder: Path, number: int, why: str) -> DropEntry:
    """Takes a drop out of the count; its number, its folder and its notes stay.

    Raises:
        CampaignError: it is no campaign, there is no such drop, it is void already, or this is no note.
        BusyError: another program is writing it.
        OSError: something cannot be written.
    """

    def voided(before: DropEntry, at: datetime) -> DropEntry:
        if before.void is None:
            return replace(before, void=Note(at, why))
        raise CampaignError(
            what=f"Drop {number} of {folder} is void already: {before.void.text}",
            meaning=_UNCHANGED,
            next_step=Advice("To add a note: ", NextStep("campaign note", place), ' "…"'),
        )

    place = (str(folder), str(number))
    check_note(why, Advice(NextStep("campaign void", place), ' "the hook was caught"'))
    return _change_entry(folder, number, voided)


def _change_entry(folder: Path, number: int, change: Callable[[DropEntry, datetime], DropEntry]) -> DropEntry:
    """Writes another entry of a drop. Raises CampaignError: there is no such drop."""
    at = datetime.now(UTC)
    with _lock_campaign(folder):
        contents = read(folder)
        before = next((drop for drop in contents.drops if drop.number == number), None)
        if before is None:
            there = ", ".join(str(drop.number) for drop in contents.drops) or "none yet"
            raise CampaignError(
                what=f"{folder} has no drop {number}; there are: {there}.",
                meaning=_UNCHANGED,
                next_step=Advice(NextStep("campaign list", (str(folder),))),
            )
        changed = change(before, at)
        # The drop's own copy changes as well, as a lost index is rebuilt from it.
        if (folder / changed.folder).is_dir():
            write_whole(folder / changed.folder / DROP, format_drop(changed).encode())
        _write(folder, contents, [changed if drop == before else drop for drop in contents.drops], at)
    return changed


def changes_in(folder: Path, drop: DropEntry) -> list[str]:
    """List the changes to a drop's files since it was added, as sentences.

    `folder` is the campaign's.
    """
    place = folder / drop.folder
    recording = place / drop.recording
    if not place.is_dir():
        return []  # a finding of the campaign
    change = change_of(recording, drop.sha256)
    if change == "missing":
        return [f"{recording} is missing."]
    changes = [f"{recording} was changed since it came in."] if change else []
    # What was signed after the drop came in does not count as evidence.
    findings = verify(place, closed_by=SIGNED_BY)
    # The recording was compared with the index above: its finding is not told twice.
    return changes + [
        record_finding.sentence for record_finding in findings if record_finding.name != drop.recording
    ]


def check_note(text: str, example: str) -> None:
    """Raises CampaignError: it says nothing, or is no line of text. `example` is a command with one that does."""
    if not text.strip() or not text.isprintable():
        raise CampaignError(
            what="A note is one line of printable text.",
            meaning=_UNCHANGED,
            next_step=Advice("Write it in quotes: ", example),
        )


def _lock_campaign(folder: Path) -> AbstractContextManager[object]:
    return one_at_a_time(folder / _LOCK, f"the campaign {folder}")


def _check_new(folder: Path, drops: Sequence[DropEntry], entry: DropEntry) -> None:
    """Refuse a drop that is already in the campaign: one drop counts once.

    Drops are also compared by the recording's own id: two copies off one card may differ in length.
    """
    # A void drop does not stand in the way: another copy of it may take its place.
    counting = [drop for drop in drops if drop.void is None]
    same = next((drop for drop in counting if drop.sha256 == entry.sha256), None)
    alike = next((drop for drop in counting if drop.session == entry.session is not None), None)
    there = same or alike
    if there is None:
        return
    place = (str(folder), str(there.number))
    error = SameDropError(
        what=f"This recording is drop {there.number} of {folder} already ({there.folder})."
        if same
        else f"The recording {entry.session} is drop {there.number} of {folder} already ({there.folder}), in "
        "another copy.",
        meaning="One drop counts once; nothing was added.",
        next_step=Advice("To add a note: ", NextStep("campaign note", place), ' "…"')
        if same
        else Advice(
            "To replace it by this copy: ",
            NextStep("campaign void", place),
            ' "another copy follows", then add this one again.',
        ),
    )
    error.drop = there
    raise error


def _write(folder: Path, before: Contents, drops: Sequence[DropEntry], at: datetime) -> None:
    if before.index_damaged:
        (folder / INDEX).replace(folder / f"campaign.damaged-{at:%Y%m%dT%H%M%S}.json")
    write_whole(folder / INDEX, format_index(drops).encode())


def _require_no_run(folder: Path) -> None:
    run_file_name = next((path.name for pattern in _OF_A_RUN for path in sorted(folder.glob(pattern))), None)
    if run_file_name is not None:
        raise CampaignError(
            what=f"{folder} is the folder of a run: it holds {run_file_name}.",
            meaning="A campaign holds runs, a folder each, and is none itself. Nothing was changed.",
            next_step="Give the name of a new folder; campaign add then copies the run into it.",
        )


def _own_entry(place: Path) -> DropEntry | str:
    """Read the entry in a drop's own folder, or return why it cannot be read."""
    try:
        return parse_drop((place / DROP).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        return (error.strerror or "") if isinstance(error, OSError) else str(error)


def _gone_or_other(folder: Path, drop: DropEntry, there: bool) -> str:
    """Describe the fault in the folder or the own entry of a drop in the index.

    Returns an empty string if there is no fault.
    """
    place, own = folder / drop.folder, _own_entry(folder / drop.folder)
    if not there:
        reason = NextStep("campaign void", (str(folder), str(drop.number), "REASON"))
        return Advice(
            f"{place} is gone; the index still has it. Copy it back from a backup or out of its bundle; "
            "if it is lost, take it out of the count: ",
            reason,
        )
    if own == drop:
        return ""
    what = "is not as the index has this drop"
    if isinstance(own, str):
        what = f"cannot be read ({own}): only the index knows this drop"
        if not (place / DROP).exists():
            what = "is gone: only the index knows this drop"
    again = NextStep("campaign note", (str(folder), str(drop.number)))
    return Advice(f"{place / DROP} {what}. ", again, " writes it again.")


def _folders(folder: Path) -> dict[int, Path]:
    numbered_folders = ((number_of(path.name), path) for path in folder.iterdir() if path.is_dir())
    return {number: path for number, path in numbered_folders if number is not None}


def _read_index(index: Path) -> tuple[tuple[DropEntry, ...], list[str], bool]:
    """Read the index; return its entries, the findings, and whether it is damaged."""
    if not index.is_file():
        return (), [f"{index} is not there: it was rebuilt from the drops' folders."], False
    try:
        if index.stat().st_size > _INDEX_BYTES_MAX:
            raise ValueError("it is too large")
        return parse_index(index.read_text(encoding="utf-8")), [], False
    except ValueError as error:
        sentence = f"{index} is damaged ({error}): it was rebuilt from the drops' folders."
        return (), [sentence], True


def _adopt_entry(path: Path, number: int) -> tuple[DropEntry | None, str]:
    """Read a drop's entry from its folder, as the index lacks it.

    Returns the entry, None if it cannot be used, and a sentence that reports this.
    """
    own = _own_entry(path)
    if isinstance(own, str):
        return None, f"{path} is not in the index, and its own {DROP} cannot be read: {own}."
    # Adopted, a folder that was copied by hand would count one drop twice.
    if own.number != number:
        copied = f"holds the {DROP} of {folder_name(own.number)}: it was renamed or copied by hand."
        return None, f"{path} {copied}"
    return own, f"{path} was not in the index: it was taken from its own {DROP}."
