"""The programs that the short forms of the campaigns run, built once for all of a test run's processes."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from tests.emulator_avr.building import Edit
from tests.logger_proof import building

Plant = Callable[[Sequence[Edit]], Path]


@pytest.fixture(scope="session")
def pc(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`run` of board/ for this computer, with the sanitizers on."""
    return _built_once(tmp_path_factory, "logger_pc", building.build_for_pc)


@pytest.fixture(scope="session")
def m7(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`run` of board/ for the Cortex-M7."""
    return _built_once(tmp_path_factory, "logger_m7", building.build_for_m7)


@pytest.fixture
def plant(pc: Path, tmp_path: Path) -> Plant:
    """Makes a program whose core has a defect."""
    return lambda edits: building.plant(pc, tmp_path, edits)


def _built_once(factory: pytest.TempPathFactory, name: str, build: Callable[[Path], Path]) -> Path:
    base = factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    folder = shared / name
    with (shared / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if folder.exists():
            return folder / "tree" / "program"
        return build(folder)
