"""What takes long is rehearsed once for all processes of a test run, and kept on disk."""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import os
import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.rehearsal import days
from tests.rehearsal.days import Day, Days, Rehearsed, Rehearsing
from tests.run.bundle.commands import command


class Kept:
    """Results by their names.

    Attributes:
        folder: Where they lie.
    """

    def __init__(self, factory: pytest.TempPathFactory) -> None:
        base = factory.getbasetemp()
        self.folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "rehearsals"
        self.folder.mkdir(exist_ok=True)

    def __call__(self, name: str, made: Callable[[], Any]) -> Any:
        file = self.folder / f"{hashlib.sha256(name.encode()).hexdigest()[:16]}.pickle"
        with file.with_suffix(".lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not file.exists():
                file.write_bytes(pickle.dumps(made()))
        return pickle.loads(file.read_bytes())


@pytest.fixture(scope="session")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Kept:
    return Kept(tmp_path_factory)


@pytest.fixture(scope="session")
def rehearsed(kept: Kept) -> Rehearsing:
    """`rehearsed("59", "70", expect=0)`: the command, what it printed and its folder, which is not to be changed."""

    def get(*typed: str, expect: int = 0) -> Rehearsed:
        def made() -> Rehearsed:
            folder = kept.folder / hashlib.sha256(repr(typed).encode()).hexdigest()[:16]
            folder.mkdir()
            with contextlib.chdir(folder):
                said = command("rehearse", *typed, "--out", "run", expect=expect)
            return Rehearsed(folder / "run", said.out, said.err)

        one: Rehearsed = kept(repr((typed, expect)), made)
        return one

    return get


@pytest.fixture
def run(rehearsed: Rehearsing, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A rehearsed drop, copied as the folder `run` of the current one."""
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copytree(rehearsed("59", "70").folder, tmp_path / "run"))


@pytest.fixture(scope="session")
def seen(kept: Kept) -> Days:
    """What became of the day of a fault."""

    def get(fault: Any) -> Day:
        day: Day = kept(f"day of {fault.name}", lambda: days.seen(fault))
        return day

    return get


@pytest.fixture(scope="session")
def no_go(kept: Kept, seen: Days) -> Callable[[Any], tuple[str, ...]]:
    """Checks that stand against the drop when the fault is there before the preflight."""

    def get(fault: Any) -> tuple[str, ...]:
        if fault.moment in days.BEFORE_PREFLIGHT:
            return seen(fault).no_go
        checks: tuple[str, ...] = kept(f"preflight of {fault.name}", lambda: days.no_go(fault))
        return checks

    return get
