"""Whatever a board or a port refuses, the page has it, in the words of the screen."""

from __future__ import annotations

import re

import pytest

from tests.guide.documents import GUIDE
from tfsat_host.devices.ports import PortProblem
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.remedies import REMEDIES

PAGE = (GUIDE / "troubleshooting.md").read_text(encoding="utf-8")
SECTIONS = {
    section.partition("\n")[0]: section.partition("\n")[2].partition("\n## ")[0]
    for section in PAGE.split("\n### ")[1:]
}


@pytest.mark.parametrize("code", [code for code in ErrorCode if code is not ErrorCode.NONE])
def test_every_error_code_has_its_section(code: ErrorCode) -> None:
    section = SECTIONS[f"{int(code)} {code.name.lower()}"]
    for sentence in REMEDIES[code]:
        assert sentence in section


@pytest.mark.parametrize("problem", PortProblem)
def test_every_problem_of_port_and_link_has_its_section(problem: PortProblem) -> None:
    assert "**Do:**" in " ".join(SECTIONS[problem.value].split())


def test_there_is_nothing_else() -> None:
    assert len(SECTIONS) == len(ErrorCode) - 1 + len(PortProblem)
    assert len(re.findall("^### ", PAGE, re.MULTILINE)) == len(SECTIONS)
