"""The native sequencer at a pseudo-terminal: commands as processes, and resets that a served robot has not."""

from __future__ import annotations

import os
import select
import threading
import tty
from collections.abc import Callable
from types import TracebackType
from typing import Self

from tests.fixtures.sequencer.board import Board
from tfsat_host.protocol.framing import FrameReceiver

STEP_US = 1000


class BoardOnPty:
    """Serves `board` while the `with` block runs; only in between may a test touch the board itself.

    Args:
        board: Its virtual time passes as bytes come, and a millisecond with each look for them.
        after: What happens to the board once it has had a request of that type.
    """

    def __init__(self, board: Board, after: dict[int, Callable[[], object]] | None = None) -> None:
        self._board = board
        self._after = after or {}
        self._receiver = FrameReceiver()
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._serve)

    def __enter__(self) -> Self:
        self._master, self._slave = os.openpty()
        # Raw: no terminal setting may change the bytes between board and command.
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ending.set()
        self._thread.join(10)
        os.close(self._slave)
        os.close(self._master)

    def _serve(self) -> None:
        while not self._ending.is_set():
            # Bytes first, then a millisecond of virtual time, whether or not somebody writes.
            if select.select([self._master], [], [], 0.001)[0]:
                self._pass_on(os.read(self._master, 1000))
            self._board.run(STEP_US)
            if answer := self._board.read():
                os.write(self._master, answer)

    def _pass_on(self, data: bytes) -> None:
        unsent_bytes = data
        while unsent_bytes:
            # The board takes as much as its buffer has room for: the rest is offered again.
            unsent_bytes = unsent_bytes[self._board.write(unsent_bytes) :]
            self._board.run(STEP_US)
            if answer := self._board.read():
                os.write(self._master, answer)
        # What happens to the board comes after its answer has gone out.
        for frame in self._receiver.feed(data):
            self._after.get(frame.type, lambda: None)()
