"""Commands at the ports of an emulated robot: in virtual time in this process, or served by `emulate`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

import pytest

from tests.cli.process import RunCli
from tests.emulated.served import Served
from tfsat_host.emulated.control import execute
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.server import RobotServer

_STEP_US = 10_000


class RobotHere:
    """An emulated robot in this process whose ports are two files of the current folder, for `control.execute`."""

    def __init__(self, robot: EmulatedRobot) -> None:
        self.robot = robot
        # Ports as files, so that a command that looks for them finds them.
        self.sequencer, self.logger = Path("robot/sequencer"), Path("robot/logger")
        for port in (self.sequencer, self.logger):
            port.parent.mkdir(exist_ok=True)
            port.touch()

    def control(self, *lines: str) -> list[str]:
        """Execute control lines as `Served.control` does, waiting in virtual time."""
        replies = []
        for line in lines:
            reply = execute(line, cast(RobotServer, self))
            assert reply is not None
            # Virtual time runs only while somebody waits.
            while reply.due is not None and not reply.due():
                self.robot.advance(_STEP_US)
            replies.append(reply.text)
        return replies

    def set_power(self, board: BoardIndex, on: bool) -> None:
        self.robot.set_power(board, on)

    def set_cable(self, board: BoardIndex, plugged: bool) -> None:
        self.robot.set_cable(board, plugged)

    def save_card(self, path: Path | None) -> tuple[Path, int]:
        assert path is not None
        return path, path.write_bytes(self.robot.card())


@contextmanager
def robot_here(monkeypatch: pytest.MonkeyPatch) -> Iterator[RobotHere]:
    """Yield an emulated robot to which every port leads."""

    def open_transport(path: str) -> EmulatedTransport:
        return EmulatedTransport(robot, BoardIndex[Path(path).name.upper()])

    with EmulatedRobot(seed=1) as robot:
        for user in ("cli.boards", "devices.transport"):
            monkeypatch.setattr(f"tfsat_host.{user}.SerialTransport", open_transport)
        yield RobotHere(robot)


class LoggerAtPort:
    """`tfsat-host ... --port robot/logger`, and an operator at the robot."""

    def __init__(self, robot: RobotHere | Served, run: RunCli) -> None:
        self.robot = robot
        self.run = run
        self.folder = run.folder

    def __call__(self, *words: object, expect: int = 0) -> Any:
        """Runs the command with `--json`; its object."""
        return self.run.json(*words, "--port", self.robot.logger, expect=expect)

    def read_output(self, *words: object, expect: int = 0) -> str:
        """Runs it without; both its streams."""
        process = self.run(*words, "--port", self.robot.logger, expect=expect)
        return process.stdout + process.stderr

    def hand(self, *lines: str) -> None:
        """Lines to the robot's control; each must succeed."""
        replies = self.robot.control(*lines)
        assert all(reply.startswith("ok") for reply in replies), replies

    def record(self, seconds: float = 0.5) -> dict[str, Any]:
        """Make a recording on the card, with the IMUs settled, and return the answer of `record stop`."""
        # IMUs settle before a recording counts their readings.
        self.hand(f"wait {SETTLE_US / 1e6}")
        self("record", "start")
        self.hand(f"wait {seconds}")
        stopped: dict[str, Any] = self("record", "stop")
        return stopped

    def card_file(self, number: int) -> bytes:
        """Return the card's newest file, copied by the control line `card`."""
        path = self.folder / f"card-{number}.bin"
        self.hand(f"card {path}")
        return Path(path).read_bytes()
