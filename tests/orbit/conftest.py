from __future__ import annotations

import numpy as np
import pytest

from tests.dynamics.random_robots import random_tree, write_robot_file
from tfsat_host.plan.primitives import PrimitiveTable, primitive_table
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
    tree = random_tree(np.random.default_rng(5), 4)
    return load_robot(write_robot_file(tree, tmp_path_factory.mktemp("robots") / "nimble.toml"))


@pytest.fixture(scope="session")
def nimble_table(nimble: RobotModel) -> PrimitiveTable:
    return primitive_table(nimble, 10.0)
