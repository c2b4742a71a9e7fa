from __future__ import annotations

from pathlib import Path

import pytest

from tests.dynamics.chain_driver import Robot
from tests.fixtures.cpp.compiling import EMULATOR_SOURCES, build_program
from tfsat_host.robot import load_robot


@pytest.fixture(scope="session")
def probe(tmp_path_factory: pytest.TempPathFactory) -> Path:
    physics = EMULATOR_SOURCES / "physics"
    sources = [Path(__file__).with_name("chain_probe.cpp"), physics / "chain.cpp", physics / "body_tree.cpp"]
    return build_program(sources, tmp_path_factory.mktemp("probe") / "chain_probe")


@pytest.fixture(scope="session")
def drop_tower() -> Robot:
    return Robot.of(load_robot())
