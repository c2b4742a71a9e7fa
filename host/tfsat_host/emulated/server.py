"""The emulated robot for other programs: two serial ports, and what a person can do to it."""

from __future__ import annotations

from pathlib import Path

from tfsat_host.emulated.pty_port import PtyPort
from tfsat_host.emulated.robot import US_PER_S, BoardIndex, EmulatedRobot, EmulationError, Reset
from tfsat_host.emulated.served_folder import ServedFolder
from tfsat_host.emulated.state import Kept
from tfsat_host.errors import TfsatError
from tfsat_host.whole_file import write_whole

STEP_US = 1000
"""Virtual time between two reads of the ports: about the frame of full-speed USB."""
_QUIET_US = 20_000
"""An EEPROM that was not written to for so long has all of an upload; a byte takes 3.4 ms."""


class RobotServer:
    """A robot and the ports of its boards. Virtual time passes in `step` and nowhere else.

    Args:
        robot: The robot, its boards powered and plugged.
        folder: Where ports, EEPROM and card lie.
        before: What the folder kept of the run before, and the robot was made with.
    """

    def __init__(self, robot: EmulatedRobot, folder: ServedFolder, before: Kept) -> None:
        self._robot = robot
        self._folder = folder
        self._before = before
        before.put_card(robot)
        self._ports = {
            BoardIndex.SEQUENCER: PtyPort(folder.sequencer),
            BoardIndex.LOGGER: PtyPort(folder.logger),
        }
        self._untaken = dict.fromkeys(BoardIndex, b"")
        self._powered = dict.fromkeys(BoardIndex, True)
        self._cabled = dict.fromkeys(BoardIndex, True)
        self._copies = {folder.card.resolve()}
        self._last_writes = robot.eeprom_writes
        self._kept_eeprom = robot.eeprom()
        self._kept_memory = robot.logger_memory()
        self._memory_look_us = robot.now_us
        self._end_us: int | None = None
        self._stopped = False
        for port in self._ports.values():
            port.plug()

    @property
    def robot(self) -> EmulatedRobot:
        """The robot itself."""
        return self._robot

    def step(self) -> None:
        """STEP_US of virtual time, bytes passed on both ways. Raises EmulationError."""
        for board, port in self._ports.items():
            data = self._untaken[board] or port.read()
            if board == BoardIndex.SEQUENCER:
                self._robot.set_port(port.is_open)
            if data:
                self._untaken[board] = data[self._robot.write(board, data) :]
        self._robot.advance(STEP_US)
        for board, port in self._ports.items():
            answer = self._robot.read(board) if port.has_room else b""
            if answer and board == BoardIndex.SEQUENCER:
                self._keep_eeprom()  # what a host has read back outlives even a kill -9 of this process
            port.write(answer)
        if self._robot.now_us - self._memory_look_us >= _QUIET_US:
            self._memory_look_us = self._robot.now_us
            writes, self._last_writes = self._last_writes, self._robot.eeprom_writes
            if writes == self._last_writes:
                self._keep_eeprom()
            self._keep_logger_memory()

    def set_power(self, board: BoardIndex, on: bool) -> None:
        """Switches a board's supply; without it its port goes."""
        self._powered[board] = on
        self._robot.set_power(board, on)
        self._update_port(board)

    def set_cable(self, board: BoardIndex, plugged: bool) -> None:
        """Plugs or pulls a board's USB cable; without it its port goes."""
        self._cabled[board] = plugged
        self._robot.set_cable(board, plugged)
        self._update_port(board)

    def reset(self, cause: Reset) -> None:
        """Restarts the sequencer; as its USB restarts too, its port goes and comes. Raises EmulationError."""
        board = BoardIndex.SEQUENCER
        if not self._powered[board]:
            raise EmulationError(
                what="The sequencer has no power.",
                meaning="Nothing was changed.",
                next_step="First: power sequencer on",
            )
        self._robot.reset(cause)
        self._ports[board].pull()
        self._untaken[board] = b""
        self._update_port(board)

    def save_card(self, path: Path | None = None) -> tuple[Path, int]:
        """Copies the card's recording to `path`, by default into the folder.

        Returns:
            Where it is, and its bytes.

        Raises:
            TfsatError: nothing was recorded, or `path` is a file that this server did not write.
        """
        target = (path or self._folder.card).resolve()
        recording = self._robot.card()
        if not recording:
            raise TfsatError(
                what="There is no recording on the card.",
                meaning="Nothing was written.",
                next_step="Start one through the logger's port first.",
            )
        if target.exists() and target not in self._copies:
            raise TfsatError(
                what=f"{target} exists.", meaning="It is as it was.", next_step="Name another file."
            )
        target.write_bytes(recording)
        self._copies.add(target)
        return target, len(recording)

    def stop(self) -> None:
        """Asks whoever steps this server to end."""
        self._stopped = True

    def stop_after(self, duration_s: float) -> None:
        """Stops when that much virtual time has passed."""
        self._end_us = self._robot.now_us + round(duration_s * US_PER_S)

    @property
    def stopping(self) -> bool:
        """It is time to end."""
        return self._stopped or (self._end_us is not None and self._robot.now_us >= self._end_us)

    def close(self) -> None:
        """Takes the ports away; keeps what the boards store, the card and, if there is one, its newest recording."""
        for port in self._ports.values():
            port.pull()
        self._folder.kept.save(self._robot, self._before)
        if self._robot.card():
            self.save_card()

    def _keep_eeprom(self) -> None:
        if (image := self._robot.eeprom()) != self._kept_eeprom:
            write_whole(self._folder.kept.eeprom, image)
            self._kept_eeprom = image

    def _keep_logger_memory(self) -> None:
        """The logger writes all its settings at once."""
        memory = self._robot.logger_memory()
        if memory != self._kept_memory:
            write_whole(self._folder.kept.logger_memory, memory)
            self._kept_memory = memory

    def _update_port(self, board: BoardIndex) -> None:
        if self._powered[board] and self._cabled[board]:
            self._ports[board].plug()
        else:
            self._ports[board].pull()
            self._untaken[board] = b""
