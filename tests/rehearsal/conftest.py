"""What takes long is rehearsed once for all processes of a test run."""

from __future__ import annotations

import contextlib
import hashlib
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.fixtures.once import Once
from tests.rehearsal import days
from tests.rehearsal.days import Day, Days, Rehearsed, Rehearsing
from tests.run.bundle.commands import command


@pytest.fixture(scope="session")
def shared_rehearsal(once: Once) -> Rehearsing:
    """`rehearsed("59", "70", expect=0)`: the command, what it printed and its folder, which is not to be changed."""

    def get(*arguments: str, expect: int = 0) -> Rehearsed:
        def rehearse_once() -> Rehearsed:
            # Named after the arguments: other processes find the same folder.
            folder = once.folder / hashlib.sha256(repr(arguments).encode()).hexdigest()[:16]
            folder.mkdir()
            with contextlib.chdir(folder):
                output = command("rehearse", *arguments, "--out", "run", expect=expect)
            return Rehearsed(folder / "run", output.out, output.err)

        rehearsal: Rehearsed = once(repr((arguments, expect)), rehearse_once)
        return rehearsal

    return get


@pytest.fixture
def run(shared_rehearsal: Rehearsing, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Copy a rehearsed drop to the folder `run` of the current folder."""
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copytree(shared_rehearsal("59", "70").folder, tmp_path / "run"))


@pytest.fixture(scope="session")
def day_of(once: Once) -> Days:
    """Return a function that gives the outcome of a fault's day."""

    def get(fault: Any) -> Day:
        day: Day = once(f"day of {fault.name}", lambda: days.judge_day(fault))
        return day

    return get


@pytest.fixture(scope="session")
def no_go(once: Once, day_of: Days) -> Callable[[Any], tuple[str, ...]]:
    """Checks that block the drop when the fault is there before the preflight."""

    def get(fault: Any) -> tuple[str, ...]:
        if fault.moment in days.BEFORE_PREFLIGHT:
            return day_of(fault).no_go
        checks: tuple[str, ...] = once(f"preflight of {fault.name}", lambda: days.no_go(fault))
        return checks

    return get
