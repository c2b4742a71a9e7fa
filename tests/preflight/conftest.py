"""A morning on which nothing is wrong yet."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.preflight.morning import Morning, morning_of


@pytest.fixture
def morning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Iterator[Morning]:
    with morning_of(tmp_path / "run", monkeypatch, capsys) as made:
        yield made
