"""Recordings for people: sizes, times of day, tables."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from tfsat_host.devices.log_names import RAM, copy_name
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.messages import LogEntry
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


def entry_as_dict(entry: LogEntry) -> dict[str, Any]:
    """For `--json`."""
    return {
        "number": entry.number,
        "in_ram": entry.number == RAM,
        "name": copy_name(entry),
        "start": clock_iso(entry.wall_clock_us),
        "bytes": entry.blocks * BLOCK_BYTES,
        "closed": bool(entry.closed),
        "session": f"{entry.session:08x}",
    }


def entry_row(entry: LogEntry, copy: str) -> tuple[object, ...]:
    """A line of `log list`."""
    in_ram = entry.number == RAM
    return (
        "ram" if in_ram else str(entry.number),
        "(in RAM)" if in_ram else copy_name(entry),
        clock_words(entry.wall_clock_us),
        size_words(entry.blocks * BLOCK_BYTES),
        bool(entry.closed),
        f"{entry.session:08x}",
        copy,
    )


ENTRY_COLUMNS = ("number", "file", "start", "size", "closed", "session", "fetched to")
