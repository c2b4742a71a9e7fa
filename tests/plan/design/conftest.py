from __future__ import annotations

import pytest

from tests.paths import REPOSITORY
from tfsat_host.robot import RobotModel, load_robot


@pytest.fixture(scope="session")
def drop_tower() -> RobotModel:
    return load_robot()


@pytest.fixture(scope="session")
def five_bodies() -> RobotModel:
    return load_robot(REPOSITORY / "tests" / "robot" / "five_bodies.toml")
