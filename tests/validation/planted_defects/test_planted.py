"""Every planted defect has its one place, and tests that are there. `make prove` plants them."""

from __future__ import annotations

import pytest

from tests.paths import REPOSITORY
from tests.validation.planted_defects.__main__ import Defect, read_defects


@pytest.mark.parametrize("defect", read_defects(), ids=lambda defect: defect.name)
def test_a_defect_can_be_planted(defect: Defect) -> None:
    # Each defect names a line that stands once in the file, or the edit would be ambiguous.
    assert (REPOSITORY / defect.edit.file).read_text(encoding="utf-8").count(defect.edit.old) == 1
    assert all((REPOSITORY / path).exists() for path in defect.tests)


def test_enough_are_planted() -> None:
    assert len(read_defects()) >= 40
