"""The served robot in real time: its pace, and its control lines by a socket for many and by the terminal."""

from __future__ import annotations

import os
import select
import socket
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path

from tfsat_host.emulated.control import ControlLines, LineTooLong
from tfsat_host.emulated.emulated_robot import US_PER_S
from tfsat_host.emulated.server import STEP_US, RobotServer
from tfsat_host.errors import TfsatError

_CHUNK_BYTES = 4096


class ControlSocket:
    """A unix socket that takes any number of connections; nothing here waits."""

    def __init__(self, path: Path, server: RobotServer) -> None:
        """Listens at `path`. Raises TfsatError if the system refuses such a path."""
        self._path = path
        self._server = server
        self._listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._listener.bind(str(path))
            self._listener.listen()
        except OSError as error:
            self._listener.close()
            # Mostly the path is too long: the address of a unix socket holds about a hundred bytes.
            raise TfsatError(
                what=f"The control socket {path} cannot be made: {error.strerror or error}.",
                meaning="The emulated robot was not started.",
                next_step="Name a folder with a shorter path on a local disk with --dir.",
            ) from error
        # Never block: one thread steps the robot and serves all connections.
        self._listener.setblocking(False)
        self._connections: list[_Connection] = []

    def waits_on(self) -> list[int]:
        """File descriptors whose input matters now."""
        reading = [link.socket.fileno() for link in self._connections if link.reading]
        return [self._listener.fileno(), *reading]

    def service(self, ready: Iterable[int]) -> None:
        """Takes what has come on these descriptors and gives the replies that are due."""
        ready = set(ready)
        if self._listener.fileno() in ready:
            self._accept()
        for link in self._connections:
            link.service(link.socket.fileno() in ready)
        # A closed socket's descriptor is -1: its connection is forgotten.
        self._connections = [link for link in self._connections if link.socket.fileno() >= 0]

    def close(self) -> None:
        """Ends all connections and removes the socket."""
        for link in self._connections:
            link.socket.close()
        self._listener.close()
        self._path.unlink(missing_ok=True)

    def _accept(self) -> None:
        try:
            accepted, _ = self._listener.accept()
        except (BlockingIOError, ConnectionAbortedError):
            return
        # An accepted socket does not inherit it: a client that reads no replies must not stop the robot.
        accepted.setblocking(False)
        self._connections.append(_Connection(accepted, ControlLines(self._server)))


class _Connection:
    """One sender on the socket; its socket is closed when it has gone or does not follow the protocol."""

    def __init__(self, accepted: socket.socket, lines: ControlLines) -> None:
        self.socket = accepted
        self._lines = lines
        self._ended = False

    @property
    def reading(self) -> bool:
        return not self._ended and self._lines.done

    def service(self, readable: bool) -> None:
        try:
            if readable:
                self._take(self.socket.recv(_CHUNK_BYTES))
            for reply in self._lines.replies():
                self.socket.send(reply.encode() + b"\n")
        except LineTooLong:
            self.socket.close()
        except OSError:  # gone, or it sends lines and reads no reply
            self.socket.close()
        else:
            # A sender may close its side and still read: close only when it has all its replies.
            if self._ended and self._lines.done:
                self.socket.close()

    def _take(self, data: bytes) -> None:
        if data:
            self._lines.feed(data)
        else:
            self._lines.end()
            self._ended = True


class TypedLines:
    """Standard input. Its end ends nothing: a command in the background has none.

    Args:
        server: What the lines act on.
        say: Shows a reply.
        descriptor: What to read; None where there is no standard input.
    """

    def __init__(self, server: RobotServer, say: Callable[[str], None], descriptor: int | None) -> None:
        self._lines = ControlLines(server)
        self._say = say
        self._descriptor = descriptor

    def waits_on(self) -> list[int]:
        """Return the descriptor to wait on, or none while input is ignored.

        In the background, a terminal belongs to the foreground.
        """
        if self._descriptor is None or not self._lines.done or _another_has_terminal(self._descriptor):
            return []
        return [self._descriptor]

    def service(self, ready: Iterable[int]) -> None:
        """Takes what was typed and shows the replies that are due."""
        if self._descriptor is not None and self._descriptor in ready:
            self._take(self._descriptor)
        for reply in self._lines.replies():
            self._say(reply)

    def _take(self, descriptor: int) -> None:
        try:
            data = os.read(descriptor, _CHUNK_BYTES)
            self._lines.feed(data)
        except LineTooLong:
            self._say("error This line is too long; nothing more is read from here.")
            data = b""
        except OSError:  # the terminal has gone
            data = b""
        if not data:
            self._lines.end()
            self._descriptor = None


def standard_input() -> int | None:
    """Return the descriptor of standard input; None if this process was started without one."""
    return None if sys.stdin is None else sys.stdin.fileno()


def _another_has_terminal(descriptor: int) -> bool:
    """Reading a terminal from the background would stop this process."""
    try:
        return os.isatty(descriptor) and os.tcgetpgrp(descriptor) != os.getpgrp()
    except OSError:
        # The terminal is not this session's any more: leave it alone.
        return True


def serve(
    server: RobotServer, control: ControlSocket, typed_lines: TypedLines, on_lag: Callable[[float], None]
) -> None:
    """Runs the server in real time until it is stopped.

    `on_lag` is called once, with seconds, when this computer is too slow. Raises EmulationError: the emulated
    processor crashed.
    """
    pacer = Pacer(time.monotonic())
    while not server.stopping:
        # Catch up with the clock, then sleep until the next step is due or a line comes.
        for _ in range(pacer.steps_due(time.monotonic())):
            server.step()
        if pacer.new_lag():
            on_lag(pacer.lag_s)
        waited = [*control.waits_on(), *typed_lines.waits_on()]
        ready, _, _ = select.select(waited, [], [], pacer.wait_s(time.monotonic()))
        control.service(ready)
        typed_lines.service(ready)


MAX_BACKLOG_S = 0.25
"""What is made up for after a hiccup; it is also how long a host waits for an answer."""
TOLERATED_LAG_S = 0.5
"""Lag in all that is not reported."""


class Pacer:
    """Says how many steps are due, and when the next one is.

    The clock is the caller's: seconds from any origin, never going back. What the computer cannot make
    up for within MAX_BACKLOG_S is given up: virtual time then lags for good, by `lag_s`.

    Args:
        now_s: The clock at virtual time zero.
    """

    def __init__(self, now_s: float) -> None:
        self._origin_s = now_s
        self._steps = 0
        self._lag_reported = False
        self.lag_s = 0.0

    def steps_due(self, now_s: float) -> int:
        """Steps of STEP_US to run now; counted as run."""
        behind_s = now_s - self._time_of(self._steps)
        # Too far behind, as after a stopped process: move the origin instead of racing through the gap.
        if behind_s > MAX_BACKLOG_S:
            given_up_s = behind_s - MAX_BACKLOG_S
            self._origin_s += given_up_s
            self.lag_s += given_up_s
            behind_s = MAX_BACKLOG_S
        # Whole steps counted from the origin: fractions fall due later, so the pace does not drift.
        due = max(0, int(behind_s * US_PER_S / STEP_US))
        self._steps += due
        return due

    def wait_s(self, now_s: float) -> float:
        """Seconds until the next step is due; 0 if one is."""
        return max(0.0, self._time_of(self._steps + 1) - now_s)

    def new_lag(self) -> bool:
        """True once: when the lag is worth reporting."""
        if self._lag_reported or self.lag_s < TOLERATED_LAG_S:
            return False
        self._lag_reported = True
        return True

    def _time_of(self, steps: int) -> float:
        return self._origin_s + steps * STEP_US / US_PER_S
