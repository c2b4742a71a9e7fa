"""The two streams, JSON, colour and questions."""

from __future__ import annotations

import ast
import io
import json
import math
import os
import re
import subprocess
from enum import IntEnum, StrEnum
from pathlib import Path

import numpy as np
import pytest

from tests.paths import HOST, REPOSITORY
from tfsat_host.errors import RefusedError, TfsatError, UsageError
from tfsat_host.present.output import Output

ERROR = TfsatError(what="A.", meaning="B.", next_step="C.")


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_json_is_one_object_with_plain_values() -> None:
    class Number(IntEnum):
        ONE = 1

    class Word(StrEnum):
        GOOD = "good"

    stdout = io.StringIO()
    out = Output(json_mode=True, stdout=stdout, stderr=io.StringIO())
    out.line("not shown")
    out.table(("a",), [(1,)])
    out.result(
        {
            "enum": [Number.ONE, Word.GOOD],
            "path": Path("a") / "b",
            "numpy": [np.float64(1.5), np.int32(2), np.array([[1.0, math.nan]])],
            "none": None,
            "true": True,
            "inf": math.inf,
            "tuple": (1, "é"),
        },
        "not shown",
    )
    assert json.loads(stdout.getvalue()) == {
        "enum": [1, "good"],
        "path": str(Path("a") / "b"),
        "numpy": [1.5, 2, [[1.0, None]]],
        "none": None,
        "true": True,
        "inf": None,
        "tuple": [1, "é"],
    }
    assert stdout.getvalue().count("\n") == 1


def test_a_second_result_is_a_mistake_of_the_command() -> None:
    out = Output(stdout=io.StringIO())
    out.result({}, "done")
    with pytest.raises(RuntimeError):
        out.result({}, "done")


def test_an_error_after_the_json_result_goes_to_stderr() -> None:
    stdout, stderr = io.StringIO(), io.StringIO()
    out = Output(json_mode=True, stdout=stdout, stderr=stderr)
    out.result({"a": 1})
    assert out.error(ERROR) == 1
    assert json.loads(stdout.getvalue()) == {"a": 1}
    assert "A." in stderr.getvalue()


def test_colour_only_on_a_terminal_that_wants_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR")
    monkeypatch.setenv("TERM", "xterm")
    terminal, pipe = Terminal(), io.StringIO()
    Output(stderr=terminal).error(ERROR)
    Output(stderr=pipe).error(ERROR)
    assert "\x1b[" in terminal.getvalue()
    assert "\x1b[" not in pipe.getvalue()
    monkeypatch.setenv("NO_COLOR", "1")
    quiet = Terminal()
    Output(stderr=quiet).error(ERROR)
    assert "\x1b[" not in quiet.getvalue()


def test_a_table_keeps_markup_and_long_words_as_they_are() -> None:
    stdout = io.StringIO()
    Output(stdout=stdout).table(("name", "value"), [("[bold]x[/bold]", 1.5), ("y" * 60, 20)])
    assert "[bold]x[/bold]" in stdout.getvalue()
    assert "y" * 60 in stdout.getvalue()


@pytest.mark.parametrize("answer", ["y\n", "YES\n", " yes \n"])
def test_yes_is_yes(answer: str) -> None:
    stdin, stderr = Terminal(answer), io.StringIO()
    Output(stdin=stdin, stderr=stderr).confirm("Arm?", meaning="It moves.")
    assert "Arm?" in stderr.getvalue()


@pytest.mark.parametrize("answer", ["n\n", "\n", "", "yess\n"])
def test_anything_else_refuses(answer: str) -> None:
    with pytest.raises(RefusedError):
        Output(stdin=Terminal(answer), stderr=io.StringIO()).confirm("Arm?", meaning="It stays.")


def test_without_a_terminal_only_the_option_answers() -> None:
    with pytest.raises(UsageError, match="No terminal"):
        Output(stdin=io.StringIO("y\n"), stderr=io.StringIO()).confirm("Arm?", meaning="It stays.")
    Output(yes=True, stdin=io.StringIO(), stderr=io.StringIO()).confirm("Arm?", meaning="It moves.")


def test_progress_goes_to_stderr_and_never_into_json() -> None:
    for json_mode, progress_text in ((False, "Writing …\n"), (True, "")):
        stdout, stderr = io.StringIO(), io.StringIO()
        with Output(json_mode=json_mode, stdout=stdout, stderr=stderr).progress("Writing", 3) as advance:
            advance(1)
        assert (stdout.getvalue(), stderr.getvalue()) == ("", progress_text)


def test_progress_on_a_terminal_ends_with_the_work() -> None:
    terminal = Terminal()
    with Output(stderr=terminal).progress("Writing", 3) as advance:
        advance(3)
    assert "Writing" in terminal.getvalue()


def announced_by_make(environ: dict[str, str], stdout: int) -> None:
    """Has the Makefile announce "a step (of it)"."""
    rule = "include Makefile\nannounce:\n\t$(call say,a step (of it))\n"
    environ = {"PATH": os.environ["PATH"], "TERM": "xterm", **environ}
    command = ["make", "--no-print-directory", "-f", "-", "announce"]
    subprocess.run(command, input=rule.encode(), cwd=REPOSITORY, env=environ, stdout=stdout, check=True)


def test_make_is_bold_only_on_a_terminal(tmp_path: Path) -> None:
    with (tmp_path / "x").open("wb") as file:
        announced_by_make({}, file.fileno())
    assert (tmp_path / "x").read_bytes() == b"== a step (of it)\n"
    for environ, bold in (({}, True), ({"NO_COLOR": "1"}, False), ({"CI": "1"}, False)):
        ours, terminal = os.openpty()
        announced_by_make(environ, terminal)
        terminal_output = os.read(ours, 1000)
        os.close(terminal)
        os.close(ours)
        assert b"== a step (of it)" in terminal_output
        assert (b"\x1b[1m" in terminal_output) is bold


def test_what_a_campaign_leaves_is_not_committed(tmp_path: Path) -> None:
    (tmp_path / ".gitignore").write_text((REPOSITORY / ".gitignore").read_text())
    subprocess.run(["git", "init", "-q", str(tmp_path)], check=True)
    campaign_files = [
        "calibration.toml",
        "calibration-emulated-recordings/rest.npz",
        "robot/SD.bin",
        "run/SD.csv",
    ]
    ours = ["host/tfsat_host/robot/model.py", "robots/drop_tower.toml"]
    command = ["git", "check-ignore", *campaign_files, *ours]
    process = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert process.stdout.split() == campaign_files


_COLUMNS = ("parameter", "value", "unit", "derivative of the reorientation / (deg / unit)", "gives / deg")
_ROWS = [
    ("body 3 principal moment", "0.001234", "kg m^2", "+0.3453", "0.234"),
    ("stroke 2 end (joint 2)", "70", "deg", "-0.9876", "0.987"),
]


@pytest.mark.parametrize("width", [40, 60, 80, 100, 200])
def test_a_table_breaks_no_word(width: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    terminal = Terminal()
    Output(stdout=terminal).table(_COLUMNS, _ROWS, title="All of them")
    table_text = re.sub("\x1b\\[[0-9;]*m", "", terminal.getvalue())
    assert max(map(len, table_text.splitlines())) <= width
    for text in (*_COLUMNS, *(cell for row in _ROWS for cell in row), "All of them"):
        for word in text.split():
            assert word in table_text.split()


def test_a_table_too_wide_for_the_terminal_is_a_block_for_each_row(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "50")
    terminal = Terminal()
    Output(stdout=terminal).table(("one" * 10, "two", "three" * 4), [("a b", 1, "c"), ("d", 2, "e")])
    blocks = [block.splitlines() for block in re.split(r"\n *\n", terminal.getvalue().rstrip())]
    assert [[line.split() for line in block] for block in blocks] == [
        [["one" * 10, "a", "b"], ["two", "1"], ["three" * 4, "c"]],
        [["one" * 10, "d"], ["two", "2"], ["three" * 4, "e"]],
    ]


def test_what_would_steer_the_terminal_is_written_as_escapes() -> None:
    """Escape terminal control characters in names of robots and files.

    They are ESC, BEL, the C1 form of CSI, and controls that change the writing direction.
    """
    evil = "a\x1b[2J\x07\x9b1m\u202eb\u2066c\r"
    streams = io.StringIO(), io.StringIO()
    out = Output(stdout=streams[0], stderr=streams[1], stdin=Terminal("n\n"))
    out.line(evil)
    out.note(evil)
    out.warn(f"{evil}\nnext line")
    out.error(TfsatError(what=evil, meaning=evil, next_step=f"{evil}\nnext line"))
    out.table((evil,), [(evil,)], title=evil)
    out.result({}, evil)
    with pytest.raises(RefusedError):
        out.confirm(evil, meaning="")
    with out.progress(evil):
        pass
    for stream in streams:
        text = stream.getvalue()
        assert text.count("a\\x1b[2J\\x07\\x9b1m\\u202eb\\u2066c\\r") >= 4
        assert all(map(str.isprintable, text.split("\n")))
    assert "\nnext line" in streams[1].getvalue() and "\n  next line" in streams[1].getvalue()


def test_no_text_for_people_has_the_name_of_a_class() -> None:
    """Use no class names in texts for people.

    A renamed class once changed a printed "Result: preflight.json".
    """
    trees = [ast.parse(path.read_text(encoding="utf-8")) for path in HOST.rglob("*.py")]
    nodes = [node for tree in trees for node in ast.walk(tree)]
    names = {node.name for node in nodes if isinstance(node, ast.ClassDef)}
    names = {name for name in names if len(re.findall("[A-Z][a-z]+", name)) > 1}
    formatted = [part for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values]
    texts = [
        part.value for part in formatted if isinstance(part, ast.Constant) and isinstance(part.value, str)
    ]
    assert len(texts) > 2000 and len(names) > 200
    # A repr has the class's name on purpose.
    user_texts = [text for text in texts if not text.startswith("<")]
    assert [text for text in user_texts if names & set(re.findall(r"\w+", text))] == []
