"""A rehearsed day, lived once a run of the tests and copied."""

from __future__ import annotations

import contextlib
import shutil
from pathlib import Path

import pytest

from tests.bundle.commands import command


@pytest.fixture(scope="session")
def made_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Not to be changed."""
    folder = tmp_path_factory.mktemp("rehearsed")
    with contextlib.chdir(folder):
        command("rehearse", "59", "70", "--out", "run")
    return folder / "run"


@pytest.fixture
def run(made_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder `run` in the current one."""
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copytree(made_run, tmp_path / "run"))
