"""A run, and the bundle of it, made once and copied."""

from __future__ import annotations

import contextlib
from datetime import UTC, datetime
from pathlib import Path
from shutil import copyfile

import pytest

from tests.bundle.commands import command
from tests.evaluation.run_folder import run_folder
from tfsat_host.run.record import sign

PREFLIGHT = '{"go": true, "boards": {"sequencer": {"firmware": "0.1.0", "image_crc": "1a2b3c4d"}}}\n'


def signed_run(folder: Path) -> None:
    """A drop with all its papers."""
    run_folder(folder)
    (folder / "preflight.json").write_text(PREFLIGHT)
    (folder / "notes.txt").write_text("wind from the west\n")
    (folder / "SD.csv").write_text("decoded\n")
    sign(
        folder,
        [folder / "preflight.json"],
        "tfsat-host preflight: GO",
        datetime(2026, 1, 5, 8, 30, tzinfo=UTC),
    )


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A drop in the folder `run` of the current one."""
    monkeypatch.chdir(tmp_path)
    signed_run(tmp_path / "run")
    return tmp_path / "run"


@pytest.fixture(scope="session")
def made_bundle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Not to be changed."""
    folder = tmp_path_factory.mktemp("bundle")
    with contextlib.chdir(folder):
        signed_run(folder / "run")
        command("bundle", "run")
    return folder / "run.tfsat.zip"


@pytest.fixture
def bundle(made_bundle: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A bundle in the current folder."""
    monkeypatch.chdir(tmp_path)
    copyfile(made_bundle, tmp_path / "run.tfsat.zip")
    return tmp_path / "run.tfsat.zip"
