"""The examples of docs/emulator.md do what they say."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from itertools import groupby
from pathlib import Path

import pytest

from tests.emulated.served import TIMEOUT_S, Served
from tests.paths import DOCS
from tfsat_host.emulated.control import execute
from tfsat_host.emulated.server import RobotServer

PAGE = (DOCS / "emulator.md").read_text(encoding="utf-8")


def _blocks(language: str) -> list[str]:
    blocks = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    assert blocks
    return blocks


def _shell(block: str, folder: Path) -> str:
    """Run `block` in a shell that finds `tfsat-host` and return its standard output."""
    programs = folder / "bin"
    programs.mkdir(exist_ok=True)
    command = programs / "tfsat-host"
    # The page's commands name tfsat-host: a script of that name leads to this checkout.
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m tfsat_host "$@"\n')
    command.chmod(0o755)
    environ = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"}
    process = subprocess.run(
        ["sh", "-e"], input=block, env=environ, capture_output=True, text=True, timeout=TIMEOUT_S, check=False
    )
    assert process.returncode == 0, (block, process.stderr)
    return process.stdout


def _converse(served: Served, lines: list[str]) -> None:
    """Sends the lines marked `>`; each reply must be the line below, where `...` stands for anything."""
    # Lines and replies alternate on the page.
    replies = served.control(*(line.removeprefix("> ") for line in lines[0::2]))
    for line, reply, expected_reply in zip(lines[0::2], replies, lines[1::2], strict=True):
        pattern = ".*".join(re.escape(part) for part in expected_reply.split("..."))
        assert re.fullmatch(pattern, reply), (line, reply)


def test_the_conversation(native: Served) -> None:
    (text,) = _blocks("control")
    _converse(native, text.splitlines())


def test_the_drop_by_hand(native: Served, tmp_path: Path) -> None:
    (text,) = _blocks("drop")
    output = ""
    # Commands and control lines take turns on the page, in this order.
    for is_command, group in groupby(text.splitlines(), key=lambda line: line.startswith("$ ")):
        if is_command:
            output += _shell("\n".join(line.removeprefix("$ ") for line in group), tmp_path)
        else:
            _converse(native, list(group))
    assert re.search(r"^Sequencer: +done\b", output, re.MULTILINE)
    assert re.search(r"^Verdict: +complete", output, re.MULTILINE)


def test_the_shell_examples(native: Served, tmp_path: Path) -> None:
    output = "".join(_shell(block, tmp_path) for block in _blocks("sh"))
    swung = re.search(r"^ok (\S+) 0.00 0.00$", output, re.MULTILINE)
    assert swung and float(swung[1]) == pytest.approx(60.0, abs=1.0)


def test_the_python_examples(native: Served) -> None:
    printed = [
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, timeout=TIMEOUT_S, check=True
        ).stdout.strip()
        for code in _blocks("python")
    ]
    assert printed == ["ok 0.00 0.00 0.00", "2000000"]


def test_every_command_is_in_the_table_and_the_table_is_true(server: RobotServer) -> None:
    rows = re.findall(r"^\| `(\w+)([^`]*)` \| [^|]+ \| `(ok[^`]*)` \|$", PAGE, re.MULTILINE)
    help_reply = execute("help", server)
    assert help_reply is not None
    # The table has every command that `help` names, and no other.
    assert {name for name, _, _ in rows} == {usage.split()[0] for usage in help_reply.text[3:].split(" | ")}
    for name, arguments, _ in rows:
        # These two need a recording and time.
        if name not in ("card", "wait"):
            reply = execute(name + arguments, server)
            assert reply is not None and reply.text.startswith("ok"), (name, reply)
