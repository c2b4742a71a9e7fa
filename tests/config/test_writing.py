"""What is read back is what was written, and people can read it; the line of an entry, however the file is written."""

from __future__ import annotations

import math
import tomllib
from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tfsat_host.config import format_config
from tfsat_host.config.places import Path, line_of

KEYS = st.text("abcdefghijklmnopqrstuvwxyz_", min_size=1, max_size=8)
# TOML's integers have 64 bits; NaN equals nothing and could not be compared.
NUMBERS = st.floats(allow_nan=False) | st.integers(-(2**63), 2**63 - 1)
VALUES = (
    NUMBERS | st.booleans() | st.text(st.characters(codec="utf-8")) | st.datetimes(timezones=st.just(UTC))
)
ROWS = st.lists(st.lists(NUMBERS, min_size=1, max_size=3), min_size=1, max_size=3)
ENTRIES = VALUES | st.lists(NUMBERS, max_size=3) | ROWS
TABLES = st.dictionaries(KEYS, ENTRIES | st.dictionaries(KEYS, VALUES, max_size=3), max_size=3)


@given(st.dictionaries(KEYS, ENTRIES | TABLES | st.lists(TABLES, max_size=3), max_size=4))
def test_what_is_read_is_what_was_written(values: dict[str, object]) -> None:
    assert tomllib.loads(format_config(values)) == values


def test_floats_of_numpy_and_numbers_beyond_all_limits() -> None:
    # The sign of zero and the least denormal survive: repr() writes the shortest digits that do.
    text = format_config({"a": np.float64(0.1), "b": [np.float64(-0.0), math.inf], "c": 5e-324})
    assert text == "a = 0.1\nb = [-0.0, inf]\nc = 5e-324\n"


def test_the_layout_of_a_written_file() -> None:
    values = {
        "format": 1,
        "left_out": None,
        "at": datetime(2026, 7, 1, 11, 30, tzinfo=timezone(timedelta(hours=2))),
        "joint": [{"number": 1, "servo": {"rate": 2.0, "limits": {"low": 0, "high": [1]}}}, {"number": 2}],
        "rows": [[1, 2], [3, 4]],
        "none": [],
        # Tab and DEL are escaped; a line separator is not, as TOML ends lines by line feeds alone.
        "frame": {"x": "a\tb\x7f\u2028é"},
    }
    assert (
        format_config(values, heading="an arm\nof two joints", comments={"number": "from 1"})
        == """\
# an arm
# of two joints
format = 1
at = 2026-07-01T09:30:00Z
rows = [
    [1, 2],
    [3, 4],
]
none = []

[[joint]]
number = 1  # from 1

[joint.servo]
rate = 2.0
limits = { low = 0, high = [1] }

[[joint]]
number = 2  # from 1

[frame]
x = "a\\tb\\u007F\u2028é"
"""
    )


# Whatever looks like a header and is none: in a comment, in texts of several lines, in an array.
TEXT = '''# [[body]] of a comment = 1
title = """\u2028\x85
[[body]]
name = "no entry" """
rows = [
  [1],
  [2],
]
"top.key" = 1

[["body"]]   # quoted
'name' = "first]"
mass_kg = 1
inertia.xx = 1
inertia.yy = 2

[[ body ]]
name = "second"
mass_kg = 2
[ body . 'inertia' ]
xx = 3

[last]
mass_kg = 3
legs = [
  { length_m = 1 },
  { length_m = 2 },
]
verse = \'\'\'
[[body]] isn't [
\'\'\'
end = 1
'''


def test_the_text_is_what_the_parser_takes() -> None:
    # The expected lines below are worth something only if the parser reads the text so.
    parsed = tomllib.loads(TEXT)
    assert [body["mass_kg"] for body in parsed["body"]] == [1, 2]
    assert [body["inertia"]["xx"] for body in parsed["body"]] == [1, 3]


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("title",), 2),
        (("rows",), 5),
        # Not there at the top: `name` occurs only inside of tables.
        (("name",), 1),
        (("top.key",), 9),
        (("body",), 11),
        (("last",), 23),
        (("body", 0, "name"), 12),
        (("body", 0, "mass_kg"), 13),
        (("body", 0, "inertia"), 14),
        (("body", 0, "inertia", "yy"), 15),
        # Missing entries get the line of the nearest table that holds them.
        (("body", 0, "inertia", "zz"), 14),
        (("body", 0, "missing"), 11),
        (("body", 1, "name"), 18),
        (("body", 1, "inertia"), 20),
        (("body", 1, "inertia", "xx"), 21),
        (("body", 1, "inertia", "missing"), 20),
        (("body", 1, "missing"), 17),
        (("last", "mass_kg"), 24),
        (("last", "legs", 1, "length_m"), 25),
        (("last", "end"), 32),
        (("absent", 0, "name"), 1),
    ],
)
def test_an_entry_is_found_where_it_stands(path: Path, line: int) -> None:
    assert line_of(TEXT, path) == line
