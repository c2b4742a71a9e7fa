"""Bytes to and from a board, with a clock: a serial port, or the emulated robot in virtual time."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Protocol

from tfsat_host.devices.serial_ports import PortError, PortProblem, open_serial
from tfsat_host.next_step import Advice, NextStep

if TYPE_CHECKING:
    import serial


_TIMED_OUT = "a write timed out: the board takes no bytes, or this computer was suspended meanwhile"
_GONE = "the cable was pulled, or the board lost its power or was reset"


class Transport(Protocol):
    """One end of a cable. Time is the transport's own, so that an emulated board never waits for real."""

    @property
    def name(self) -> str:
        """What a person calls the port."""

    def now_s(self) -> float:
        """Seconds on the transport's clock, from any origin."""

    def write(self, data: bytes) -> None:
        """Sends all of `data`. Raises PortError when the cable is gone or it is not taken."""

    def read(self, timeout_s: float) -> bytes:
        """Read the bytes that have arrived, at least one if one comes within `timeout_s`. Raises PortError."""

    def close(self) -> None:
        """Lets go of the port."""


class SerialTransport:
    """A serial port, used by this program alone."""

    _POLL_S = 0.05

    def __init__(self, path: str) -> None:
        """Opens the port. Raises PortError."""
        self._path = path
        self._port: serial.Serial = open_serial(path, read_timeout_s=self._POLL_S)

    @property
    def name(self) -> str:
        """The port's path."""
        return self._path

    def now_s(self) -> float:
        """Seconds on the computer's monotonic clock."""
        return time.monotonic()

    def write(self, data: bytes) -> None:
        """Sends all of `data`; raises PortError when it is not taken within the write timeout."""
        try:
            # No flush(): it would wait without limit for a board that hangs, and fail in its own way.
            self._port.write(data)
        except OSError as error:
            import serial

            if not isinstance(error, serial.SerialTimeoutException):
                raise self._lost(_GONE) from error
            # Which bytes went out before nobody knows: a part of a request is no request.
            raise self._lost(_TIMED_OUT) from error

    def read(self, timeout_s: float) -> bytes:
        """Read the bytes that have arrived, at least one if one comes within `timeout_s`."""
        deadline = time.monotonic() + timeout_s
        try:
            while True:
                # Take all that waits; with nothing there, block for a byte up to the poll time.
                data: bytes = self._port.read(max(1, self._port.in_waiting))
                if data or time.monotonic() >= deadline:
                    return data
        except (OSError, TypeError) as error:  # pyserial raises TypeError when a port vanishes mid-read
            raise self._lost(_GONE) from error

    def close(self) -> None:
        """Closes the port."""
        self._port.close()

    def _lost(self, how: str) -> PortError:
        return PortError(
            PortProblem.LOST,
            what=f"The connection on {self._path} was lost: {how}.",
            meaning="The last command may or may not have reached the board; nothing is half done there.",
            next_step=Advice(
                "Check the cable, then run ", NextStep("status"), " and the same command again."
            ),
        )
