"""`report --out`: a file's name is a file's, and folders are not made without a word."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bundle.commands import command
from tests.evaluation.run_folder import run_folder


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a drop in `run`."""
    monkeypatch.chdir(tmp_path)
    run_folder(tmp_path / "run")
    return tmp_path


@pytest.mark.parametrize("name", ["dirx/", "dirx/.", "there/"])
def test_a_name_that_ends_like_a_folder_is_refused(here: Path, name: str) -> None:
    Path("there").mkdir()
    said = command("report", "run", "--out", name, expect=2)
    assert f"'{name}' is a folder" in said.err and f"{name.rstrip('.')}NAME" in said.err
    assert sorted(path.name for path in here.iterdir()) == ["run", "there"]
    assert "is a folder" in command("campaign", "report", "camp", "--out", name, expect=2).err


def test_folders_that_are_made_are_named(here: Path) -> None:
    said = command("report", "run", "--out", "new/deep/report.html")
    assert (here / "new/deep/report.html").is_file()
    assert "The folder new/deep was not there: it was made." in said.err
    said = command("report", "run", "--out", "new/deep/report.html")
    assert "was made" not in said.err
