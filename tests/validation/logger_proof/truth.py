"""What really happened in a run, as its program wrote it (board/truth.h)."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.enums import BlockKind

FILE = np.dtype([("first_block", "<u4"), ("blocks", "<u4"), ("closed", "<u4")])
HEAD = np.dtype(
    [
        *(("magic", "S8"), ("seed", "<u4"), ("kind", "u1"), ("holds_older", "u1"), ("file_count", "u1")),
        *(("state", "u1"), ("rate_hz", "<u2"), ("stall_one_in", "<u2"), ("ring_blocks", "<u4")),
        *(("image_blocks", "<u4"), ("ticks", "<u4"), ("writes", "<u4"), ("troubles", "<u4")),
        *(("edges", "<u4"), ("end_us", "<u8"), ("release_us", "<u8"), ("landing_us", "<u8")),
        *(("faulty", "u1"), ("landing_felt", "u1"), ("pulled", "u1"), ("lost_for_good", "u1")),
        *(("ram_blocks", "<u4"), ("spoiled_blocks", "<u4"), ("cache_blocks", "<u4")),
        *(("unix_at_zero_us", "<u8"), ("files", FILE, (4,))),
    ],
    align=True,
)
TICK = np.dtype(
    [
        *(("t_us", "<u8"), ("imu", "<i2", (4, 7)), ("angle", "<u2", (6,)), ("served", "u1")),
        *(("switches_open", "u1"), ("angles", "u1"), ("captured", "u1")),
    ]
)
WRITE = np.dtype(
    [
        *(("t_us", "<u8"), ("position", "<u4"), ("session", "<u4"), ("number", "<u4")),
        *(("first_sample", "<u4"), ("kind", "u1"), ("samples", "u1"), ("synced", "u1")),
        *(("on_medium", "u1"), ("file", "u1"), ("padding", "u1", (3,))),
    ]
)
TROUBLE = np.dtype([("from_us", "<u8"), ("to_us", "<u8"), ("pulled", "u1"), ("padding", "u1", (7,))])
EDGE = np.dtype(
    [
        ("t_us", "<u8"),
        ("source", "u1"),
        ("index", "u1"),
        ("open", "u1"),
        ("lost", "u1"),
        ("padding", "u1", (4,)),
    ]
)
# The sizes that truth.h writes: an added field must be added here, too.
SIZES = (HEAD.itemsize, TICK.itemsize, WRITE.itemsize, TROUBLE.itemsize, EDGE.itemsize)
assert SIZES == (144, 80, 32, 24, 16)


class Kind(IntEnum):
    """What a run is about (board/scenario.h)."""

    BETWEEN = 0
    TORN = 1
    CACHE_LOST = 2
    OUT_OF_ORDER = 3
    STALE = 4
    STALLS = 5
    SECOND_COPY = 6
    CLOSE = 7
    PULLED = 8
    DEAD_SENSORS = 9
    SMALL_RING = 10
    SPOILED = 11
    FALSE_RELEASE = 12
    RECLOSED = 13
    CARD_LOST = 14
    NEXT_FILE = 15


@dataclass(frozen=True, eq=False)
class Truth:
    """One recording of a run.

    Attributes:
        head: (HEAD) the run as a whole.
        number: Of the recording and its file, from 1.
        ticks: (n,) of TICK, every sampling instant from power-up to the next recording.
        writes: (w,) of WRITE, every block of it that the card took, in this order.
        troubles: (k,) of TROUBLE, stalls and losses of contact.
        edges: (e,) of EDGE, every change of an input in the run.
        begin_us: The recording before it had its last sample then; 0 without one.
    """

    head: np.void
    number: int
    ticks: NDArray[np.void]
    writes: NDArray[np.void]
    troubles: NDArray[np.void]
    edges: NDArray[np.void]
    begin_us: int

    @property
    def kind(self) -> Kind:
        return Kind(int(self.head["kind"]))

    @property
    def rate_hz(self) -> int:
        return int(self.head["rate_hz"])

    @property
    def closed(self) -> bool:
        """Its file was closed."""
        return bool(self.head["files"][self.number - 1]["closed"])

    @property
    def is_last(self) -> bool:
        return self.number == max(1, int(self.head["file_count"]))

    @property
    def blocks(self) -> slice:
        """Its file's on the medium."""
        first, count, _ = self.head["files"][self.number - 1].tolist()
        return slice(first, first + count)

    @property
    def end_us(self) -> int:
        """When the power went."""
        return int(self.head["end_us"])

    @property
    def release_us(self) -> int:
        """Of the robot: both switches open, the second one's edge."""
        # Switch 2 opens last; its last opening is the release, earlier ones were none.
        opened = (self.edges["source"] == 0) & (self.edges["index"] == 1) & (self.edges["open"] == 1)
        return int(self.edges["t_us"][opened][-1])

    @property
    def first_tick(self) -> int:
        """Row of the tick that gave sample 0; the number of ticks when nothing was recorded."""
        # captured has the number of the recording to which the tick belongs.
        captured = np.flatnonzero(self.ticks["captured"] == self.number)
        return int(captured[0]) if len(captured) else len(self.ticks)

    @property
    def samples(self) -> NDArray[np.void]:
        """(n,) of TICK by sample index; behind the last sample, ticks that were not recorded."""
        return self.ticks[self.first_tick :]

    @property
    def last_sample_us(self) -> int:
        """As its footer tells, or the end of the run."""
        footers = self.writes[self.writes["kind"] == BlockKind.FOOTER]
        end = int(footers["first_sample"][0]) if len(footers) else 0
        return int(self.samples["t_us"][end - 1]) if end else self.end_us

    def samples_in(self, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(n,) bool by sample index: it is in one of the chosen writes."""
        # Six spare entries: a block near the end may reach past the last tick.
        in_writes = np.zeros(len(self.ticks) + 6, np.bool_)
        data = self.writes[chosen & (self.writes["kind"] == BlockKind.DATA)]
        for slot in range(6):
            in_writes[(data["first_sample"] + slot)[data["samples"] > slot]] = True
        return in_writes[: len(self.samples)]

    def dropped_samples(self) -> NDArray[np.bool_]:
        """(n,) bool by sample index: it found no room, as the numbers of the blocks around it tell."""
        _, rows = np.unique(self.writes["number"], return_index=True)
        blocks = self.writes[rows]
        dropped = np.zeros(len(self.samples), np.bool_)
        # The next block's first sample less the end of the block before: what found no room.
        ends = blocks["first_sample"][:-1].astype(np.int64) + blocks["samples"][:-1]
        for end, begin in zip(ends.tolist(), blocks["first_sample"][1:].tolist(), strict=True):
            dropped[end:begin] = True
        return dropped


def read_truth(path: Path) -> list[Truth]:
    """Read the recordings of a run; return one without writes where none was begun.

    Raises ValueError if the file is not what its program should have written.
    """
    data = path.read_bytes()
    # A wrong magic: the program and this module disagree about the format.
    if len(data) < HEAD.itemsize or data[:8] != b"TFSATRUN":
        raise ValueError(f"{path} does not tell what happened")
    head = np.frombuffer(data, HEAD, 1)[0]
    at = HEAD.itemsize
    lists = {}
    for name, dtype in (("ticks", TICK), ("writes", WRITE), ("troubles", TROUBLE), ("edges", EDGE)):
        count = int(head[name])
        lists[name] = np.frombuffer(data, dtype, count, at)
        at += count * dtype.itemsize
    if at != len(data):
        raise ValueError(f"{path} has {len(data)} bytes, {at} were announced")
    return _recordings(head, **lists)


def _recordings(
    head: np.void,
    ticks: NDArray[np.void],
    writes: NDArray[np.void],
    troubles: NDArray[np.void],
    edges: NDArray[np.void],
) -> list[Truth]:
    recordings: list[Truth] = []
    begin_us = 0
    for number in range(1, max(1, int(head["file_count"])) + 1):
        # Ticks of the next recording do not belong to this one.
        later = np.flatnonzero(ticks["captured"] > number)
        own = ticks[: later[0]] if len(later) else ticks
        written = writes[writes["file"] == number]
        recordings.append(Truth(head, number, own, written, troubles, edges, begin_us))
        begin_us = recordings[-1].last_sample_us
    return recordings
