"""Whatever a board or a port refuses, the page has it, in the words of the screen."""

from __future__ import annotations

import re

import pytest

from tests.guide.documents import GUIDE
from tfsat_host.devices.ports import PortProblem
from tfsat_host.protocol.enums import ErrorCode
from tfsat_host.protocol.remedies import REMEDIES

PAGE = (GUIDE / "troubleshooting.md").read_text(encoding="utf-8")
ROWS = dict(re.findall(r"^\| ((?:\d+ )?`[\w-]+`) \| (.*) \|$", PAGE, re.MULTILINE))


@pytest.mark.parametrize("code", [code for code in ErrorCode if code is not ErrorCode.NONE])
def test_every_error_code_has_its_row(code: ErrorCode) -> None:
    what, _, next_step = REMEDIES[code]
    assert ROWS[f"{int(code)} `{code.name.lower()}`"] == f"{what} | {next_step}".replace("\n", " ")


def test_port_and_link_have_theirs_and_there_is_nothing_else() -> None:
    assert all(f"`{problem.value}`" in ROWS for problem in PortProblem)
    assert len(ROWS) == len(ErrorCode) - 1 + len(PortProblem)
