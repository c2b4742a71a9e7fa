"""The record of a run: what was signed is told to be changed, missing or inserted, and nothing else is."""

from __future__ import annotations

import json
import multiprocessing
import shutil
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfsat_host.run.signed_record import (
    RECORD,
    Entry,
    RecordError,
    SignedFile,
    entries_of,
    format_record,
    parse_record,
    sha256_of_entry,
    sign,
    verify,
)

AT = datetime(2026, 7, 1, 9, 30, tzinfo=UTC)
_WORDS = st.text(st.characters(codec="utf-8"), min_size=1)
NAMES = ("SD.bin", "maneuver.toml", "preflight.json")


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """Create a run with three files, signed in three entries."""
    folder = tmp_path / "run"
    folder.mkdir()
    for number, name in enumerate(NAMES):
        # Other bytes in each file: exchanged files must not verify.
        (folder / name).write_bytes(bytes(range(16 * number, 16 * number + 16)))
        sign(folder, [folder / name], f"step {number}", AT + timedelta(minutes=number))
    return folder


def list_findings(folder: Path) -> list[tuple[str, str]]:
    return [(finding.kind, finding.name) for finding in verify(folder)]


def test_what_is_as_it_was_signed_is_not_spoken_of(run: Path) -> None:
    (run / "notes.txt").write_text("nobody signed this")
    assert verify(run) == ()
    assert [entry.by for entry in entries_of(run)] == ["step 0", "step 1", "step 2"]
    assert verify(run.parent) == (), "no record, nothing to hold against"


def test_each_entry_names_the_one_before(run: Path) -> None:
    entries = entries_of(run)
    assert [entry.previous for entry in entries] == ["", *map(sha256_of_entry, entries[:-1])]
    # No entry names the last one: without this hash it could be cut off unnoticed.
    assert json.loads((run / RECORD).read_text())["last"] == sha256_of_entry(entries[-1])


def test_times_are_kept_in_utc(run: Path) -> None:
    tokyo = timezone(timedelta(hours=9))
    entry = sign(run, [], "later", datetime(2026, 7, 1, 19, 0, tzinfo=tokyo))
    assert entries_of(run)[-1].at == entry.at == datetime(2026, 7, 1, 10, 0, tzinfo=UTC)
    # A time without its zone cannot be ordered among entries of other computers.
    with pytest.raises(ValueError, match="time zone"):
        sign(run, [], "never", datetime(2026, 7, 1))


@given(data=st.data())
def test_any_byte_that_is_changed_is_named(run: Path, data: st.DataObject) -> None:
    """Name the file of any changed byte, in the signed files and in the record itself."""
    name = data.draw(st.sampled_from((*NAMES, RECORD)))
    content = (run / name).read_bytes()
    place = data.draw(st.integers(0, len(content) - 1))
    # Any other byte than the one that stands there: the edit always changes something.
    value = data.draw(st.integers(0, 255).filter(lambda value: value != content[place]))
    try:
        (run / name).write_bytes(content[:place] + bytes([value]) + content[place + 1 :])
        assert name in [finding.name for finding in verify(run)]
        assert all(str(run) in finding.sentence for finding in verify(run))
    finally:
        (run / name).write_bytes(content)
    assert verify(run) == ()


@given(cut=st.integers(0, 10_000))
def test_a_record_that_ends_early_is_named(run: Path, cut: int) -> None:
    content = (run / RECORD).read_bytes()
    try:
        (run / RECORD).write_bytes(content[: cut % len(content)])
        assert [finding.name for finding in verify(run)] == [RECORD]
        # To sign after a cut record would bury the entries that are lost.
        with pytest.raises(RecordError, match=RECORD):
            sign(run, [run / "SD.bin"], "goes on", AT)
    finally:
        (run / RECORD).write_bytes(content)


def test_a_file_that_is_gone_is_named(run: Path) -> None:
    (run / "maneuver.toml").unlink()
    assert list_findings(run) == [("missing", "maneuver.toml")]


def test_a_file_signed_again_counts_as_it_was_last(run: Path) -> None:
    (run / "preflight.json").write_text("GO")
    assert list_findings(run) == [("changed", "preflight.json")]
    sign(run, [run / "preflight.json"], "again", AT + timedelta(hours=1))
    assert verify(run) == ()


def write_entries(run: Path, entries: list[Entry], last: str | None = None) -> None:
    text = format_record(tuple(entries))
    if last is not None:
        text = json.dumps(json.loads(text) | {"last": last}, indent=1) + "\n"
    (run / RECORD).write_text(text)


def test_an_entry_that_was_taken_out_is_told(run: Path) -> None:
    first, _, third = entries_of(run)
    # The third names the hash of the second, which is gone.
    write_entries(run, [first, third])
    assert list_findings(run) == [("changed", RECORD)]
    assert "entry 1 (step 0" in verify(run)[0].sentence


def test_the_first_and_the_last_entry_cannot_go_either(run: Path) -> None:
    first, second, third = entries_of(run)
    # Cut in front: the second names an entry that is not there.
    write_entries(run, [second, third])
    assert ("missing", RECORD) in list_findings(run)
    # Cut behind, with the old last hash kept.
    write_entries(run, [first, second], last=sha256_of_entry(third))
    assert list_findings(run) == [("changed", RECORD)]


def test_an_entry_that_was_put_in_is_told(run: Path) -> None:
    first, second, third = entries_of(run)
    # Chained to the first correctly; the second still names the first, so it stands out.
    forged = Entry(AT, "forged", (), sha256_of_entry(first))
    write_entries(run, [first, forged, second, third])
    assert list_findings(run) == [("inserted", RECORD)]
    assert "entry 2 (forged" in verify(run)[0].sentence
    with pytest.raises(RecordError, match="forged"):
        sign(run, [], "goes on", AT)


def test_an_edit_that_changes_no_value_is_told(run: Path) -> None:
    values = json.loads((run / RECORD).read_text())
    # Same values, other white space: tfsat-host never writes it so.
    (run / RECORD).write_text(json.dumps(values))
    assert list_findings(run) == [("changed", RECORD)]


def test_only_files_of_the_run_are_signed(run: Path) -> None:
    (run.parent / "elsewhere").write_text("x")
    before = (run / RECORD).read_bytes()
    # Outside, absent, a folder, and the record itself.
    for wrong in (run.parent / "elsewhere", run / "absent", run, run / RECORD):
        with pytest.raises(RecordError):
            sign(run, [wrong], "step", AT)
    assert (run / RECORD).read_bytes() == before


def test_a_record_that_names_files_outside_makes_nobody_look_there(run: Path) -> None:
    (run.parent / "secret").write_text("x")
    # A record from elsewhere must not make the program read files of this computer.
    outside = SignedFile("../secret", "0" * 64, 1)
    write_entries(run, [Entry(AT, "hostile", (outside,), "")])
    assert list_findings(run) == [("changed", RECORD)]
    assert "outside" in verify(run)[0].sentence


def test_a_run_may_be_copied(run: Path, tmp_path: Path) -> None:
    shutil.copytree(run, tmp_path / "copy")
    assert verify(tmp_path / "copy") == ()


@given(
    st.lists(
        st.tuples(
            st.datetimes(min_value=datetime(1980, 1, 1), timezones=st.just(UTC)),
            _WORDS,
            st.lists(st.tuples(_WORDS, st.integers(0, 2**70))),
        ),
        max_size=4,
    )
)
def test_whatever_is_written_is_read_back(
    raw_entries: list[tuple[datetime, str, list[tuple[str, int]]]],
) -> None:
    entries: list[Entry] = []
    for at, by, files in raw_entries:
        signed = tuple(SignedFile(name, f"{size:064x}"[-64:], size) for name, size in files)
        entries.append(Entry(at, by, signed, sha256_of_entry(entries[-1]) if entries else ""))
    again, last = parse_record(format_record(tuple(entries)))
    assert list(again) == entries
    assert last == (sha256_of_entry(entries[-1]) if entries else "")


@given(st.text() | st.recursive(st.none() | st.integers() | st.text(), st.lists).map(json.dumps))
def test_no_text_makes_the_reading_of_a_record_fail_otherwise(text: str) -> None:
    with pytest.raises(ValueError):
        parse_record(text)


def _sign_many(folder: Path, who: str, times: int) -> None:
    for number in range(times):
        sign(folder, [folder / "SD.bin"], f"{who} {number}", AT)


def test_programs_at_the_same_time_lose_no_entry(run: Path) -> None:
    # Fresh interpreters: nothing is shared but the file and its lock.
    context = multiprocessing.get_context("spawn")
    programs = [context.Process(target=_sign_many, args=(run, who, 10)) for who in "abc"]
    for program in programs:
        program.start()
    for program in programs:
        program.join()
    assert [program.exitcode for program in programs] == [0, 0, 0]
    authors = [entry.by for entry in entries_of(run)]
    assert sorted(authors[3:]) == sorted(f"{who} {number}" for who in "abc" for number in range(10))
    assert verify(run) == ()
