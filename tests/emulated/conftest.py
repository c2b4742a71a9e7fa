from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.emulated.served import Served
from tfsat_host.emulated.emulated_robot import EmulatedRobot
from tfsat_host.emulated.server import RobotServer
from tfsat_host.emulated.state import ServedFolder


@pytest.fixture(params=["native", "avr"])
def served_robot(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Served]:
    """Yield a served robot, once with the sequencer's core and once with its real image."""
    monkeypatch.chdir(tmp_path)
    with Served("--sequencer", request.param) as process:
        yield process


@pytest.fixture
def native(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    """Yield a served robot for tests that do not depend on the sequencer's image."""
    monkeypatch.chdir(tmp_path)
    with Served() as process:
        yield process


@pytest.fixture
def server(tmp_path: Path) -> Iterator[RobotServer]:
    """Yield a server in this process, whose time passes only in `step`."""
    folder = ServedFolder(tmp_path / "robot")
    with EmulatedRobot() as robot:
        robot_server = RobotServer(robot, folder, folder.kept.load())
        # Ports and sockets are gone before the folder is given back.
        yield robot_server
        robot_server.close()
    folder.release()
