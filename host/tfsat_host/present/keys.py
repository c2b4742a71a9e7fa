"""Single keys of a terminal, without Enter: for people whose other hand holds a robot."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from typing import TextIO


@contextlib.contextmanager
def single_keys(terminal: TextIO) -> Iterator[Callable[[], str]]:
    """Yield a function that waits for one key; Enter is a line feed, the end of the terminal an empty text."""
    try:
        import termios
        import tty
    except ImportError:
        # Windows: its console gives single keys by itself.
        import msvcrt

        yield lambda: msvcrt.getwch().replace("\r", "\n")  # type: ignore[attr-defined,unused-ignore]
        return
    number = terminal.fileno()
    before = termios.tcgetattr(number)
    try:
        # Ctrl-C stays a signal in this mode.
        tty.setcbreak(number)
        yield lambda: os.read(number, 1).decode(errors="replace").replace("\r", "\n")
    finally:
        termios.tcsetattr(number, termios.TCSADRAIN, before)
