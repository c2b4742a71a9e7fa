"""What recordings are called."""

from __future__ import annotations

from tfsat_host.protocol.messages import LogEntry

RAM = 0
"""The number of what the logger's RAM holds."""


def recording_name(number: int) -> str:
    """The card's name for a recording."""
    return f"DROP{number:04}.BIN"


def copy_name(entry: LogEntry) -> str:
    """The name that a fetched copy gets: the card's; that of RAM tells its session."""
    return f"RAM-{entry.session:08x}.BIN" if entry.number == RAM else recording_name(entry.number)


def entry_words(entry: LogEntry) -> str:
    """For people, in a sentence."""
    return "what RAM holds" if entry.number == RAM else recording_name(entry.number)
