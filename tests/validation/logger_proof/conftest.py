"""The programs that the short forms of the campaigns run; what is compiled is kept for all processes."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.validation.logger_proof import building


@pytest.fixture(scope="session")
def pc(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`run` of board/ for this computer, with the sanitizers on."""
    return building.build_for_pc(tmp_path_factory.mktemp("pc"))


@pytest.fixture(scope="session")
def m7(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`run` of board/ for the Cortex-M7."""
    return building.build_for_m7(tmp_path_factory.mktemp("m7"))
