"""From a file to a `DropLog`."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.limits import BLOCK_BYTES
from tfsat_host.protocol.log_layout import HEADER_BYTES
from tfsat_host.protocol.messages import LogFooter

from . import errors
from .assembly import assemble
from .blocks import scan
from .doubts import find_doubts, release_doubts
from .droplog import DropLog, Verdict, unpack_flags
from .events import read_events
from .gaps import Gap, find_gaps
from .header import find_header
from .records import Records, read_records
from .release import find_release
from .source import LogSource


def load(path: str | PathLike[str], *, session: int | None = None) -> DropLog:
    """Decode a log: the file off the card, or an image of the card.

    Every block whose CRC is right is used, wherever it stands. Of several recordings in the file,
    the newest is decoded (see `assembly`), or the one with id `session`.

    Raises:
        LogError: the file cannot be read, is no log, has no samples, or its values would be wrong.
        SessionError: there is no recording `session` in it.
    """
    with LogSource(Path(path)) as source:
        assembly = assemble(scan(source), source.path, source.size_bytes, session)
        entries = assembly.entries
        data = np.flatnonzero(entries["kind"] == BlockKind.DATA)
        if not entries["sample_count"][data].any():
            raise errors.no_samples(source.path, assembly.session, assembly.other_sessions)
        found = find_header(source, assembly, BlockKind.HEADER)
        footers = _footers(source, entries)
        records = read_records(source, entries[data])
    numbers = entries["number"].astype(np.int64)
    sample_count = entries["sample_count"][data].astype(np.int64)
    footer = footers[-1][1] if footers else None
    gaps = find_gaps(numbers, data, sample_count, records, footer)
    imu_valid, angle_valid, switch_open, clipped = unpack_flags(records.flags)
    events = read_events(records.events)
    release = find_release(events, records.t_us, switch_open, gaps)
    doubts = (
        *find_doubts(found, footers, numbers, sample_count, records, assembly.set_aside),
        *release_doubts(release, events, gaps, switch_open),
    )
    samples_lost = max(sum(gap.samples for gap in gaps), _samples_dropped(records, footer))
    blocks_lost = int(numbers[-1]) + 1 - len(numbers)
    return DropLog(
        path=source.path,
        session=assembly.session,
        other_sessions=assembly.other_sessions,
        header=found.header,
        header_is_copy=found.is_copy,
        footer=footer,
        sample_index=records.index,
        t_us=records.t_us,
        release=release,
        imu_counts=records.imu,
        angle_counts=records.angle,
        imu_valid=imu_valid,
        angle_valid=angle_valid,
        switch_open=switch_open,
        clipped=clipped,
        events=events,
        gaps=gaps,
        set_aside=assembly.set_aside,
        samples_lost=samples_lost,
        blocks_lost=blocks_lost,
        doubts=doubts,
        verdict=_verdict(gaps, samples_lost + blocks_lost, doubts, footer),
    )


def _footers(source: LogSource, entries: NDArray[np.void]) -> list[tuple[int, LogFooter]]:
    """(block number, footer) of each footer block; a clean recording has one."""
    footers = []
    for entry in entries[entries["kind"] == BlockKind.FOOTER]:
        target = memoryview(bytearray(LogFooter.SIZE))
        body = source.read_into(target, int(entry["position"]) * BLOCK_BYTES + HEADER_BYTES)
        footers.append((int(entry["number"]), LogFooter.decode(bytes(body))))
    return footers


def _samples_dropped(records: Records, footer: LogFooter | None) -> int:
    """Samples that the logger says it dropped; they show as gaps too, except after the last block."""
    return max(int(records.block_samples_dropped.max()), footer.samples_dropped if footer else 0)


def _verdict(gaps: tuple[Gap, ...], lost: int, doubts: tuple[str, ...], footer: LogFooter | None) -> Verdict:
    if gaps or lost or doubts:
        return "damaged"
    return "truncated" if footer is None else "complete"
