"""From a file, or its text, to its table: what the parser dies of is named like what it refuses."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from tfsat_host.config.table import ConfigKind, Fault, Table, shown

_LONG_NUMBER = re.compile(r"[0-9_]{4300}")  # Python's limit for integers


def read_config(path: Path, kind: ConfigKind) -> Table:
    """The entries of a file; a byte order mark, as Windows editors write it, is no part of it.

    Raises:
        TfsatError: the kind's: the file cannot be read, is not valid TOML, or is of another format.
    """
    try:
        if path.stat().st_size > kind.bytes_max:
            raise kind.refusal(f"{path}: this is no {kind.name}: it is too large.", Fault.SYNTAX)
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        what = f"The {kind.name} {path} cannot be read: {error.strerror or error}."
        raise kind.refusal(what, Fault.UNREADABLE) from error
    except UnicodeDecodeError as error:
        what = f"The {kind.name} {path} cannot be read: it is not UTF-8 text."
        raise kind.refusal(what, Fault.NOT_TEXT) from error
    return parse_config(text, str(path), kind)


def parse_config(text: str, source: str, kind: ConfigKind) -> Table:
    """The entries in the text of a file; `source` is the name that errors give it. Raises likewise."""
    text = text.replace("\r\n", "\n")
    try:
        values = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise kind.refusal(f"{source}: {_problem(text, error)}.", Fault.SYNTAX) from error
    top = Table(kind, source, text, (), values)
    if kind.format is not None:
        key, number = kind.format
        found = top.value(key, str(number))
        if type(found) is not int or found != number:
            cure = f"Use the tfsat-host that made the file; this one reads the line `{key} = {number}`."
            top.fail(key, f"{shown(found)} is not {number}", cure, Fault.FORMAT)
    return top


def _problem(text: str, error: ValueError | RecursionError) -> str:
    if isinstance(error, tomllib.TOMLDecodeError):
        return f"is not valid TOML: {error}"
    if isinstance(error, RecursionError):
        return "is nested too deeply: its brackets lie hundreds deep in one another"
    found = _LONG_NUMBER.search(text)
    where = f" (at line {text.count(chr(10), 0, found.start()) + 1})" if found else ""
    return f"has a number of thousands of digits{where}"
