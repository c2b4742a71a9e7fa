"""Contradictions inside a recording: each makes it doubtful, whatever else is there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.messages import LogFooter

from .assembly import SetAside
from .events import DropEvent
from .gaps import Gap
from .header import FoundHeader
from .records import Records
from .release import Release


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


def release_doubts(
    release: Release | None,
    events: Sequence[DropEvent],
    gaps: Sequence[Gap],
    switch_open: NDArray[np.bool_],
) -> Iterator[str]:
    """Yield a sentence if the release is not certain to the microsecond, or missing where one must be."""
    if release is None:
        if gaps and any(event.name == "stroke" for event in events):
            yield "strokes were recorded and no release: times count from the first sample"
        elif gaps and gaps[0].start_us is None and switch_open[:1].all():
            yield "the start is lost and both switches are open after it: the release may lie in it"
    elif release.uncertainty_us:
        before_ms = (release.t_us - release.earliest_us) / 1e3
        after_ms = (release.latest_us - release.t_us) / 1e3
        yield (
            "edges of the release switches are lost: the release may have been up to "
            f"{before_ms:.3f} ms before t = 0 or {after_ms:.3f} ms after it"
        )
