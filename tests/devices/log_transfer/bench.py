"""A logger in an emulated robot, and a cable that does to its bytes what cables do."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Self

from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.serial_ports import PortError, PortProblem
from tfsat_host.emulated.emulated_robot import SETTLE_US, US_PER_S, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.messages import LogEntry

Corrupt = Callable[[bytes], bytes]
"""What the cable makes of the bytes that the board sent, frame by frame."""


class Cable(EmulatedTransport):
    """The emulated logger's cable.

    Attributes:
        corrupt: Applied to each frame (with its end) that the board sends.
        cut_after: It is pulled once the board has sent so many bytes; None: never.
        received: Bytes that the board has sent.
    """

    def __init__(self, robot: EmulatedRobot) -> None:
        super().__init__(robot, BoardIndex.LOGGER)
        self.corrupt: Corrupt = lambda frame: frame
        self.cut_after: int | None = None
        self.received = 0
        self._rest = b""

    def read(self, timeout_s: float) -> bytes:
        data = super().read(timeout_s)
        self.received += len(data)
        if self.cut_after is not None and self.received > self.cut_after:
            raise PortError(PortProblem.LOST, what="The cable was pulled.", next_step="Plug it in.")
        # What is behind the last zero is the begin of a frame: it waits for the rest.
        *frames, self._rest = (self._rest + data).split(b"\0")
        return b"".join(self.corrupt(frame + b"\0") for frame in frames)


class Bench:
    """A robot with its logger, in virtual time, and a folder for files."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.robot = EmulatedRobot(seed=1)
        self.robot.advance(SETTLE_US)
        self.cable = Cable(self.robot)
        self.logger = LoggerClient.connect(self.cable)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.robot.close()

    def wait(self, seconds: float) -> None:
        """Lets time pass."""
        self.robot.advance(round(seconds * US_PER_S))

    def record(self, seconds: float = 1.0) -> int:
        """Make a recording on the card and return its session."""
        session = self.logger.start_recording().session
        self.logger.wait_for_card()
        self.wait(seconds)
        self.logger.stop_recording()
        return session

    def entry(self, number: int) -> LogEntry:
        """Return the log entry of recording `number`."""
        return next(entry for entry in self.logger.logs() if entry.number == number)

    def fetch(self, entry: LogEntry) -> bytes:
        """Fetch all blocks of the recording and return them joined."""
        blocks: dict[int, bytes] = {}
        self.logger.fetch_blocks(entry, [(0, entry.blocks)], blocks.__setitem__)
        # Every block once, in any order.
        assert sorted(blocks) == list(range(entry.blocks))
        data = b"".join(blocks[index] for index in range(entry.blocks))
        assert len(data) == entry.blocks * BLOCK_BYTES
        return data
