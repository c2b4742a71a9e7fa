"""What every test may rely on: seeded properties, a home of its own, no board by accident."""

from __future__ import annotations

import gc
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from tests.cli.process import RunCli, clean_environment
from tests.fixtures.once import Once

# Under `make test` a make that a test runs would think itself a part of it, and print where it is.
for variable in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL"):
    os.environ.pop(variable, None)

# Derandomised: a red test is red for everybody. Deadlines measure the machine, not the code.
settings.register_profile(
    "tfsat", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
settings.load_profile("tfsat")


def pytest_xdist_auto_num_workers() -> int:
    """Return one process more than there are cores: while one waits for a board, another computes."""
    return (os.cpu_count() or 1) + 1


def pytest_collection_finish() -> None:
    """Keep what is loaded by now out of later garbage collections: thousands of tests cost each of them time."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def _own_home(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Isolate the test from the user's state, real ports and colored output."""
    home = tmp_path_factory.mktemp("home")
    for name, value in clean_environment(home).items():
        monkeypatch.setenv(name, value)
    for name in [name for name in os.environ if name == "COLUMNS" or name.startswith("TFSAT_")]:
        monkeypatch.delenv(name)


@pytest.fixture(scope="session")
def once(tmp_path_factory: pytest.TempPathFactory) -> Once:
    """`once("name", make)`: what `make` makes, once in a run of the tests."""
    return Once(tmp_path_factory)


@pytest.fixture
def tfsat_host(tmp_path: Path) -> RunCli:
    """Runs `tfsat-host` as a process in an empty folder: `tfsat_host("ports", "--json")`."""
    return RunCli(tmp_path)
