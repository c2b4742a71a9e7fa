"""The one writer: what is read back is what was written, and people can read it."""

from __future__ import annotations

import math
import tomllib
from datetime import UTC, datetime, timedelta, timezone

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tfsat_host.config import format_config

KEYS = st.text("abcdefghijklmnopqrstuvwxyz_", min_size=1, max_size=8)
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
    text = format_config({"a": np.float64(0.1), "b": [np.float64(-0.0), math.inf], "c": 5e-324})
    assert text == "a = 0.1\nb = [-0.0, inf]\nc = 5e-324\n"


def test_how_it_looks() -> None:
    values = {
        "format": 1,
        "left_out": None,
        "at": datetime(2026, 7, 1, 11, 30, tzinfo=timezone(timedelta(hours=2))),
        "joint": [{"number": 1, "servo": {"rate": 2.0, "limits": {"low": 0, "high": [1]}}}, {"number": 2}],
        "rows": [[1, 2], [3, 4]],
        "none": [],
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
