from __future__ import annotations

import pytest

from tfsat_host.robot import RobotModel, load_robot


@pytest.fixture(scope="session")
def robot() -> RobotModel:
    return load_robot()
