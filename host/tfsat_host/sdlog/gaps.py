"""What is missing from a recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.messages import LogFooter

from .records import Records


@dataclass(frozen=True)
class Gap:
    """A place where something is missing between two samples that are there.

    Attributes:
        after_sample: Index of the last sample before it; -1 at the start.
        samples: Samples lost here. 0 where only blocks without samples are missing (events may be lost).
        samples_dropped: Of those, the ones that the logger itself dropped because its ring was full.
        blocks: Blocks lost here.
        start_us: The logger's clock at the last sample before; None at the start.
        end_us: The same at the first sample after; None at the end.
    """

    after_sample: int
    samples: int
    samples_dropped: int
    blocks: int
    start_us: int | None
    end_us: int | None


def find_gaps(
    numbers: NDArray[np.int64],
    data_rank: NDArray[np.int64],
    sample_count: NDArray[np.int64],
    records: Records,
    footer: LogFooter | None,
) -> tuple[Gap, ...]:
    """Compare what is there with the numbers it carries.

    Args:
        numbers: (k,) block numbers of all blocks of the recording, ascending.
        data_rank: (b,) which of the k are data blocks.
        sample_count: (b,) samples in each data block.
        records: Their contents.
        footer: If there is one.
    """
    first, dropped = records.block_first_sample, records.block_samples_dropped
    end = first + sample_count
    absent = numbers - np.arange(len(numbers))
    before_block = np.diff(absent[data_rank], prepend=0)
    before_sample = np.diff(first, prepend=0)
    before_sample[1:] = first[1:] - end[:-1]
    newly_dropped = np.diff(dropped, prepend=0)
    row_end = np.cumsum(sample_count)
    gaps = []
    for block in np.flatnonzero((before_block > 0) | (before_sample > 0)).tolist():
        row = int(row_end[block] - sample_count[block])
        gaps.append(
            _gap(
                records,
                row,
                int(end[block - 1]) - 1 if block else -1,
                (int(before_sample[block]), int(newly_dropped[block]), int(before_block[block])),
            )
        )
    last_end, last_dropped = int(end[-1]), int(dropped[-1])
    blocks = int(absent[-1] - absent[data_rank[-1]])
    samples = max(footer.samples - last_end, 0) if footer else 0
    if blocks or samples:
        late_drops = footer.samples_dropped - last_dropped if footer else 0
        gaps.append(_gap(records, len(records.t_us), last_end - 1, (samples, late_drops, blocks)))
    return tuple(gaps)


def _gap(records: Records, row: int, after_sample: int, lost: tuple[int, int, int]) -> Gap:
    """The gap before row `row`; `lost` is (samples, samples dropped by the logger, blocks)."""
    samples, dropped, blocks = max(lost[0], 0), lost[1], max(lost[2], 0)
    return Gap(
        after_sample=after_sample,
        samples=samples,
        samples_dropped=min(max(dropped, 0), samples),
        blocks=blocks,
        start_us=int(records.t_us[row - 1]) if row else None,
        end_us=int(records.t_us[row]) if row < len(records.t_us) else None,
    )
