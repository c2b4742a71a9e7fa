"""From a file to a `DropLog`.

A first pass looks at every block and decodes in passing what seems to be the recording. Where that turns out to be
something else than the recording's blocks in order, a second pass reads those.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tfsat_host.arrays import RecordArray
from tfsat_host.protocol.limits import BLOCK_BYTES

from .block_decoder import BlockDecoder
from .blocks import LATEST_TIME_US, BlockScan, PieceList, as_pieces, look, look_at_tail
from .contradictions import block_doubts, exchange_doubts, release_doubts, steps_of_time
from .droplog import DropLog, Verdict
from .events import complete_header, find_exchanges, read_events
from .imu_validity import invalidate_by_events, invalidate_exchanged, invalidate_repeated
from .log_errors import LogError, changed_while_read
from .recordings import Assembly, Census, assemble
from .release import find_release
from .source import CHUNK_BLOCKS, LogSource, find_shift

DECODED_AT_ONCE_BYTES = 2 << 30
"""In a larger file the recording is first looked for, so that no memory is reserved for what is not one."""

Progress = Callable[[float], object]


class Survey(NamedTuple):
    """What a file holds.

    Attributes:
        pieces: All usable blocks, in the order of the file; (k,) of PIECE.
        unusable: The others, counted by reason.
        census: What each recording has.
        early: What was decoded in passing; None if nothing was.
    """

    pieces: RecordArray
    unusable: Counter[str]
    census: Census
    early: _EarlyDecoder | None


def load(
    path: str | PathLike[str], *, session: int | None = None, progress: Progress | None = None
) -> DropLog:
    """Decode a log: the file off the card, or an image of the card.

    Every block whose CRC is right is used, in whichever sector it stands.

    Args:
        path: The file.
        session: Id of the recording to decode. Without it, of several in the file the newest: by the time
            of day in the headers where every unbroken one has it, else the one that stands first;
            `DropLog.chosen_by` is that rule, `DropLog.recordings` what else there is.
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
            raise LogError(
                f"The recording in {source.path} does not fit in this computer's memory.",
                "Close other programs, or decode on a computer with more memory: "
                "a recording takes about 1.3 times its file.",
                "Nothing was decoded; the file itself may be in order.",
            ) from None
    return _drop_log(source.path, assembly, records)


def _read(source: LogSource, session: int | None, progress: Progress | None) -> tuple[Assembly, BlockDecoder]:
    survey_result = survey(source, session, progress)
    looks_written = survey_result.unusable["foreign"] or survey_result.unusable["torn"]
    if not len(survey_result.pieces) and looks_written and (shift := find_shift(source)):
        # Nothing at multiples of the block size, though something is there: the image is shifted.
        source.begin_at(shift)
        survey_result = survey(source, session)
    assembly = assemble(source, survey_result.pieces, survey_result.unusable, survey_result.census, session)
    if survey_result.early is not None and np.array_equal(survey_result.early.pieces.all(), assembly.pieces):
        # What was decoded in passing is the recording, block by block: no second pass.
        return assembly, survey_result.early.builder
    # Free the columns decoded in passing before the second pass allocates its own.
    del survey_result
    return assembly, _read_in_order(source, assembly)


def _read_in_order(source: LogSource, assembly: Assembly) -> BlockDecoder:
    """Decode the recording's blocks by number in a second pass, which checks their CRCs once more."""
    total = int(assembly.pieces["count"].sum())
    builder = BlockDecoder(total)
    buffer = memoryview(bytearray(min(total, CHUNK_BLOCKS) * BLOCK_BYTES))
    for parts in _chunks(assembly.pieces):
        filled = 0
        # Many short pieces share a buffer, so that a scattered recording is decoded in large chunks too.
        for position, _, count in parts:
            target = buffer[filled * BLOCK_BYTES : (filled + count) * BLOCK_BYTES]
            source.read_into(target, position * BLOCK_BYTES)
            filled += count
        data = buffer[: filled * BLOCK_BYTES]
        looked = look(data)
        # The file may have changed since the survey: CRC, session and numbers must be as they were.
        expected = np.concatenate([np.arange(number, number + count) for _, number, count in parts])
        own = looked.usable & (looked.heads["session"] == assembly.session)
        if not own.all() or not np.array_equal(looked.heads["block_number"], expected):
            raise changed_while_read(source.path)
        builder.take(data, looked.heads, own)
    return builder


def _chunks(pieces: RecordArray) -> Iterator[list[tuple[int, int, int]]]:
    """Yield the pieces as lists of (position, number, count), up to CHUNK_BLOCKS blocks per list."""
    parts: list[tuple[int, int, int]] = []
    room = CHUNK_BLOCKS
    for piece in pieces:
        position, number, blocks_left = (int(piece[name]) for name in ("position", "number", "count"))
        while blocks_left:
            # Cut a piece where the buffer is full; the rest of it opens the next list.
            count = min(blocks_left, room)
            parts.append((position, number, count))
            position, number = position + count, number + count
            blocks_left, room = blocks_left - count, room - count
            if not room:
                yield parts
                parts, room = [], CHUNK_BLOCKS
    if parts:
        yield parts


def _drop_log(path: Path, assembly: Assembly, records: BlockDecoder) -> DropLog:
    columns, ledger, footer = records.columns(), records.ledger, records.footers.last
    t_us, index, imu_valid = columns["t_us"], columns["sample_index"], columns["imu_valid"]
    switch_open, session = columns["switch_open"], assembly.session
    if not len(t_us):
        raise _no_samples(path, session, assembly.other_sessions)
    header = records.headers.header(path, session)
    # Only a file whose own first block is the recording's can start late; elsewhere blocks are lost.
    first = assembly.pieces[0]
    gaps = ledger.gaps(t_us, footer, int(first["number"]) if first["position"] == 0 else 0)
    not_advancing, late_rows = steps_of_time(t_us, index, header.rate_hz)
    events = read_events(records.events())
    # Events with impossible times stay in the log and count as a doubt, but decide nothing.
    believed = [event for event in events if event.t_us < LATEST_TIME_US]
    # An exchange is told by the header's parts: those silent at the start must be filled in before.
    header = complete_header(header, believed)
    exchanges = find_exchanges(header, believed)
    # Repetition comes last: a standstill that ends at an invalid reading needs no minimum duration.
    invalidate_exchanged(exchanges, t_us, imu_valid)
    invalidate_by_events(believed, t_us, imu_valid)
    invalidate_repeated(columns["imu_counts"], index, t_us, imu_valid)
    release = find_release(believed, t_us, switch_open, gaps)
    copies, conflicting = records.headers.disagreements, assembly.set_aside.conflicting
    impossible = len(events) - len(believed)
    doubts = (
        *block_doubts(copies, conflicting, not_advancing, ledger, records.footers),
        *([f"{impossible} events have impossible times"] if impossible else ()),
        *exchange_doubts(header, exchanges),
        *release_doubts(release, believed, gaps, switch_open),
    )
    # The logger's count of dropped samples is cumulative; the last and largest holds.
    dropped = max(ledger.most_samples_dropped, footer.samples_dropped if footer else 0)
    before = [gap for gap in gaps if gap.late_start]
    lost = [gap for gap in gaps if not gap.late_start]
    # What the logger dropped shows as gaps too, except after the last block.
    samples_lost = max(sum(gap.samples for gap in lost), dropped - sum(gap.samples_dropped for gap in before))
    blocks_lost = ledger.last_number + 1 - ledger.blocks - sum(gap.blocks for gap in before)
    # An open end or late start truncates; any loss or contradiction inside outweighs both.
    verdict: Verdict = "complete" if footer is not None and not before else "truncated"
    if lost or samples_lost or blocks_lost or doubts:
        verdict = "damaged"
    return DropLog(
        path=path,
        session=session,
        other_sessions=assembly.other_sessions,
        recordings=assembly.recordings,
        chosen_by=assembly.chosen_by,
        header=header,
        header_is_copy=records.headers.is_copy,
        header_time_us=records.headers.time_us,
        footer=footer,
        release=release,
        events=events,
        gaps=gaps,
        late_rows=late_rows,
        set_aside=assembly.set_aside,
        samples_lost=samples_lost,
        blocks_lost=blocks_lost,
        doubts=doubts,
        verdict=verdict,
        **columns,
    )


def _no_samples(path: Path, session: int, others: tuple[int, ...]) -> LogError:
    step = "Look for another file on the card."
    if others:
        step = "The file also holds " + ", ".join(f"--session {other:08x}" for other in others) + "."
    meaning = "The recording ended before anything was measured."
    return LogError(f"{path}: recording {session:08x} has no samples.", step, meaning)


def survey(source: LogSource, session: int | None, progress: Progress | None = None) -> Survey:
    """Look at every block of the file, and decode in passing what seems to be the recording.

    `session` is the recording asked for; None: the newest. `progress` is given the share of the file that was
    looked at since the call before.

    Raises:
        LogError: the file cannot be read, or is a jumble.
    """
    pieces, unusable, census = PieceList(source.path), Counter[str](), Census()
    # Decode in passing only where room for every block of the file may be reserved.
    early = _EarlyDecoder(source, session) if source.size_bytes <= DECODED_AT_ONCE_BYTES else None
    reached = 0
    for first, data in source.chunks():
        looked = look(data)
        unusable.update(looked.unusable)
        # Rejected blocks leave holes in the positions; as_pieces joins what goes on without one.
        where = np.flatnonzero(looked.usable)
        heads = looked.heads if len(where) == len(looked.heads) else looked.heads.take(where)
        new_pieces = as_pieces(where + first, heads)
        pieces.append(new_pieces)
        if early is not None:
            early.take(data, looked, new_pieces, first)
        census.add(data, heads, where)
        if progress is not None:
            reached, before = first + len(looked.heads), reached
            progress((reached - before) / source.block_count)
    # Holes at the end of a sparse file are never yielded: report them, so that the shares come to 1.
    if progress is not None and source.block_count:
        progress((source.block_count - reached) / source.block_count)
    # Holes read as zeros, so they count as room that was never written.
    unusable["never_written"] += source.blocks_in_holes
    unusable.update(look_at_tail(source.tail()))
    return Survey(pieces.all(), unusable, census, early)


class _EarlyDecoder:
    """Decodes the first recording of the file, or the one that is asked for, as far as its blocks' numbers rise.

    Whether that was the right recording, and all of it, is decided afterwards.
    """

    def __init__(self, source: LogSource, session: int | None) -> None:
        self.builder = BlockDecoder(source.block_count)
        self.pieces = PieceList(source.path)
        self._session = session
        self._last_number = -1

    def take(self, data: memoryview, looked: BlockScan, pieces: RecordArray, first: int) -> None:
        """Take what continues the recording, of a chunk, its usable blocks, and the position of its first block."""
        if not len(pieces):
            return
        # Nobody asked for one: bet on the first recording of the file.
        if self._session is None:
            self._session = int(pieces["session"][0])
        heads, new = looked.heads, looked.usable
        # Usually a chunk is one piece that goes on where the last one ended. Else pick what continues.
        if (
            len(pieces) > 1
            or pieces["session"][0] != self._session
            or pieces["number"][0] <= self._last_number
        ):
            own = looked.usable & (heads["session"] == self._session)
            numbers = np.where(own, heads["block_number"].astype(np.int64), -1)
            # Above the running maximum only: copies and older blocks are left to the second pass.
            before = np.maximum.accumulate(np.concatenate(([self._last_number], numbers[:-1])))
            new = own & (numbers > before)
            if not new.any():
                return
            where = np.flatnonzero(new)
            pieces = as_pieces(where + first, heads.take(where))
        self.pieces.append(pieces)
        self.builder.take(data, heads, new)
        self._last_number = int(pieces["number"][-1] + pieces["count"][-1] - 1)
