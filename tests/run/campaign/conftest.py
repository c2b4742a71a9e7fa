"""A campaign, and drops that could come into it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.evaluation.run_folder import run_folder
from tests.run.bundle.commands import command, keep_evaluations


@pytest.fixture
def camp(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Create an empty campaign next to three runs."""
    keep_evaluations(monkeypatch)
    monkeypatch.chdir(tmp_path)
    # One robot, three noises: the drops of one campaign must agree with each other.
    for seed in (1, 2, 3):
        run_folder(tmp_path / f"run{seed}", seed)
    command("campaign", "init", "camp")
    return tmp_path / "camp"
