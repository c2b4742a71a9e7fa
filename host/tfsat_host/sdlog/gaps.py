"""What is missing from a recording."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.messages import LogFooter

from .ledger import Account


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


def find_gaps(
    account: Account, t_us: NDArray[np.int64], footer: LogFooter | None, starts_with: int
) -> tuple[Gap, ...]:
    """Every gap, from what the blocks' numbers say.

    Args:
        account: Of all blocks of the recording.
        t_us: (n,) sample times.
        footer: If there is one.
        starts_with: Number of the block that the file itself begins with; 0 if that is none of the
            recording's.
    """
    gaps = [_gap(t_us, row, after, (*lost,)) for row, after, *lost in account.breaks.tolist()]
    if gaps and gaps[0].start_us is None and 0 < starts_with == gaps[0].blocks:
        gaps[0] = replace(gaps[0], late_start=True)
    blocks = account.blocks_missing_at_end
    samples = max(footer.samples - account.samples_end, 0) if footer else 0
    if blocks or samples:
        late_drops = footer.samples_dropped - account.samples_dropped if footer else 0
        gaps.append(_gap(t_us, len(t_us), account.samples_end - 1, (samples, late_drops, blocks)))
    return tuple(gaps)


def _gap(t_us: NDArray[np.int64], row: int, after_sample: int, lost: tuple[int, ...]) -> Gap:
    """The gap before row `row`; `lost` is (samples, samples dropped by the logger, blocks)."""
    samples, dropped, blocks = (max(count, 0) for count in lost)
    return Gap(
        after_sample=after_sample,
        samples=samples,
        samples_dropped=min(dropped, samples),
        blocks=blocks,
        start_us=int(t_us[row - 1]) if row else None,
        end_us=int(t_us[row]) if row < len(t_us) else None,
    )
