"""The line of an entry, however the file is written."""

from __future__ import annotations

import tomllib

import pytest

from tfsat_host.config.table import Path, line_of

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
    parsed = tomllib.loads(TEXT)
    assert [body["mass_kg"] for body in parsed["body"]] == [1, 2]
    assert [body["inertia"]["xx"] for body in parsed["body"]] == [1, 3]


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("title",), 2),
        (("rows",), 5),
        (("name",), 1),
        (("top.key",), 9),
        (("body",), 11),
        (("last",), 23),
        (("body", 0, "name"), 12),
        (("body", 0, "mass_kg"), 13),
        (("body", 0, "inertia"), 14),
        (("body", 0, "inertia", "yy"), 15),
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
