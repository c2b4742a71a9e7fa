"""What the logger must believe of the drop, by the host's own release rule and the script of the run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tests.logger_proof.due import Due
from tests.logger_proof.truth import Truth
from tfsat_host.protocol.limits import LANDING_LATEST_US, RELEASE_DEBOUNCE_US
from tfsat_host.sdlog.release import release_times

SEATED_US = 200_000
"""Both switches closed again for so long: it was no release."""
TICKS_US = 20_000
"""Some sampling instants, should a few be missed."""
ROUNDING_US = 1
"""The release rule counts half microseconds."""
SHOCK_MG = (15_999, 16_000)
"""The end of the range, either way."""


def drop_events(truth: Truth) -> Iterator[Due]:
    """Releases, those that were none, and the landing, of the whole run."""
    switches = truth.edges[truth.edges["source"] == 0]
    edges = [(edge["t_us"].item(), edge["index"].item(), bool(edge["open"])) for edge in switches]
    for release_us in release_times(edges, 0, truth.end_us):
        is_real = release_us == truth.release_us
        times = (release_us - ROUNDING_US, release_us + ROUNDING_US)
        yield Due("release", *times, release_us + RELEASE_DEBOUNCE_US + TICKS_US, 0, 1)
        if is_real:
            yield _landing(truth)
        else:
            closed_us = next(t_us for t_us, index, is_open in edges if index == 1 and not is_open)
            yield Due("release", *times, closed_us + SEATED_US + TICKS_US, 0, 0)


def _landing(truth: Truth) -> Due:
    """By the shock, or without one by the time; where every IMU fails some time, by either."""
    shock_us, time_us = int(truth.head["landing_us"]), truth.release_us + LANDING_LATEST_US
    if int(truth.head["faulty"]) == 0xF:
        return Due("landing", shock_us, time_us + TICKS_US, time_us + TICKS_US, 0, None, None)
    if not truth.head["landing_felt"]:
        return Due("landing", time_us, time_us + TICKS_US, time_us + TICKS_US, 0, 0)
    row = min(int(np.searchsorted(truth.ticks["t_us"], shock_us)), len(truth.ticks) - 1)
    tick_us = int(truth.ticks["t_us"][row])
    return Due("landing", tick_us, tick_us, tick_us, 0, 1, SHOCK_MG)
