"""A step read live from the logger: the same for a person at the bench and for the morning of a rehearsal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime

from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.evidence import Evidence, Origin
from tfsat_host.calibration.steps.step import Step
from tfsat_host.protocol.messages import LiveReply, LiveSampleStream

Enough = Callable[[Sequence[LiveSampleStream]], bool]
"""Given the samples that have just come: whether they are the last."""


@dataclass(frozen=True)
class LiveSource:
    """A logger that samples live.

    Attributes:
        fresh: Samples that have arrived since the last call, at least one.
        scales: As the logger named them.
        origin: Whose sensors they are.
        now: The time of day, with its time zone.
    """

    fresh: Callable[[], Sequence[LiveSampleStream]]
    scales: LiveReply
    origin: Origin
    now: Callable[[], datetime]


def pass_over(live: LiveSource, lead_s: float) -> None:
    """Reads and forgets the samples of the time in which a person gets ready, on the logger's clock."""
    if lead_s <= 0:
        return
    first_us = live.fresh()[0].time_us
    while live.fresh()[-1].time_us < first_us + lead_s * 1e6:
        pass


def read_step(step: Step, live: LiveSource, enough: Enough) -> Evidence:
    """Reads until there is enough. Raises what `live.fresh` does."""
    taken = live.now()
    samples: list[LiveSampleStream] = []
    while True:
        fresh = live.fresh()
        samples += fresh
        if enough(fresh):
            return Evidence(step, Counts.from_live(samples, live.scales), taken, live.origin)


def until_s(duration_s: float) -> Enough:
    """Enough after so long a time on the logger's clock."""
    first_us: int | None = None

    def enough(fresh: Sequence[LiveSampleStream]) -> bool:
        nonlocal first_us
        first_us = fresh[0].time_us if first_us is None else first_us
        return fresh[-1].time_us - first_us >= duration_s * 1e6

    return enough
