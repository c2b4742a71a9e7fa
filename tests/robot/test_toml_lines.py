"""The line of an entry, however the file is written."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from tfsat_host.robot import RobotFileError, default_robot_path, load_robot
from tfsat_host.toml_lines import has_header, line_of

TEXT = '''# [[body]] of a comment = 1
title = """
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
[body."inertia"]
xx = 3

[last]
mass_kg = 3
'''


def test_the_text_is_what_the_parser_takes() -> None:
    parsed = tomllib.loads(TEXT)
    assert [body["mass_kg"] for body in parsed["body"]] == [1, 2]
    assert [body["inertia"]["xx"] for body in parsed["body"]] == [1, 3]


@pytest.mark.parametrize(
    ("table", "index", "key", "line"),
    [
        ("", 0, "title", 2),
        ("", 0, "rows", 5),
        ("", 0, "name", 1),
        ("", 0, "body", 11),
        ("", 0, "last", 23),
        ("body", 0, "name", 12),
        ("body", 0, "mass_kg", 13),
        ("body", 0, "inertia", 14),
        ("body", 0, "inertia.yy", 15),
        ("body", 0, "inertia.zz", 14),
        ("body", 0, "missing", 11),
        ("body", 1, "name", 18),
        ("body", 1, "inertia", 20),
        ("body", 1, "missing", 17),
        ("body.inertia", 1, "xx", 21),
        ("body.inertia", 1, "missing", 20),
        ("last", 0, "mass_kg", 24),
        ("body", 2, "name", None),
        ("nobody", 0, "name", None),
    ],
)
def test_an_entry_is_found_where_it_stands(table: str, index: int, key: str, line: int | None) -> None:
    assert line_of(TEXT, table, index, key) == line


def test_each_table_of_a_list_may_have_its_own_header_for_what_is_inside() -> None:
    assert not has_header(TEXT, "body.inertia", 0)
    assert has_header(TEXT, "body.inertia", 1)


DROP_TOWER = default_robot_path().read_text(encoding="utf-8")


def line_of_mistake(folder: Path, text: str) -> str:
    file = folder / "robot.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(RobotFileError) as caught:
        load_robot(file)
    return text.split("\n")[int(caught.value.what.removeprefix(f"{file}:").split(":")[0]) - 1]


def test_a_quoted_header_is_a_header(tmp_path: Path) -> None:
    quoted = DROP_TOWER.replace("[[body]]", '[["body"]]').replace("[joint.servo]", "[ joint . 'servo' ]")
    assert line_of_mistake(tmp_path, quoted.replace("mass_kg = 0.735", "mass_kg = -1", 1)) == "mass_kg = -1"
    assert (
        line_of_mistake(tmp_path, quoted.replace("start_deg = 0.0", "start_deg = 91", 1)) == "start_deg = 91"
    )


def test_of_tables_in_one_line_that_line_is_named(tmp_path: Path) -> None:
    text = """format = 1
name = "inline"
base = "a"
inertia_off_diagonals = "tensor"
body = [
  { name = "a", mass_kg = -1, origin_mm = [0, 0, 0], com_mm = [0, 0, 0], inertia_g_m2 = { xx = 1 } },
]
"""
    assert line_of_mistake(tmp_path, text) == "body = ["


def test_lines_are_counted_as_editors_count_them(tmp_path: Path) -> None:
    text = DROP_TOWER.replace('name = "', 'name = "\u2028\x85', 1).replace(
        "mass_kg = 0.735", "mass_kg = -1", 1
    )
    assert line_of_mistake(tmp_path, text) == "mass_kg = -1"
