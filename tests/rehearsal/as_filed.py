"""Drops of the robot exactly as its file says, for tests that want one they can compute."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tfsat_host.maneuver import Schedule
from tfsat_host.protocol.messages import RecordStopReply, SequencerStatusReply
from tfsat_host.rehearsal.rehearse import rehearse
from tfsat_host.rehearsal.truth import truth_as_filed
from tfsat_host.robot import load_robot


@dataclass(frozen=True, eq=False)
class WholeDrop:
    """A `Drop` from which nothing is missing; see there."""

    card: bytes
    truth: NDArray[np.float64]
    released_s: float
    landed_s: float
    recording: RecordStopReply
    sequencer: SequencerStatusReply


def dropped(schedule: Schedule, *, seed: int, rate_rad_s: Sequence[float] | None = None) -> WholeDrop:
    """Rehearsed whole; let go as the paper's robot was, or at a rate of body 3."""
    filed = load_robot()
    truth = truth_as_filed(filed, seed)
    if rate_rad_s is not None:
        truth = replace(truth, rate_rad_s=np.array(rate_rad_s))
    drop = rehearse(schedule, filed, truth)
    assert drop.released_s is not None
    assert drop.landed_s is not None
    assert drop.recording is not None
    assert drop.sequencer is not None
    return WholeDrop(drop.card, drop.truth, drop.released_s, drop.landed_s, drop.recording, drop.sequencer)
