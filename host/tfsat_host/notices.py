"""What a run has to say on the way to its result: the port through which a command, or a program, hears it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from datetime import UTC, datetime
from typing import Protocol


class Listener(Protocol):
    """Whoever hears what a person should know."""

    def note(self, text: str) -> None:
        """Something a person should know that is not the result."""

    def warn(self, text: str) -> None:
        """Show a warning."""


class Notices(Listener, Protocol):
    """Whoever wants to know what is done on the way."""

    def progress(
        self, description: str, total: float | None = None
    ) -> AbstractContextManager[Callable[[float], None]]:
        """Show progress while the block runs.

        The function that the block gets advances it by some units of `total`.
        """


class Silent:
    """Hears nothing."""

    def note(self, text: str) -> None:
        """Drops it."""

    warn = note

    def progress(
        self, description: str, total: float | None = None
    ) -> AbstractContextManager[Callable[[float], None]]:
        """Shows nothing."""
        del description, total
        return nullcontext(lambda _: None)


SILENT = Silent()


def printable(text: object) -> str:
    """Escape unprintable characters of a name.

    They could move the cursor or colour the screen.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in str(text))


def utc(unix_us: int) -> str:
    """Format a Unix time in µs as UTC to the second, or say that it is no possible time."""
    try:
        moment = datetime.fromtimestamp(unix_us / 1e6, UTC)
    except (OverflowError, ValueError, OSError):
        # A damaged header may hold any 64 bits.
        return f"at an impossible time of day ({unix_us} µs since 1970)"
    return moment.isoformat(sep=" ", timespec="seconds").replace("+00:00", " UTC")
