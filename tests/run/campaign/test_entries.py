"""The index's text: read back without loss, and no text breaks its reader."""

from __future__ import annotations

import json
from datetime import UTC, datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfsat_host.quantity import record
from tfsat_host.run.campaign.entries import (
    ENTRY,
    DropEntry,
    Note,
    folder_name,
    format_drop,
    format_index,
    number_of,
    parse_drop,
    parse_index,
)
from tfsat_host.run.files import ROBOTS

AT = datetime(2026, 7, 1, 9, 30, tzinfo=UTC)
_TEXT = st.text(st.characters(codec="utf-8"))
# Whole milliseconds, as entries store them.
_TIMES = st.datetimes(min_value=datetime(1980, 1, 1), timezones=st.just(UTC)).map(
    lambda at: at.replace(microsecond=at.microsecond // 1000 * 1000)
)
_ENTRIES = st.builds(
    DropEntry,
    number=st.integers(1, 9999),
    recording=st.just("SD.bin"),
    sha256=st.just("0" * 64),
    session=st.none() | st.just("1a2b3c4d"),
    released=st.none() | _TIMES,
    added=_TIMES,
    origin=_TEXT,
    robot=st.sampled_from(ROBOTS),
    notes=st.lists(st.builds(Note, at=_TIMES, text=_TEXT), max_size=3).map(tuple),
    void=st.none() | st.builds(Note, at=_TIMES, text=_TEXT),
)


@given(st.lists(_ENTRIES, max_size=4, unique_by=lambda drop: drop.number))
def test_whatever_is_written_is_read_back(drops: list[DropEntry]) -> None:
    assert list(parse_index(format_index(drops))) == sorted(drops, key=lambda drop: drop.number)
    assert all(parse_drop(format_drop(drop)) == drop for drop in drops)


@given(data=st.data())
def test_a_damaged_entry_is_no_entry(data: st.DataObject) -> None:
    values = record(
        ENTRY, DropEntry(1, "SD.bin", "0" * 64, "1a2b3c4d", AT, AT, "run", "real", (Note(AT, "x"),))
    )
    key = data.draw(st.sampled_from(sorted(values.keys() - {"folder"})))
    # No field of an entry takes a flag, a number below 1 or a list of numbers.
    values[key] = data.draw(st.booleans() | st.integers(max_value=0) | st.lists(st.integers(), min_size=1))
    with pytest.raises(ValueError):
        parse_drop(json.dumps(values))
    del values[key]
    if key == "robot":  # added by a program that did not tell
        assert parse_drop(json.dumps(values)).robot == "unknown"
        return
    with pytest.raises(ValueError):
        parse_drop(json.dumps(values))


@pytest.mark.parametrize("name", ["../SD.bin", "/etc/passwd", "a\\b", "..", "", "C:x"])
def test_an_index_names_no_file_outside(name: str) -> None:
    values = record(ENTRY, DropEntry(1, "SD.bin", "0" * 64, None, None, AT, "run"))
    with pytest.raises(ValueError, match="no file's name"):
        parse_drop(json.dumps({**values, "recording": name}))


def test_a_drop_is_in_an_index_once() -> None:
    drop = DropEntry(1, "SD.bin", "0" * 64, None, None, AT, "run")
    with pytest.raises(ValueError, match="twice"):
        parse_index(format_index([drop, drop]))


@given(st.integers(1, 9999))
def test_a_folder_name_gives_its_number_and_no_other_name_does(number: int) -> None:
    assert number_of(folder_name(number)) == number
    # Zero, too short, too long, other case, a suffix, and digits that are not ASCII.
    for other in ("drop-0000", "drop-1", "drop-00001", "Drop-0001", "drop-0001x", "drop-٠٠٠١"):
        assert number_of(other) is None
