"""Every planted defect has its one place, and tests that are there. `make prove` plants them."""

from __future__ import annotations

import pytest

from tests.paths import REPOSITORY
from tests.validation.planted.__main__ import Defect, defects, places


@pytest.mark.parametrize("defect", defects(), ids=lambda one: one.name)
def test_a_defect_can_be_planted(defect: Defect) -> None:
    assert len(places(defect)) == 1
    assert all((REPOSITORY / path).exists() for path in defect.tests)


def test_enough_are_planted() -> None:
    assert len(defects()) >= 40
