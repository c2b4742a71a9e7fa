"""Values of edited or damaged JSON files: what they should be, or refused with the value named."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime

import pytest

from tfsat_host import json_values

HASH, SESSION = "0123456789abcdef" * 4, "00c0ffee"


def test_what_is_right_passes() -> None:
    assert json_values.text("") == ""
    assert json_values.text("wind", empty=False) == "wind"
    assert json_values.sha256(HASH) == HASH
    assert json_values.session_id(SESSION) == SESSION
    assert json_values.byte_count(0) == 0
    assert json_values.moment("2026-07-01T11:30:00+02:00") == datetime(2026, 7, 1, 9, 30, tzinfo=UTC)
    assert json_values.moment("2026-07-01T09:30:00Z").tzinfo is UTC


@pytest.mark.parametrize(
    ("read", "value"),
    [
        *((json_values.text, value) for value in (None, 5, ["wind"])),
        (lambda value: json_values.text(value, empty=False), ""),
        *(
            (json_values.sha256, value)
            for value in (None, "", HASH[1:], HASH + "0", HASH.upper(), f"{HASH}\n")
        ),
        *((json_values.session_id, value) for value in (None, 12, "c0ffee", "00C0FFEE", f"{SESSION}\n")),
        *((json_values.byte_count, value) for value in (None, True, -1, 1.0, "1")),
        *((json_values.moment, value) for value in (None, 5, "yesterday", "2026-07-01T09:30:00")),
    ],
)
def test_anything_else_is_refused_and_named(read: Callable[[object], object], value: object) -> None:
    with pytest.raises(ValueError) as caught:
        read(value)
    assert (repr(value) if value != "yesterday" else "yesterday") in str(caught.value)
