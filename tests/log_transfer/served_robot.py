"""Commands at the port of an emulated robot's logger."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.cli.process import RunCli
from tests.emulate.served import Served
from tfsat_host.emulated.robot import SETTLE_US


class LoggerAtPort:
    """`tfsat-host ... --port robot/logger`, and a person beside the robot."""

    def __init__(self, served: Served, run: RunCli) -> None:
        self.served = served
        self.run = run
        self.folder = run.folder

    def __call__(self, *words: object, expect: int = 0) -> Any:
        """Runs the command with `--json`; its object."""
        return self.run.json(*words, "--port", self.served.logger, expect=expect)

    def said(self, *words: object, expect: int = 0) -> str:
        """Runs it for people; both its streams."""
        done = self.run(*words, "--port", self.served.logger, expect=expect)
        return done.stdout + done.stderr

    def hand(self, *lines: str) -> None:
        """What a person does; each must succeed."""
        replies = self.served.control(*lines)
        assert all(reply.startswith("ok") for reply in replies), replies

    def record(self, seconds: float = 0.5) -> dict[str, Any]:
        """A recording on the card, of IMUs that have started."""
        self.hand(f"wait {SETTLE_US / 1e6}")
        self("record", "start")
        self.hand(f"wait {seconds}")
        stopped: dict[str, Any] = self("record", "stop")
        return stopped

    def card_file(self, number: int) -> bytes:
        """The card's file, by the control line that copies the newest to a new file."""
        path = self.folder / f"card-{number}.bin"
        self.hand(f"card {path}")
        return Path(path).read_bytes()
