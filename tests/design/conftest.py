from __future__ import annotations

import pytest

from tfsat_host.robot import RobotModel, load_robot


@pytest.fixture(scope="session")
def drop_tower() -> RobotModel:
    return load_robot()
