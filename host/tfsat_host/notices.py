"""What a run has to say on the way to its result: the port through which a command, or a program, hears it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from datetime import UTC, datetime
from typing import Any, Protocol

_LISTED = 20
_CHOSEN = {
    "asked for": "which was asked for",
    "time of day": "the newest by the time of day in the headers",
    "header": "the first in the file that has a header, without which nothing can be decoded",
    "place": "the first in the file, because not every one of them tells its time of day",
}


class Notices(Protocol):
    """Whoever wants to know what is done on the way."""

    def note(self, text: str) -> None:
        """Something a person should know that is not the result."""

    def warn(self, text: str) -> None:
        """A warning."""

    def progress(
        self, description: str, total: float | None = None
    ) -> AbstractContextManager[Callable[[float], None]]:
        """While the block runs this is going on; the function advances it by some units of `total`."""


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
    """A name as it can be shown: what would move the cursor or colour the screen is written as an escape."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in str(text))


def recordings_lines(
    facts: Mapping[str, Any], file: object, command: str = "decode", done: str = "Decoded"
) -> Iterator[str]:
    """That a file holds several recordings, which one the command took and how to get another.

    Args:
        facts: Of the one that was taken, by `sdlog.summary.metadata`.
        file: Its name.
        command: Which asks.
        done: What it did with that recording.
    """
    recordings, others = facts["recordings"], len(facts["other_sessions"])
    if not others:
        return
    yield f"{file} holds {others + 1} recordings. {done}: {facts['session']}, {_CHOSEN[facts['chosen_by']]}."
    for one in recordings[:_LISTED]:
        started = "-" if one["started_unix_us"] is None else utc(one["started_unix_us"])
        state = "parts of it" if not one["is_unbroken"] else "whole" if one["has_end"] else "without an end"
        yield (
            f"  {one['session']}  {started:<23}  about {one['samples']} samples in {one['blocks']} blocks, {state}"
        )
    if others + 1 > min(len(recordings), _LISTED):
        yield f"  … and {others + 1 - min(len(recordings), _LISTED)} more (--json names them)."
    yield f"Another one: tfsat-host {command} {file} --session ID"


def utc(unix_us: int) -> str:
    """A time of day to the second, or that it is none."""
    try:
        moment = datetime.fromtimestamp(unix_us / 1e6, UTC)
    except (OverflowError, ValueError, OSError):
        return f"at an impossible time of day ({unix_us} µs since 1970)"
    return moment.isoformat(sep=" ", timespec="seconds").replace("+00:00", " UTC")
