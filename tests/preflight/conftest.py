"""A robot with which nothing is wrong yet."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.preflight.ready_robot import ReadyRobot, ready_robot


@pytest.fixture
def ready(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Iterator[ReadyRobot]:
    with ready_robot(tmp_path / "run", monkeypatch, capsys) as robot:
        yield robot
