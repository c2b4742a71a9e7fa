from __future__ import annotations

import pytest

from tests.dynamics.random_robots import random_robot
from tfsat_host.plan.orbit.primitives import PrimitiveTable, primitive_table
from tfsat_host.robot import RobotModel, load_robot
from tfsat_host.robot.path import find_robot


@pytest.fixture(scope="session")
def cubesat() -> RobotModel:
    return load_robot(find_robot("cubesat_3u"))


@pytest.fixture(scope="session")
def table(cubesat: RobotModel) -> PrimitiveTable:
    return primitive_table(cubesat, 5.0)


@pytest.fixture(scope="session")
def nimble(tmp_path_factory: pytest.TempPathFactory) -> RobotModel:
    """Four bodies with axes in all directions, from -90 to 90 deg: it turns about every axis."""
    return random_robot(tmp_path_factory.mktemp("robots"), 5, 4)


@pytest.fixture(scope="session")
def nimble_table(nimble: RobotModel) -> PrimitiveTable:
    return primitive_table(nimble, 10.0)
