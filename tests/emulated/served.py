"""`tfsat-host emulate` as a process, and what a test does to it."""

from __future__ import annotations

import json
import signal
import socket
import subprocess
import sys
from pathlib import Path
from types import TracebackType
from typing import Any, Self

TIMEOUT_S = 120.0
"""For what must come some time: building the robot included."""


class Served:
    """A robot served in `robot` of the current folder. Relative, as a socket's path must be short."""

    def __init__(self, *options: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tfsat_host", "emulate", "--json", *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        # The first line comes once the ports are there: nothing has to be polled.
        self.announced: dict[str, Any] = json.loads(self.process.stdout.readline() or "{}")
        self.folder = Path("robot")
        self.sequencer = self.folder / "sequencer"
        self.logger = self.folder / "logger"

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        # A test that failed leaves the robot running: kill it, and take its pipes.
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate(timeout=TIMEOUT_S)

    def control(self, *lines: str) -> list[str]:
        """Send lines over the control socket and return the reply to each."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as link:
            link.settimeout(TIMEOUT_S)
            link.connect(str(self.folder / "control"))
            link.sendall("".join(f"{line}\n" for line in lines).encode())
            # The end of the input lets the server close the link behind the last reply.
            link.shutdown(socket.SHUT_WR)
            with link.makefile() as replies:
                return [line.rstrip("\n") for line in replies]

    def end(self, number: signal.Signals = signal.SIGTERM) -> str:
        """End the process by a signal and return what it printed on stderr."""
        # An end by a signal is a normal end: exit code 0, no traceback.
        self.process.send_signal(number)
        _, error_text = self.process.communicate(timeout=TIMEOUT_S)
        assert self.process.returncode == 0, error_text
        assert "Traceback" not in error_text
        return error_text
