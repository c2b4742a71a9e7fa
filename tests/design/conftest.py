from __future__ import annotations

from pathlib import Path

import pytest

from tfsat_host.robot import RobotModel, load_robot


@pytest.fixture(scope="session")
def drop_tower() -> RobotModel:
    return load_robot()


@pytest.fixture(scope="session")
def five_bodies() -> RobotModel:
    return load_robot(Path(__file__).parents[1] / "robot" / "five_bodies.toml")
