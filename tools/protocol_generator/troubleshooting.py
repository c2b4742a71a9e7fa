"""docs/guide/troubleshooting.md: prose from troubleshooting.in.md, a section for each error code."""

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
    values = {group: _sections(errors, numbers) for group, numbers in _GROUPS.items()}

    def value(match: re.Match[str]) -> str:
        if match[1] not in values:
            raise SpecError(f"{_PROSE.name}: nothing is called @{match[1]}@")
        return values[match[1]]

    return re.sub(r"@(\w+)@", value, _PROSE.read_text(encoding="utf-8"))


def _sections(errors: tuple[EnumValue, ...], numbers: range) -> str:
    return "\n\n".join(_section(error) for error in errors if error.value in numbers)


def _section(error: EnumValue) -> str:
    """What the screen says, word for word, so that it is found by any part of it."""
    return f"### {error.value} {error.name}\n\n{error.doc} {error.meaning}\n\n**Do:** {error.remedy}"
