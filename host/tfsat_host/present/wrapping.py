"""Lines no wider than a terminal, broken at spaces: never in a word, a number with its ±, or a command to type."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Iterable
from typing import TextIO

MIN_COLUMNS = 20
_PROGRAMS = ("tfsat-host", "pip", "export", "cp", "mkdir", "sudo", "apt")
"""Words that begin a command to type."""
_ARGUMENT = re.compile(r"(-|'|\"|[A-Z]+\b|\d|\S*[/=\\]|\S*\.\w|run\d*\b)")
"""How an argument begins that is no word of the sentence around it."""
_ACTION = re.compile(r"[a-z]+(-[a-z]+)*$")
_ENDS_COMMAND = (",", ";", ":", ".", ")")
_TAKE_ACTIONS = ("log", "record", "calibrate", "campaign", "logger-settings", "completion", "install")
_LABEL = re.compile(r"\s*(?:- |\S[^.]{0,40}?\s{2,})?")
"""What a line begins with that its continuation is indented by."""
_MIN_TEXT_COLUMNS = 20


def stream_columns(stream: TextIO) -> int | None:
    """Return how many characters a line of a stream has: by COLUMNS, else as the terminal says; None in a pipe."""
    columns_text = os.environ.get("COLUMNS", "")
    if columns_text.isascii() and columns_text.isdigit() and int(columns_text) > 0:
        return max(int(columns_text), MIN_COLUMNS)
    if not stream.isatty():
        return None
    try:
        return max(os.get_terminal_size(stream.fileno()).columns or 80, MIN_COLUMNS)
    except OSError:
        return max(shutil.get_terminal_size((80, 24)).columns, MIN_COLUMNS)


def wrap_line(line: str, columns: int) -> list[str]:
    """Break one line at spaces; its continuation stands below its text, or two characters further in.

    It has no line feeds; a word or command longer than `columns` has a line of its own.
    """
    line = line.rstrip()
    if len(line) <= columns:
        return [line]
    label = _LABEL.match(line)
    first = label[0] if label is not None else ""
    # Beside a long label hardly a word would fit: hang from the line's own indentation.
    if columns - len(first) < _MIN_TEXT_COLUMNS:
        first = line[: len(line) - len(line.lstrip())]
    hang = len(first) if first.strip() else len(first) + 2
    return fill_lines(line[len(first) :], columns, first, " " * hang)


def fill_lines(text: str, columns: int, first: str = "", others: str = "") -> list[str]:
    """Fill lines with a text's words; the first line begins with `first`, each further one with `others`."""
    lines, line = [], first
    is_empty = True
    # Greedy: as many chunks to a line as fit; one that is too long has its own.
    for chunk in unbreakable_chunks(text.split()):
        if not is_empty and len(line) + 1 + len(chunk) > columns:
            lines.append(line.rstrip())
            line, is_empty = others, True
        line += chunk if is_empty else f" {chunk}"
        is_empty = False
    return [*lines, line.rstrip()]


def unbreakable_chunks(words: Iterable[str]) -> list[str]:
    """Join the words of a command to type, and those of a value with its ±."""
    chunks: list[str] = []
    is_command = is_value = False
    listed = list(words)
    # Two states: within a command until a word ends it by punctuation, and just behind a ±.
    for word, following in zip(listed, [*listed[1:], ""], strict=False):
        if chunks and (
            _continues_command(chunks[-1], word, following) if is_command else word == "±" or is_value
        ):
            chunks[-1] += f" {word}"
        else:
            chunks.append(word)
            is_command = word.lstrip("(") in _PROGRAMS
        is_value = word == "±"
        is_command = is_command and not word.endswith(_ENDS_COMMAND)
    return chunks


def _continues_command(command: str, word: str, following: str) -> bool:
    """Return whether a word belongs to the command before it.

    Such words are its first words, an argument, or a word before an option.
    """
    before = command.split()
    is_action = len(before) <= 2 and _ACTION.match(word.rstrip(".,;:)")) is not None
    # `tfsat-host status` is whole, `tfsat-host log` wants another word.
    if len(before) == 2 and before[1] not in _TAKE_ACTIONS:
        is_action = False
    return (
        is_action or before[-1].startswith("--") or following.startswith("--") or bool(_ARGUMENT.match(word))
    )
