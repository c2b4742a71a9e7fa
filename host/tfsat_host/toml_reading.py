"""A TOML file that a person wrote, read whole: what the parser dies of is named like what it refuses."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

_LONG_NUMBER = re.compile(r"[0-9_]{4300}")  # Python's limit for integers


class TomlError(ValueError):
    """What is wrong with the file's text: half a sentence, that begins with its verb."""


def read_toml(file: Path) -> tuple[str, dict[str, Any]]:
    """The text of a file and what it says; a byte order mark, as Windows editors write it, is no part of it.

    Raises:
        OSError: the file cannot be read.
        TomlError: it is not valid TOML.
    """
    try:
        text = file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise TomlError("is not valid TOML: it is not UTF-8 text") from error
    try:
        return text, tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise TomlError(f"is not valid TOML: {error}") from error
    except RecursionError as error:
        raise TomlError("is nested too deeply: its brackets lie hundreds deep in one another") from error
    except ValueError as error:  # of an integer that Python does not convert
        found = _LONG_NUMBER.search(text)
        where = f" (at line {text.count(chr(10), 0, found.start()) + 1})" if found else ""
        raise TomlError(f"has a number of thousands of digits{where}") from error
