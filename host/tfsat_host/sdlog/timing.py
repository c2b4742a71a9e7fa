"""The steps between sample times, looked at some at a time so that no column of them is ever held."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_ROWS_AT_A_TIME = 1 << 15
_MISSED_FROM_PERIODS = 1.5


@dataclass(frozen=True, eq=False)
class Steps:
    """What the times of samples that follow each other say.

    Attributes:
        not_advancing: How often time stands still or goes back.
        late_rows: (m,) int64, rows of samples that came more than one and a half periods after the one
            before although none was lost between: the sampling timer's ticks passed without a sample.
    """

    not_advancing: int
    late_rows: NDArray[np.int64]


def look_at_steps(t_us: NDArray[np.int64], index: NDArray[np.int64], rate_hz: float) -> Steps:
    """Find the steps that are no step forward, and those that are too long.

    Args:
        t_us: (n,) sample times.
        index: (n,) sample numbers.
        rate_hz: The sampling rate that was commanded.
    """
    longest_us = _MISSED_FROM_PERIODS * 1e6 / rate_hz
    not_advancing = 0
    late = [np.empty(0, np.int64)]
    for begin in range(0, len(t_us) - 1, _ROWS_AT_A_TIME):
        step_us = np.diff(t_us[begin : begin + _ROWS_AT_A_TIME + 1])
        not_advancing += int(np.count_nonzero(step_us <= 0))
        rows = np.flatnonzero(step_us > longest_us) + begin + 1
        if len(rows):
            late.append(rows[index[rows] == index[rows - 1] + 1])
    return Steps(not_advancing, np.concatenate(late))
