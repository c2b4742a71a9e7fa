"""What the documents tell people to type is understood."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.docs.documents import DOCUMENTS, GUIDE, Typed, code_lines, typed_in_code, typed_inline
from tests.paths import REPOSITORY
from tfsat_host.cli.commands import HELPS
from tfsat_host.cli.parser import parser_with
from tfsat_host.errors import TfsatError

NAMES = set(HELPS)


def _refusal(command: Typed) -> str | None:
    """Return the command line parser's refusal of the line, or None if it accepts it."""
    arguments = command.arguments
    parser, _ = parser_with({word for word in arguments if word in NAMES})
    try:
        parser.parse_args(arguments)
    except TfsatError as error:
        return f"{command}\n  {error.what}"
    except SystemExit:  # --help and --version are understood, too
        return None
    return None


def _list_refusals(lines: list[Typed]) -> str:
    return "\n".join(filter(None, map(_refusal, lines)))


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(REPOSITORY).as_posix())
def test_every_command_line_in_code_parses(document: Path) -> None:
    assert _list_refusals(typed_in_code(document)) == ""


def test_there_are_command_lines_to_parse() -> None:
    # A pattern that finds nothing would let every page pass.
    assert sum(len(typed_in_code(document)) for document in DOCUMENTS) > 80
    assert len(typed_inline(GUIDE / "runbook.md")) > 20


def test_every_command_of_the_runbook_parses() -> None:
    assert _list_refusals(typed_inline(GUIDE / "runbook.md")) == ""


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.relative_to(REPOSITORY).as_posix())
def test_every_command_named_in_a_sentence_exists(document: Path) -> None:
    named = {command.arguments[0]: command for command in typed_inline(document)}
    assert [str(command) for name, command in named.items() if name not in NAMES and name[0] != "-"] == []


@pytest.mark.parametrize(
    "line",
    # An unknown action, a misspelt option, a missing argument, a shell without completion.
    [
        "tfsat-host record begin",
        "$ tfsat-host upload-sequence 59 70 --fille maneuver.toml",
        ".venv/bin/tfsat-host decode",
        "tfsat-host completion tcsh > file",
    ],
)
def test_a_wrong_line_would_be_found(line: str) -> None:
    assert _refusal(Typed("a page", 1, line)) is not None


def test_what_a_shell_does_with_a_line_is_left_out() -> None:
    def of(line: str) -> list[str]:
        return Typed("a page", 1, line).arguments

    assert of("    tfsat-host log fetch NUMBER   # over the cable") == ["log", "fetch", "1"]
    assert of("$ tfsat-host completion bash > ~/file") == ["completion", "bash"]
    assert of('tfsat-host status --json | jq ".state"') == ["status", "--json"]


def test_every_make_target_exists() -> None:
    rules = (REPOSITORY / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z][a-z-]*):", rules, re.MULTILINE))
    named = 0
    for document in DOCUMENTS:
        text = document.read_text(encoding="utf-8")
        named_targets = set(re.findall(r"`make ([a-z][a-z-]*)[^`]*`", text))
        for _, line in code_lines(document):
            named_targets |= set(re.findall(r"^\s*(?:\$ )?make ([a-z][a-z-]*)", line))
        assert named_targets <= targets, document
        named += len(named_targets)
    # Found none, the test would pass for nothing.
    assert named > 15
