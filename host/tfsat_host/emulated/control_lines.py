"""Control lines from several people at once: each has a turn of its own, each line one reply."""

from __future__ import annotations

from collections import deque

from tfsat_host.emulated.control import Bench, Reply, execute

LONGEST_LINE = 4096
"""Bytes of one line; more is no line of this protocol."""


class LineTooLong(ValueError):
    """The sender does not speak this protocol."""


class ControlLines:
    """One sender's lines, in order: a `wait` holds back those after it, and no one else's."""

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self._partial = b""
        self._lines: deque[str] = deque()
        self._pending: Reply | None = None

    def feed(self, data: bytes) -> None:
        """Takes what has arrived, in pieces of any size. Raises LineTooLong."""
        *lines, self._partial = (self._partial + data).split(b"\n")
        if len(self._partial) > LONGEST_LINE:
            raise LineTooLong
        self._lines.extend(line.decode(errors="replace") for line in lines)

    def end(self) -> None:
        """No more will come: a last line without its end counts."""
        if self._partial:
            self._lines.append(self._partial.decode(errors="replace"))
            self._partial = b""

    @property
    def done(self) -> bool:
        """Every line has its reply."""
        return self._pending is None and not self._lines

    def replies(self) -> list[str]:
        """Does what can be done now; the replies that are due."""
        due: list[str] = []
        while True:
            if self._pending is not None:
                if self._pending.due is not None and not self._pending.due():
                    return due
                due.append(self._pending.text)
                self._pending = None
            if not self._lines:
                return due
            self._pending = execute(self._lines.popleft(), self._bench)
