"""From a file to a `DropLog`."""

from __future__ import annotations

from collections.abc import Iterator
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.limits import BLOCK_BYTES

from . import errors
from .assembly import Assembly, assemble
from .blocks import LATEST_TIME_US, look
from .doubts import event_doubts, find_doubts, release_doubts
from .droplog import DropLog, Verdict
from .events import read_events
from .frozen import invalidate_by_events, invalidate_repeated
from .gaps import find_gaps
from .misaligned import find_shift
from .parts import completed, exchange_doubts, find_exchanges, invalidate_exchanged
from .records import Records, RecordsBuilder
from .release import find_release
from .source import CHUNK_BLOCKS, LogSource
from .survey import Progress, survey
from .timing import look_at_steps


def load(
    path: str | PathLike[str], *, session: int | None = None, progress: Progress | None = None
) -> DropLog:
    """Decode a log: the file off the card, or an image of the card.

    Every block whose CRC is right is used, in whichever sector it stands.

    Args:
        path: The file.
        session: Id of the recording to decode. Without it, of several in the file the newest: by the time
            of day in the headers where every unbroken one has it, else the one that stands first;
            `DropLog.chosen_by` says which rule it was, `DropLog.recordings` what else there is.
        progress: Called again and again while the file is read, with the share of it that was read since
            the call before (the shares come to 1).

    Raises:
        LogError: the file cannot be read, is no log, has no samples, or its values would be wrong; or
            the recording does not fit in memory.
        SessionError: there is no recording `session` in it.
    """
    with LogSource(Path(path)) as source:
        try:
            assembly, records = _read(source, session, progress)
        except MemoryError:
            raise errors.too_large(source.path) from None
    return _drop_log(source.path, assembly, records)


def _read(source: LogSource, session: int | None, progress: Progress | None) -> tuple[Assembly, Records]:
    found = survey(source, session, progress)
    looks_written = found.unusable.foreign or found.unusable.torn
    if not len(found.pieces) and looks_written and (shift := find_shift(source)):
        source.begin_at(shift)
        found = survey(source, session)
    assembly = assemble(source, found.pieces, found.unusable, found.census, session)
    if found.early_records is not None and np.array_equal(found.early_pieces, assembly.pieces):
        return assembly, found.early_records
    del found
    return assembly, _read_in_order(source, assembly)


def _read_in_order(source: LogSource, assembly: Assembly) -> Records:
    """The second pass, over the recording's blocks by number; their CRCs are checked once more."""
    total = int(assembly.pieces["count"].sum())
    builder = RecordsBuilder(total)
    buffer = memoryview(bytearray(min(total, CHUNK_BLOCKS) * BLOCK_BYTES))
    for parts in _chunks(assembly.pieces):
        filled = 0
        for position, _, count in parts:
            target = buffer[filled * BLOCK_BYTES : (filled + count) * BLOCK_BYTES]
            source.read_into(target, position * BLOCK_BYTES)
            filled += count
        data = buffer[: filled * BLOCK_BYTES]
        looked = look(data)
        expected = np.concatenate([np.arange(number, number + count) for _, number, count in parts])
        own = looked.usable & (looked.heads["session"] == assembly.session)
        if not own.all() or not np.array_equal(looked.heads["block_number"], expected):
            raise errors.changed_while_read(source.path)
        builder.take(data, looked.heads, own)
    return builder.records()


def _chunks(pieces: NDArray[np.void]) -> Iterator[list[tuple[int, int, int]]]:
    """The pieces again as (position, number, count), up to CHUNK_BLOCKS blocks of them at a time."""
    parts: list[tuple[int, int, int]] = []
    room = CHUNK_BLOCKS
    for piece in pieces:
        position, number, left = (int(piece[name]) for name in ("position", "number", "count"))
        while left:
            count = min(left, room)
            parts.append((position, number, count))
            position, number, left, room = position + count, number + count, left - count, room - count
            if not room:
                yield parts
                parts, room = [], CHUNK_BLOCKS
    if parts:
        yield parts


def _drop_log(path: Path, assembly: Assembly, records: Records) -> DropLog:
    if not len(records.t_us):
        raise errors.no_samples(path, assembly.session, assembly.other_sessions)
    found = records.headers.found(path, assembly.session)
    account, footer = records.account, records.footers.last
    first = assembly.pieces[0]
    gaps = find_gaps(account, records.t_us, footer, int(first["number"]) if first["position"] == 0 else 0)
    steps = look_at_steps(records.t_us, records.index, found.header.rate_hz)
    events = read_events(records.events)
    believed = [event for event in events if event.t_us < LATEST_TIME_US]
    header = completed(found.header, believed)
    exchanges = find_exchanges(header, believed)
    invalidate_exchanged(exchanges, records.t_us, records.imu_valid)
    invalidate_by_events(believed, records.t_us, records.imu_valid)
    invalidate_repeated(records.imu, records.index, records.t_us, records.imu_valid)
    release = find_release(believed, records.t_us, records.switch_open, gaps)
    doubts = (
        *find_doubts(found, records.footers, account, steps, assembly.set_aside),
        *event_doubts(len(events) - len(believed)),
        *exchange_doubts(header, exchanges),
        *release_doubts(release, believed, gaps, records.switch_open),
    )
    dropped = max(account.most_samples_dropped, footer.samples_dropped if footer else 0)
    before = [gap for gap in gaps if gap.late_start]
    lost = [gap for gap in gaps if not gap.late_start]
    # What the logger dropped shows as gaps too, except after the last block.
    samples_lost = max(sum(gap.samples for gap in lost), dropped - sum(gap.samples_dropped for gap in before))
    blocks_lost = account.last_number + 1 - account.block_count - sum(gap.blocks for gap in before)
    return DropLog(
        path=path,
        session=assembly.session,
        other_sessions=assembly.other_sessions,
        recordings=assembly.recordings,
        chosen_by=assembly.chosen_by,
        header=header,
        header_is_copy=found.is_copy,
        header_time_us=found.time_us,
        footer=footer,
        sample_index=records.index,
        t_us=records.t_us,
        release=release,
        imu_counts=records.imu,
        angle_counts=records.angle,
        imu_valid=records.imu_valid,
        angle_valid=records.angle_valid,
        switch_open=records.switch_open,
        clipped=records.clipped,
        events=events,
        gaps=gaps,
        late_rows=steps.late_rows,
        set_aside=assembly.set_aside,
        samples_lost=samples_lost,
        blocks_lost=blocks_lost,
        doubts=doubts,
        verdict=_verdict(
            bool(lost or samples_lost or blocks_lost or doubts), footer is not None and not before
        ),
    )


def _verdict(is_damaged: bool, has_both_ends: bool) -> Verdict:
    if is_damaged:
        return "damaged"
    return "complete" if has_both_ends else "truncated"
