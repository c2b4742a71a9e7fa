"""What the logger must believe of the drop, by the host's own release rule and the script of the run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tests.logger_proof.due import Due
from tests.logger_proof.truth import Truth
from tfsat_host.protocol.limits import LANDING_LATEST_US, RELEASE_DEBOUNCE_US
from tfsat_host.sdlog.release_rule import releases_by_rule

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
    for release in releases_by_rule(edges, 0, truth.end_us):
        times = (release.at_us - ROUNDING_US, release.at_us + ROUNDING_US)
        yield Due("release", *times, release.at_us + RELEASE_DEBOUNCE_US + TICKS_US, 0, 1)
        if release.at_us == truth.release_us:
            yield _landing(truth)
        elif release.false_us is not None:
            yield Due("release", *times, release.false_us + TICKS_US, 0, 0)


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
