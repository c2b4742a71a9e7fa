"""The emulated robot for other programs: two serial ports as pseudo-terminals, and what a person can do to it."""

from __future__ import annotations

import errno
import fcntl
import os
import termios
import tty
from pathlib import Path

from tfsat_host.emulated.emulated_robot import US_PER_S, BoardIndex, EmulatedRobot, EmulationError, Reset
from tfsat_host.emulated.state import Kept, ServedFolder
from tfsat_host.errors import TfsatError
from tfsat_host.whole_file import write_whole

_CHUNK_BYTES = 4096


class PtyPort:
    """One port: it is there while `plug` holds, and any number of clients may open it in turn.

    Nothing here waits. While no client has the port open, what the board sends is lost, as on a USB
    port that no program has open.

    Args:
        link: Where clients find the port. It is replaced when the port comes and removed when it goes.
    """

    def __init__(self, link: Path) -> None:
        self.link = link
        self._master: int | None = None
        self._device = ""
        self._client = False
        self._unsent = b""

    @property
    def device(self) -> str:
        """The pseudo-terminal's own path; empty while pulled."""
        return self._device

    @property
    def is_open(self) -> bool:
        """A client had the port open at the last `read`."""
        return self._client

    @property
    def has_room(self) -> bool:
        """All that the board has sent was passed on, so that it may send more."""
        return not self._unsent

    def plug(self) -> None:
        """Makes the port. Nothing changes if it is there."""
        if self._master is not None:
            return
        self._master, slave = os.openpty()
        try:
            # Raw: a line discipline would echo, translate and buffer the bytes of a binary protocol.
            tty.setraw(slave)
            os.set_blocking(self._master, False)
            self._device = os.ttyname(slave)
            self._replace_link(_while_this_process_lives(self._device))
        finally:
            # Keep no slave end open: only then does reading the master tell when no client has one.
            os.close(slave)

    def pull(self) -> None:
        """Ends the port as pulling a USB cable does: a client's next read or write fails."""
        if self._master is None:
            return
        # The link goes first, so that no client opens a port that is about to end.
        self.link.unlink(missing_ok=True)
        os.close(self._master)
        self._master = None
        self._device = ""
        self._client = False
        self._unsent = b""

    def read(self) -> bytes:
        """Read what a client has sent, and notice clients that come and go."""
        if self._master is None:
            return b""
        try:
            data = os.read(self._master, _CHUNK_BYTES)
        except BlockingIOError:
            # Nothing to read, yet no EIO either: a client has the port open and is silent.
            self._client = True
            return b""
        except OSError as error:
            if error.errno != errno.EIO:  # Linux's word for: no client has it open
                raise
            data = b""
        if data:
            self._client = True
        elif self._client:
            self._client = False
            # The last client has just gone: clean up once, before another one opens the port.
            self._make_ready_for_next()
        return data

    def write(self, data: bytes) -> None:
        """Passes on what the board sent; keeps what a slow client has no room for."""
        if self._master is None or not self._client:
            # Without a reader the bytes are lost, as on a USB port; kept, they would greet the next client.
            self._unsent = b""
            return
        self._unsent += data
        if not self._unsent:
            return
        try:
            # The kernel may take a part: what is left goes first the next time.
            self._unsent = self._unsent[os.write(self._master, self._unsent) :]
        except BlockingIOError:
            return
        except OSError as error:
            if error.errno != errno.EIO:
                raise
            self._unsent = b""  # the client has just gone; the next read notices

    def _make_ready_for_next(self) -> None:
        """Undoes what a client may leave behind: unread bytes, line settings, a claim (TIOCEXCL).

        The kernel keeps them as long as the master lives. A claim that cannot be lifted (that takes an
        open, which it forbids) leaves only a new pseudo-terminal.
        """
        self._unsent = b""
        try:
            slave = os.open(self.device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError:
            # The client's exclusive claim forbids the open that would lift it: make a new pseudo-terminal.
            self.pull()
            self.plug()
            return
        try:
            fcntl.ioctl(slave, termios.TIOCNXCL)
            termios.tcflush(slave, termios.TCIFLUSH)
            tty.setraw(slave, termios.TCSANOW)  # its default would wait for output to drain
        finally:
            os.close(slave)

    def _replace_link(self, device: str) -> None:
        new = self.link.with_name(f".{self.link.name}.new")
        # Rename a new link over the old one: at no moment does a client find none.
        new.unlink(missing_ok=True)
        new.symlink_to(device)
        new.replace(self.link)


def _while_this_process_lives(device: str) -> str:
    """Return a path to the device that ends with this process, where the system has one (Linux).

    A killed process leaves its links behind, and the system soon gives their pseudo-terminals to others.
    """
    bound = f"/proc/{os.getpid()}/root{device}"
    return bound if Path(bound).exists() else device


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
            # First what the board had no room for: not reading more passes its back pressure on.
            data = self._untaken[board] or port.read()
            # The sequencer's own USB controller sees by DTR whether a program has its port open.
            if board == BoardIndex.SEQUENCER:
                self._robot.set_port(port.is_open)
            if data:
                self._untaken[board] = data[self._robot.write(board, data) :]
        self._robot.advance(STEP_US)
        for board, port in self._ports.items():
            # While a client is slow, answers stay in the board, whose buffers fill as on a cable.
            answer = self._robot.read(board) if port.has_room else b""
            if answer and board == BoardIndex.SEQUENCER:
                self._keep_eeprom()  # what a host has read back outlives even a kill -9 of this process
            port.write(answer)
        if self._robot.now_us - self._memory_look_us >= _QUIET_US:
            self._memory_look_us = self._robot.now_us
            # No write since the last look: no upload is half done, so the image is consistent.
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
        # Overwrite only copies that this server made itself: anything else may be the user's recording.
        if target.exists() and target not in self._copies:
            raise TfsatError(
                what=f"{target} exists.", meaning="It is unchanged.", next_step="Name another file."
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
        """Write the logger's settings to their file if they have changed; the logger writes them all at once."""
        memory = self._robot.logger_memory()
        if memory != self._kept_memory:
            write_whole(self._folder.kept.logger_memory, memory)
            self._kept_memory = memory

    def _update_port(self, board: BoardIndex) -> None:
        # A port is there only with both supply and cable.
        if self._powered[board] and self._cabled[board]:
            self._ports[board].plug()
        else:
            self._ports[board].pull()
            # Bytes under way are lost with the connection; sent after a restart they would be half a frame.
            self._untaken[board] = b""
