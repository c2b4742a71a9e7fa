"""The debug log: a line for each frame, file and decision.

`--debug` (or TFSAT_DEBUG=1) shows it on stderr; the last lines stand in the report of a crash in any case.
"""

from __future__ import annotations

import logging
import sys
from collections import deque

MAX_RECENT_LINES = 200
STREAM = 5
"""The level of frames that come by the hundred each second: shown by `--debug`, left out of a crash report."""
_LINE = logging.Formatter("%(relativeCreated)9.1f ms %(name)s: %(message)s")
_LOGGER = logging.getLogger("tfsat_host")


class _RecentLines(logging.Handler):
    """Keeps the newest records; they are only formatted when somebody wants to read them."""

    def __init__(self) -> None:
        super().__init__(logging.DEBUG)
        self.records: deque[logging.LogRecord] = deque(maxlen=MAX_RECENT_LINES)

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a record in the place of the oldest one."""
        self.records.append(record)


_recent = _RecentLines()


def start(*, shown: bool) -> None:
    """Begin a command's log; `shown`: on stderr, too."""
    _recent.records.clear()
    _LOGGER.handlers = [_recent]
    # What a library logs is not ours, and what we log is of no use to a program that imports us.
    _LOGGER.propagate = False
    _LOGGER.setLevel(STREAM if shown else logging.DEBUG)
    if shown:
        handler = logging.StreamHandler(sys.stderr)
        handler.setFormatter(_LINE)
        _LOGGER.addHandler(handler)


def recent_lines() -> list[str]:
    """Return the newest lines, the oldest of them first."""
    return [_LINE.format(record) for record in _recent.records]
