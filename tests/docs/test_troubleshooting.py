"""Whatever a board or a port refuses, the pages have it."""

from __future__ import annotations

import re

import pytest

from tests.docs.documents import GUIDE
from tests.paths import REPOSITORY
from tfsat_host.devices.serial_ports import PortProblem
from tfsat_host.next_step import NextStep
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.remedies import REMEDIES

REFERENCE = (REPOSITORY / "protocol" / "reference.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("code", [code for code in ErrorCode if code is not ErrorCode.NONE])
def test_every_error_code_has_its_row(code: ErrorCode) -> None:
    """Error codes each have a row in the troubleshooting page, in the words of the screen."""
    what, meaning, remedy = REMEDIES[code]
    remedy_text = "".join(f"`{part}`" if isinstance(part, NextStep) else part for part in remedy.parts)
    cells = " | ".join((what, meaning, remedy_text)).replace("\n", " ")
    assert f"| {int(code)} | `{code.name.lower()}` | {cells} |" in REFERENCE


def test_port_and_link_have_theirs_and_there_is_nothing_else() -> None:
    page = (GUIDE / "troubleshooting.md").read_text(encoding="utf-8")
    named = re.findall(r"^\| `([\w-]+)` \| .+ \| .+ \|$", page, re.MULTILINE)
    assert set(named) == {problem.value for problem in PortProblem} and len(named) == len(PortProblem)
