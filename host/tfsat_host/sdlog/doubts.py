"""Contradictions inside a recording: each makes it doubtful, whatever else is there."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.messages import LogFooter

from .assembly import SetAside
from .header import FoundHeader
from .records import Records


def find_doubts(
    found: FoundHeader,
    footers: list[tuple[int, LogFooter]],
    numbers: NDArray[np.int64],
    sample_count: NDArray[np.int64],
    records: Records,
    set_aside: SetAside,
) -> Iterator[str]:
    """Yield a sentence for each contradiction; `footers` are (block number, footer)."""
    if found.disagreements:
        yield f"{found.disagreements} copies of the header disagree with the one that was used"
    if set_aside.conflicting:
        yield f"{set_aside.conflicting} blocks carry the number of another, different block"
    backwards = int(np.count_nonzero(np.diff(records.t_us) <= 0))
    if backwards:
        yield f"time does not advance at {backwards} samples"
    ends = records.block_first_sample + sample_count
    overlaps = int(np.count_nonzero(records.block_first_sample[1:] < ends[:-1]))
    if overlaps:
        yield f"{overlaps} blocks repeat sample numbers of the block before"
    if np.any(np.diff(records.block_samples_dropped) < 0):
        yield "the count of dropped samples goes down"
    if footers:
        yield from _footer_doubts(footers, numbers, ends, records)


def _footer_doubts(
    footers: list[tuple[int, LogFooter]],
    numbers: NDArray[np.int64],
    ends: NDArray[np.int64],
    records: Records,
) -> Iterator[str]:
    if any(footer != footers[0][1] for _, footer in footers):
        yield "the recording has several different ends"
    number, footer = footers[-1]
    if number != int(numbers[-1]):
        yield "blocks follow the end of the recording"
    if footer.blocks != number + 1:
        yield f"the end of the recording counts {footer.blocks} blocks and is number {number}"
    if footer.samples < int(ends[-1]):
        yield f"the end of the recording counts {footer.samples} samples; there are {int(ends[-1])}"
    if footer.samples_dropped < int(records.block_samples_dropped[-1]):
        yield "the end of the recording counts fewer dropped samples than a block before it"
