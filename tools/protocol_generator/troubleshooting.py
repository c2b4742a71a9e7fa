"""docs/guide/troubleshooting.md: prose from troubleshooting.in.md, a row for each error code."""

from __future__ import annotations

import re
from pathlib import Path

from .spec import EnumValue, Spec, SpecError

_PROSE = Path(__file__).with_name("troubleshooting.in.md")
# By number, as the specification groups them: a new code stands where its number says.
_GROUPS = {"link": range(1, 4), "sequencer": range(4, 40), "logger": range(40, 256)}


def generate(spec: Spec) -> str:
    """The page. Raises SpecError for a name between @ signs that nothing fills."""
    errors = spec.enums["ErrorCode"].values
    values = {
        group: "\n".join(_row(error) for error in errors if error.value in numbers)
        for group, numbers in _GROUPS.items()
    } | {"head": "| code | what happened | what to do |\n|---|---|---|"}

    def value(match: re.Match[str]) -> str:
        if match[1] not in values:
            raise SpecError(f"{_PROSE.name}: nothing is called @{match[1]}@")
        return values[match[1]]

    return re.sub(r"@(\w+)@", value, _PROSE.read_text(encoding="utf-8"))


def _row(error: EnumValue) -> str:
    """As the screen says it, so that it is found by any part of it."""
    cells = (f"{error.value} `{error.name}`", error.doc, error.remedy)
    return f"| {' | '.join(cell.replace('|', chr(92) + '|').replace(chr(10), ' ') for cell in cells)} |"
