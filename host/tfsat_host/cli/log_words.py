"""Recordings for people: sizes, times of day, tables."""

from __future__ import annotations

from datetime import datetime

from tfsat_host.devices.log_names import RAM, copy_name
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.quantity import Column, Columns
from tfsat_host.units import US_PER_S


def clock_words(unix_us: int) -> str:
    """A time of day by this computer's time zone; a dash where nobody has set it."""
    if not unix_us:
        return "–"
    return f"{datetime.fromtimestamp(unix_us // US_PER_S).astimezone():%Y-%m-%d %H:%M:%S}"


def clock_iso(unix_us: int) -> str | None:
    """For `--json`."""
    if not unix_us:
        return None
    return datetime.fromtimestamp(unix_us / US_PER_S).astimezone().isoformat(timespec="milliseconds")


def size_words(n_bytes: int) -> str:
    """Bytes for people."""
    return f"{n_bytes / 2**20:.1f} MiB" if n_bytes >= 2**20 else f"{n_bytes / 2**10:.1f} KiB"


ENTRIES: Columns = (
    Column("number", "number", words=lambda entry: "ram" if entry.number == RAM else str(entry.number)),
    Column("in_ram", of=lambda entry: entry.number == RAM),
    Column("name", "file", of=copy_name, words=lambda e: "(in RAM)" if e.number == RAM else copy_name(e)),
    Column(
        "start",
        "start",
        of=lambda entry: clock_iso(entry.wall_clock_us),
        words=lambda entry: clock_words(entry.wall_clock_us),
    ),
    Column(
        "bytes",
        "size",
        of=lambda entry: entry.blocks * BLOCK_BYTES,
        words=lambda entry: size_words(entry.blocks * BLOCK_BYTES),
    ),
    Column("closed", "closed", of=lambda entry: bool(entry.closed)),
    Column("session", "session", of=lambda entry: f"{entry.session:08x}"),
)
"""Recordings on a card."""
