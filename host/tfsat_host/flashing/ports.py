"""What flashing needs of the computer, small enough to be played by a test."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from tfsat_host.devices.discovery import PortInfo
from tfsat_host.devices.transport import Transport


class Computer(Protocol):
    """Serial ports, programs and time."""

    def ports(self) -> list[PortInfo]:
        """The serial ports that there are now."""

    def touch(self, path: str, baudrate: int = 1200) -> None:
        """Opens the port at this rate and closes it, DTR low: at 1200 baud, an Arduino Micro starts its bootloader.

        Raises PortError.
        """

    def connect(self, path: str) -> Transport:
        """The port, open. Raises PortError."""

    def find_program(self, name: str) -> str | None:
        """The path of an installed program."""

    def run(self, command: Sequence[str], heard: Callable[[str], None], timeout_s: float) -> int | None:
        """Runs a program and passes on what it says, as it comes; its exit code, None if it was ended for time.

        Raises OSError if it cannot be started.
        """

    def now_s(self) -> float:
        """Seconds from any origin."""

    def sleep(self, duration_s: float) -> None:
        """Lets time pass."""
