"""The page for those who change the code: each file that it sends them to is there."""

from __future__ import annotations

import re
from functools import cache
from pathlib import PurePosixPath

import pytest

from tests.paths import REPOSITORY

PAGE = (REPOSITORY / "CONTRIBUTING.md").read_text(encoding="utf-8")
# A word in backticks with a separator or the ending of a source file is taken for a path.
PATHS = sorted(
    {
        word
        for word in re.findall(r"`([^`\s]+)`", PAGE)
        if re.fullmatch(r"[\w./*-]+", word) and ("/" in word or re.search(r"\.(py|toml|h|cpp|md|ino)$", word))
    }
)
NOT_THERE = {"cli/NAME.py", "build/fuzz/TARGET/findings"}
"""What stands for any name, and what a command makes."""
PLACES = ("docs", "firmware", "host", "protocol", "robots", "tests", "tools")


@cache
def repository_paths() -> list[PurePosixPath]:
    """Return all files and folders of the repository but what is made; a module also without its `.py`."""
    paths = [path for path in REPOSITORY.iterdir() if path.is_file()]
    paths += [REPOSITORY / place for place in PLACES]
    paths += [path for place in PLACES for path in (REPOSITORY / place).rglob("*")]
    relative_paths = [PurePosixPath(path.relative_to(REPOSITORY).as_posix()) for path in paths]
    return relative_paths + [path.with_suffix("") for path in relative_paths if path.suffix == ".py"]


@pytest.mark.parametrize("path", [path for path in PATHS if path not in NOT_THERE])
def test_a_path_of_the_page_exists(path: str) -> None:
    """Paths may begin at a folder that the sentence names."""
    assert any(there.match(path.rstrip("/")) for there in repository_paths())
