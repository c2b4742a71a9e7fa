"""The one reader: each wrong entry is named with file, line, entry, what was expected and a cure."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from enum import StrEnum
from pathlib import Path

import numpy as np
import pytest

from tfsat_host.config import ConfigKind, Fault, Table, parse_config, read_config
from tfsat_host.errors import TfsatError

# Each type of entry once; errors name lines, so the text keeps its order.
TEXT = """\
format = 1
name = "arm"
empty = ""
length_m = 2
share = 0.5
count = 3
side = "left"
fast = true
at = 2026-07-01T11:30:00+02:00
corner_m = [1, 2.5, -3]
rows = [
  [1, 2],
  [3, 4],
]
inside = { x = 1 }

[[joint]]
number = 2
[joint.servo]
rate = 10

[[joint]]
number = 1
servo.rate = 20
"""


class CodedError(TfsatError):
    """As the errors that scripts tell apart."""


class Own(StrEnum):
    """A code of one kind of file."""

    WRONG_FORMAT = "wrong-format"


KIND = ConfigKind(
    "arm file", CodedError, "No arm.", "Start from scratch.", codes={Fault.FORMAT: Own.WRONG_FORMAT}
)
Read = Callable[[Table], object]


def expect_refusal(read: Read, text: str, kind: ConfigKind = KIND) -> CodedError:
    with pytest.raises(CodedError) as caught:
        read(parse_config(text, "arm.toml", kind))
    assert caught.value.meaning == "No arm."
    assert caught.value.next_step
    assert len(caught.value.what) < 300
    return caught.value


def test_each_type_is_read_as_written() -> None:
    top = parse_config(TEXT, "arm.toml", KIND)
    assert (top.text("name"), top.text("empty", empty=True), top.text("absent", "none")) == (
        "arm",
        "",
        "none",
    )
    assert (top.number("length_m"), top.number("absent", 7.0), top.integer("count", 1, 3)) == (2.0, 7.0, 3)
    assert (top.choice("side", ("left", "right")), top.choice("count", (1, 3))) == ("left", 3)
    assert top.flag("fast") is True
    # Written with an offset, held in UTC: times of several files can be compared.
    assert top.time("at") == datetime(2026, 7, 1, 9, 30, tzinfo=UTC) and top.time("at").tzinfo is UTC
    assert top.numbers("corner_m", 3) == [1.0, 2.5, -3.0]
    assert np.array_equal(top.array("rows", 2, 2), [[1, 2], [3, 4]])
    assert np.array_equal(top.array("rows", -1, 2), [[1, 2], [3, 4]])
    assert top.table("inside", "x").number("x") == 1.0
    assert [joint.table("servo").number("rate") for joint in top.tables("joint")] == [10.0, 20.0]
    # Joint 2 stands first in the text: the number counts, not the order.
    assert list(top.tables_by_number("joint", "number", 2)) == [1, 2]
    assert top.tables("absent") == [] and not top.has("absent")


def servo_rate(top: Table) -> float:
    return top.tables("joint")[1].table("servo").number("rate", above=0)


def servo_of(joint: Table) -> float:
    return joint.table("servo").number("rate", above=0)


def joints_by_number(top: Table) -> dict[int, Table]:
    return top.tables_by_number("joint", "number", 2)


@pytest.mark.parametrize(
    ("old", "new", "read", "what"),
    [
        ('"arm"', "3", lambda top: top.text("name"), "2: name: 3 is not a text in quotes"),
        ('"arm"', '""', lambda top: top.text("name"), "2: name: '' is not a text"),
        # TOML has nan and inf; a flag is a number in Python; none of them is a length.
        ("= 2\n", "= nan\n", lambda top: top.number("length_m"), "4: length_m: nan is not a finite number"),
        ("= 2\n", "= inf\n", lambda top: top.number("length_m"), "4: length_m: inf is not"),
        ("= 2\n", "= true\n", lambda top: top.number("length_m"), "4: length_m: true is not"),
        ("= 2\n", "= '2'\n", lambda top: top.number("length_m"), "4: length_m: '2' is not"),
        # Beyond any float, and beyond what Python prints in decimal (4300 digits).
        ("= 2\n", f"= 1{'0' * 400}\n", lambda top: top.number("length_m"), "4: length_m: 1000"),
        ("= 2\n", f"= 0x{'f' * 9000}\n", lambda top: top.number("length_m"), "4: length_m: what stands there is"),
        ("= 2\n", "= 0\n", lambda top: top.number("length_m", above=0), "4: length_m: 0 is not a number above 0"),
        ("= 0.5", "= -1", lambda top: top.number("share", least=0), "5: share: -1 is not a number of at least 0"),
        (
            "= 0.5",
            "= 2",
            lambda top: top.number("share", least=0, most=1),
            "5: share: 2 is not a number of at least 0 and of at most 1",
        ),
        # Equal to 3, but whoever writes 3.0 joints has another entry in mind.
        ("= 3", "= 3.0", lambda top: top.integer("count"), "6: count: 3.0 is not a whole number"),
        ("= 3", "= true", lambda top: top.integer("count"), "6: count: true is not a whole number"),
        ("= 3", "= 4", lambda top: top.integer("count", 1, 3), "6: count: 4 is not a whole number from 1 to 3"),
        ("= 3", "= 2", lambda top: top.choice("count", (1, 3)), "6: count: 2 is not 1 or 3"),
        ("= 3", "= true", lambda top: top.choice("count", (1, 3)), "6: count: true is not 1 or 3"),
        ('"left"', '"up"', lambda top: top.choice("side", ("left",)), "7: side: 'up' is not 'left'"),
        ('"left"', '"up"', lambda top: top.choice("side", ()), "7: side: 'up' is not one of none"),
        ("= true", "= 1", lambda top: top.flag("fast"), "8: fast: 1 is not true or false"),
        # Without a zone a time means another moment on each computer.
        ("11:30:00+02:00", "11:30:00", lambda top: top.time("at"), "9: at: 2026-07-01T11:30:00 is not a time with"),
        ("T11:30:00+02:00", "", lambda top: top.time("at"), "9: at: 2026-07-01 is not a time with its zone"),
        ("2.5, -3]", "2.5]", lambda top: top.numbers("corner_m", 3), "10: corner_m: [1, 2.5] is not 3 finite"),
        ("2.5, -3]", "nan, 3]", lambda top: top.numbers("corner_m", 3), "10: corner_m: [1, nan, 3] is not 3"),
        ("[3, 4]", "[3, 4, 5]", lambda top: top.array("rows", 2, 2), "11: rows: [[1, 2], [3, 4, 5]] is not 2 x 2"),
        ("[3, 4]", "3", lambda top: top.array("rows", -1, 2), "11: rows: [[1, 2], 3] is not n x 2 finite"),
        ("{ x = 1 }", "{ x = '1' }", lambda top: top.table("inside").number("x"), "15: inside.x: '1' is not"),
        ("{ x = 1 }", "{ x = 1, y = 2 }", lambda top: top.table("inside", "x"), "15: inside.y: is not known here"),
        ("{ x = 1 }", "1", lambda top: top.table("inside"), "15: inside: 1 is not a table"),
        # Tables are named by their place in the file, or by their number where that is known.
        ("rate = 20", "rate = 0", servo_rate, "24: joint 2, servo.rate: 0 is not a number above 0"),
        ("servo.rate = 20", "", servo_rate, "22: joint 2, servo: is missing"),
        (
            "rate = 20",
            "rate = 0",
            lambda top: servo_of(joints_by_number(top)[1]),
            "24: joint of number 1, servo.rate: 0",
        ),
        ("number = 1", "number = 2", joints_by_number, "23: joint 2, number: number 2 is described"),
        ("number = 1", "number = 3", joints_by_number, "23: joint 2, number: 3 is not"),
        (
            "",
            "",
            lambda top: top.tables_by_number("joint", "number", 3),
            "17: joint: there is no [[joint]] of number 3",
        ),
        # The text as it is: what is asked of it does not fit.
        ("", "", lambda top: top.tables("fast"), "8: fast: true is not tables, each below its own line [[fast]]"),
        ("", "", lambda top: top.tables("leg", needed=True), "1: leg: is missing"),
        ("", "", lambda top: top.only("format name"), "3: empty: is not known here"),
        ("format = 1\n", "", lambda top: top, "1: format: is missing"),
        ("format = 1", "format = 2", lambda top: top, "1: format: 2 is not 1"),
        # Equal to 1 in Python: another format must not pass.
        ("format = 1", "format = 1.0", lambda top: top, "1: format: 1.0 is not 1"),
    ],
)  # fmt: skip
def test_a_wrong_entry_is_named_with_its_line(old: str, new: str, read: Read, what: str) -> None:
    # An edit that changes nothing would test the unchanged text.
    assert TEXT.replace(old, new, 1) != TEXT or not old
    assert expect_refusal(read, TEXT.replace(old, new, 1)).what.startswith(f"arm.toml:{what}")


@pytest.mark.parametrize(
    ("read", "cure", "code"),
    [
        (lambda top: top.number("name"), "Give `name` a finite number.", Fault.WRONG_TYPE),
        (lambda top: top.number("name", requirement="metres, such as 2"), "Give `name` metres, such as 2.",
         Fault.WRONG_TYPE),
        (lambda top: top.number("width_m"), "Add `width_m`: a finite number.", Fault.MISSING_KEY),
        (lambda top: top.only("format name"), "Remove it or correct its name; known are: format, name.",
         Fault.UNKNOWN_KEY),
        (lambda top: top.fail("name", "is odd"), "Start from scratch.", Fault.WRONG_TYPE),
    ],
)  # fmt: skip
def test_each_error_has_a_cure_and_a_code(read: Read, cure: str, code: Fault) -> None:
    error = expect_refusal(read, TEXT)
    assert (error.next_step, error.code) == (cure, code)


def test_a_file_that_a_program_writes_is_not_to_be_corrected_by_hand() -> None:
    computed = ConfigKind("arm file", CodedError, "No arm.", "Start from scratch.", codes={}, computed=True)
    for read in (lambda top: top.number("name"), lambda top: top.number("width_m")):
        assert expect_refusal(read, TEXT, computed).next_step == "Start from scratch."


def test_a_kind_has_its_own_codes_or_none() -> None:
    assert expect_refusal(lambda top: top, "format = 2").code is Own.WRONG_FORMAT
    plain = ConfigKind("arm file", TfsatError, "No arm.", "Start from scratch.", format=None)
    with pytest.raises(TfsatError, match="length_m: is missing"):
        parse_config("", "arm.toml", plain).number("length_m")


@pytest.mark.parametrize(
    ("data", "code", "what"),
    [
        (None, Fault.UNREADABLE, "The arm file {} cannot be read: No such file or directory."),
        (b"\xff\xfe\x00", Fault.NOT_TEXT, "The arm file {} cannot be read: it is not UTF-8 text."),
        # One byte above the limit of 4 MB: a recording given by mistake is not read into memory.
        (b"#" * 4_000_001, Fault.SYNTAX, "{}: this is no arm file: it is too large."),
        (b"format = = 1", Fault.SYNTAX, "{}: is not valid TOML: Invalid value (at line 1, column 10)."),
        (b"a = 1\na = 2", Fault.SYNTAX, "{}: is not valid TOML: Cannot overwrite a value (at "),
        # More digits than Python turns into a number (4300), and nesting beyond its recursion limit.
        (b"\nx = 1" + b"0" * 5000, Fault.SYNTAX, "{}: has a number of thousands of digits (at line 2)."),
        (b"x = " + b"[" * 5000, Fault.SYNTAX, "{}: is nested too deeply: "),
        (b"x = " + b"{a=" * 5000, Fault.SYNTAX, "{}: is nested too deeply: "),
    ],
)
def test_a_file_of_another_kind_is_refused(
    tmp_path: Path, data: bytes | None, code: Fault, what: str
) -> None:
    path = tmp_path / "arm.toml"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(CodedError) as caught:
        read_config(path, KIND)
    assert caught.value.code == code
    assert caught.value.what.startswith(what.format(path))
    assert (caught.value.meaning, caught.value.next_step) == ("No arm.", "Start from scratch.")
    # A folder in place of the file.
    with pytest.raises(CodedError, match="cannot be read"):
        read_config(tmp_path, KIND)


# Notepad: a byte order mark in front, CR LF at the ends of lines.
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig"])
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_files_of_windows_editors_are_read_and_their_lines_counted(
    tmp_path: Path, encoding: str, newline: str
) -> None:
    path = tmp_path / "arm.toml"
    path.write_text(TEXT, encoding=encoding, newline=newline)
    with pytest.raises(CodedError, match=r":24: joint 2, servo\.rate: is odd"):
        read_config(path, KIND).tables("joint")[1].fail("servo.rate", "is odd")
    text = TEXT.replace("\n", newline)
    with pytest.raises(CodedError, match=r":24: joint 2, servo\.rate: is odd"):
        parse_config(text, "arm.toml", KIND).tables("joint")[1].fail("servo.rate", "is odd")
