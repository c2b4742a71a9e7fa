"""A good drop, evaluated once for all tests that only look at it."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pytest

from tests.evaluation.commanded import Said, evaluate
from tests.evaluation.run_folder import run_folder


@pytest.fixture(scope="session")
def good(tmp_path_factory: pytest.TempPathFactory) -> Said:
    """`tfsat-host evaluate run --json` of the drop that `run_folder` gives."""
    folder = tmp_path_factory.mktemp("good")
    run_folder(folder / "run")
    with contextlib.chdir(folder):
        return evaluate("run", "--json")


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Create a whole drop in the folder `run` of the current folder."""
    monkeypatch.chdir(tmp_path)
    run_folder(tmp_path / "run")
    return tmp_path / "run"
