"""What the documents tell people to type."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tests.paths import REPOSITORY

GUIDE = REPOSITORY / "docs" / "guide"
DOCUMENTS = sorted(
    [REPOSITORY / "README.md", REPOSITORY / "CONTRIBUTING.md", *REPOSITORY.glob("docs/**/*.md")]
)

PLACEHOLDERS = {"NUMBER": "1", "N": "1", "PORT": "/dev/ttyACM0", "SECONDS": "1"}
"""Words in documents that stand for a number or a name; everything else is typed as it stands."""

_FENCE = re.compile(r"^ *```")
# With or without a prompt, `time`, variables in front, and a path to the program.
_PROMPT = re.compile(r"^\s*(?:[$>] )?(?:(?:time|\w+=\S+) )*(?:\S*/)?tfsat-host ")
_OPERATORS = frozenset("|&;<>()")


@dataclass(frozen=True)
class Typed:
    """A command line, and where it stands."""

    document: str
    line: int
    text: str

    def __str__(self) -> str:
        return f"{self.document}:{self.line}: {self.text}"

    @property
    def arguments(self) -> list[str]:
        """What the program gets: up to a pipe or a redirection, without comments, placeholders filled in."""
        lexer = shlex.shlex(self.text.strip().removeprefix("$ "), posix=True, punctuation_chars=True)
        lexer.whitespace_split = True
        words = list(lexer)
        start = next(i for i, word in enumerate(words) if word.rpartition("/")[2] == "tfsat-host") + 1
        # What follows a pipe or a redirection is another program's.
        end = next((i for i, word in enumerate(words) if i >= start and set(word) <= _OPERATORS), len(words))
        return [PLACEHOLDERS.get(word, word) for word in words[start:end]]


def code_lines(document: Path) -> Iterator[tuple[int, str]]:
    """Numbered lines of code: fenced, or indented by four blanks and no part of a list."""
    fenced = in_list = False
    for number, line in enumerate(document.read_text(encoding="utf-8").splitlines(), 1):
        if _FENCE.match(line):
            fenced = not fenced
            continue
        # Four blanks below an item of a list are its text, not code.
        if line and not line.startswith(" "):
            in_list = bool(re.match(r"(?:[-*]|\d+\.) ", line))
        if fenced or (line.startswith("    ") and not in_list):
            yield number, line


def typed_in_code(document: Path) -> list[Typed]:
    """Return every `tfsat-host ...` command in the document's code blocks."""
    name = document.relative_to(REPOSITORY).as_posix()
    return [Typed(name, number, line) for number, line in code_lines(document) if _PROMPT.match(line)]


def typed_inline(document: Path) -> list[Typed]:
    """Return every `tfsat-host ...` command between single backticks in the document."""
    name = document.relative_to(REPOSITORY).as_posix()
    return [
        Typed(name, number, text)
        for number, line in enumerate(document.read_text(encoding="utf-8").splitlines(), 1)
        for text in re.findall(r"`(tfsat-host [^`]+)`", line)
    ]
