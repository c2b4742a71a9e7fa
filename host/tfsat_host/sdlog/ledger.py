"""The numbers that a recording's blocks carry, and what is missing by them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tfsat_host.arrays import IntArray, RecordArray
from tfsat_host.protocol.enums import BlockKind
from tfsat_host.protocol.messages import LogFooter

_DATA = int(BlockKind.DATA)


@dataclass(frozen=True)
class Gap:
    """A place where something is missing: between two samples that are there, or at either end.

    Attributes:
        after_sample: Index of the last sample before it; -1 at the start.
        samples: Samples lost here. 0 where only blocks without samples are missing (events may be lost).
        samples_dropped: Of those, the ones that the logger itself dropped because its ring was full.
        blocks: Blocks lost here.
        start_us: The logger's clock at the last sample before; None at the start.
        end_us: The same at the first sample after; None at the end.
        late_start: Nothing is damaged here: the file begins later than the recording, as one fetched from
            the logger's RAM does, which keeps the newest blocks.
    """

    after_sample: int
    samples: int
    samples_dropped: int
    blocks: int
    start_us: int | None
    end_us: int | None
    late_start: bool = False


class Ledger:
    """Takes the heads of a recording's blocks by number; what it keeps does not grow with them.

    Attributes:
        overlaps: Data blocks that begin before the one before them ends.
        drops_taken_back: Data blocks that count fewer dropped samples than the one before.
        samples_end: Number after the last sample.
        samples_dropped: As the last data block counts them.
        most_samples_dropped: As any data block counts them.
        blocks: That are there.
        blocks_absent: Before the last one that is there.
        last_number: Of that one.
    """

    def __init__(self) -> None:
        self.overlaps = self.drops_taken_back = 0
        self.samples_end = self.samples_dropped = self.most_samples_dropped = 0
        self.blocks = self.blocks_absent = 0
        self.last_number = -1
        self._breaks: list[IntArray] = []
        self._rows = self._absent_at_data = 0

    def add(self, heads: RecordArray) -> None:
        """Append blocks, at least one, their numbers rising."""
        numbers = heads["block_number"].astype(np.int64)
        # A block's number less its rank is how many are missing so far, (k,), never falling.
        absent = numbers - np.arange(self.blocks, self.blocks + len(heads))
        is_data = np.flatnonzero(heads["kind"] == _DATA)
        if len(is_data):
            self._add_data(heads.take(is_data), absent[is_data])
        self.blocks += len(heads)
        self.blocks_absent, self.last_number = int(absent[-1]), int(numbers[-1])

    def gaps(self, t_us: IntArray, footer: LogFooter | None, starts_with: int) -> tuple[Gap, ...]:
        """Return all gaps of the recording.

        Sample times are (n,). `starts_with` is the number of the block that the file itself begins with; 0 if
        that is none of the recording's.
        """
        gaps = [_gap(t_us, *each) for breaks in self._breaks for each in breaks.tolist()]
        if gaps and gaps[0].start_us is None and 0 < starts_with == gaps[0].blocks:
            # What the file begins with is the recording's first block here: a late start, no damage.
            gaps[0] = replace(gaps[0], late_start=True)
        # Behind the last data block: blocks that are absent, and samples that only the footer counts.
        blocks = self.blocks_absent - self._absent_at_data
        samples = max(footer.samples - self.samples_end, 0) if footer else 0
        if blocks or samples:
            dropped = footer.samples_dropped - self.samples_dropped if footer else 0
            gaps.append(_gap(t_us, len(t_us), self.samples_end - 1, samples, dropped, blocks))
        return tuple(gaps)

    def _add_data(self, heads: RecordArray, absent: IntArray) -> None:
        first, counts = heads["first_sample"].astype(np.int64), heads["sample_count"].astype(np.int64)
        dropped = heads["samples_dropped"].astype(np.int64)
        end = first + counts
        # Sample numbers between the end of one block and the beginning of the next are lost.
        end_before = np.concatenate(([self.samples_end], end[:-1]))
        samples = first - end_before
        # First differences run on across chunks: the totals of the chunk before come first.
        blocks = np.diff(absent, prepend=self._absent_at_data)
        newly_dropped = np.diff(dropped, prepend=self.samples_dropped)
        where = np.flatnonzero((blocks > 0) | (samples > 0))
        if len(where):
            # Row of each block's first sample: the exclusive running sum of the counts.
            row = self._rows + np.cumsum(counts) - counts
            columns = (row, end_before - 1, samples, newly_dropped, blocks)
            self._breaks.append(np.stack([column[where] for column in columns], axis=1))
        # Numbers that repeat or counts that fall are no gaps, but contradictions.
        self.overlaps += int(np.count_nonzero(samples < 0))
        self.drops_taken_back += int(np.count_nonzero(newly_dropped < 0))
        self._rows += int(counts.sum())
        self._absent_at_data = int(absent[-1])
        self.samples_end, self.samples_dropped = int(end[-1]), int(dropped[-1])
        self.most_samples_dropped = max(self.most_samples_dropped, int(dropped.max()))


def _gap(t_us: IntArray, row: int, after_sample: int, samples: int, dropped: int, blocks: int) -> Gap:
    """Build the gap before row `row` from samples lost, those that the logger dropped, and blocks lost."""
    # Clamp what contradictory blocks give: a negative loss is reported as a doubt, not as a gap.
    samples = max(samples, 0)
    return Gap(
        after_sample=after_sample,
        samples=samples,
        samples_dropped=min(max(dropped, 0), samples),
        blocks=max(blocks, 0),
        start_us=int(t_us[row - 1]) if row else None,
        end_us=int(t_us[row]) if row < len(t_us) else None,
    )
