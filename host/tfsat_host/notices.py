"""What a run has to say on the way to its result: the port through which a command, or a program, hears it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from datetime import UTC, datetime
from typing import Any, Protocol

from tfsat_host.next_step import Advice, NextStep

_LISTED = 20
_CHOSEN = {
    "asked for": "which was asked for",
    "time of day": "the newest by the time of day in the headers",
    "header": "the first in the file that has a header, without which nothing can be decoded",
    "place": "the first in the file, because not every one of them tells its time of day",
}


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


def recordings_lines(
    facts: Mapping[str, Any], file: object, command: str = "decode", verb: str = "Decoded"
) -> Iterator[str]:
    """Yield lines that list a file's several recordings, the one taken and how to get another.

    Args:
        facts: The facts of the recording taken, by `sdlog.summary.metadata`.
        file: The file's name.
        command: The command that asks.
        verb: The verb for what it did with that recording.
    """
    recordings, others = facts["recordings"], len(facts["other_sessions"])
    if not others:
        return
    yield f"{file} holds {others + 1} recordings. {verb}: {facts['session']}, {_CHOSEN[facts['chosen_by']]}."
    for entry in recordings[:_LISTED]:
        started = "-" if entry["started_unix_us"] is None else utc(entry["started_unix_us"])
        state = (
            "parts of it" if not entry["is_unbroken"] else "whole" if entry["has_end"] else "without an end"
        )
        yield (
            f"  {entry['session']}  {started:<23}  about {entry['samples']} samples in "
            f"{entry['blocks']} blocks, {state}"
        )
    if others + 1 > min(len(recordings), _LISTED):
        yield f"  … and {others + 1 - min(len(recordings), _LISTED)} more (--json names them)."
    yield Advice("Another one: ", NextStep(command, (str(file), "--session", "ID")))


def utc(unix_us: int) -> str:
    """Format a Unix time in µs as UTC to the second, or say that it is no possible time."""
    try:
        moment = datetime.fromtimestamp(unix_us / 1e6, UTC)
    except (OverflowError, ValueError, OSError):
        # A damaged header may hold any 64 bits.
        return f"at an impossible time of day ({unix_us} µs since 1970)"
    return moment.isoformat(sep=" ", timespec="seconds").replace("+00:00", " UTC")
