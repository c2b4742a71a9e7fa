"""A cable to an emulated board: reading lets virtual time pass."""

from __future__ import annotations

import math

from tfsat_host.devices.serial_ports import PortError, PortProblem
from tfsat_host.emulated.emulated_robot import US_PER_S, BoardIndex, EmulatedRobot

_STEP_US = 500
_WRITE_TIMEOUT_S = 1.0


class EmulatedTransport:
    """One board of an emulated robot in this process, as a `Transport`.

    The sequencer's port is open, for the board to see (DTR), from here until `close`.
    """

    def __init__(self, robot: EmulatedRobot, board: BoardIndex) -> None:
        self._robot = robot
        self._board = board
        self._set_port(True)

    @property
    def name(self) -> str:
        """What a person calls the port."""
        return f"emulated {self._board.name.lower()}"

    def now_s(self) -> float:
        """Virtual seconds."""
        return self._robot.now_us / US_PER_S

    def write(self, data: bytes) -> None:
        """Sends all of `data`; raises PortError when the board takes nothing for a second."""
        deadline_s = self.now_s() + _WRITE_TIMEOUT_S
        while data:
            # A board takes what its receive buffer has room for; let time pass until that has drained.
            byte_count = self._robot.write(self._board, data)
            data = data[byte_count:]
            if not byte_count:
                if self.now_s() > deadline_s:
                    raise PortError(
                        PortProblem.OTHER,
                        what=f"The {self.name} takes no bytes.",
                        next_step="Its power is off or its cable is pulled.",
                    )
                self._robot.advance(_STEP_US)

    def read(self, timeout_s: float) -> bytes:
        """Read the bytes that have arrived, waiting up to `timeout_s` of virtual time for the first one."""
        # Rounded up: a caller that waits for a moment shorter than a tick must see time pass.
        deadline_us = self._robot.now_us + math.ceil(timeout_s * US_PER_S)
        return self._robot.read_by(self._board, deadline_us, _STEP_US)

    def close(self) -> None:
        """Ends the connection; the robot lives on."""
        self._set_port(False)

    def _set_port(self, is_open: bool) -> None:
        # The logger's cable always has a program at its end; only the sequencer's port opens and closes.
        if self._board == BoardIndex.SEQUENCER:
            self._robot.set_port(is_open)
