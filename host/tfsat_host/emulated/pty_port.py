"""A board's USB serial port as a pseudo-terminal behind a symbolic link."""

from __future__ import annotations

import errno
import fcntl
import os
import termios
import tty
from pathlib import Path

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
            tty.setraw(slave)
            os.set_blocking(self._master, False)
            self._device = os.ttyname(slave)
            self._replace_link(_while_this_process_lives(self._device))
        finally:
            os.close(slave)

    def pull(self) -> None:
        """Ends the port as pulling a USB cable does: a client's next read or write fails."""
        if self._master is None:
            return
        self.link.unlink(missing_ok=True)
        os.close(self._master)
        self._master = None
        self._device = ""
        self._client = False
        self._unsent = b""

    def read(self) -> bytes:
        """What a client has sent; notices clients that come and go."""
        if self._master is None:
            return b""
        try:
            data = os.read(self._master, _CHUNK_BYTES)
        except BlockingIOError:
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
            self._make_ready_for_next()
        return data

    def write(self, data: bytes) -> None:
        """Passes on what the board sent; keeps what a slow client has no room for."""
        if self._master is None or not self._client:
            self._unsent = b""
            return
        self._unsent += data
        if not self._unsent:
            return
        try:
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
        new.unlink(missing_ok=True)
        new.symlink_to(device)
        new.replace(self.link)


def _while_this_process_lives(device: str) -> str:
    """The same device under a path that ends with this process, where the system has one (Linux).

    A killed process leaves its links behind, and the system soon gives their pseudo-terminals to others.
    """
    bound = f"/proc/{os.getpid()}/root{device}"
    return bound if Path(bound).exists() else device
