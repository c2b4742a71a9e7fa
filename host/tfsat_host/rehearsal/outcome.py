"""Whether the robot did what it must do in spite of a fault, or because of it: judged by the truth alone."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.enums import SequencerState
from tfsat_host.rehearsal.drop import Drop
from tfsat_host.rehearsal.faults.fault import Fault, Outcome

FLOWN_DEG = 15.0
"""A joint that went further has made a stroke."""
STILL_DEG = 1.0
"""Backlash and the flow of the servos let a joint that holds move by less."""
AT_REST_DEG = 0.1
LAST_S = 0.5
"""Of the fall, by which a robot that stopped at once is at rest."""
STRONGEST_FIRST = (Outcome.NOT_DROPPED, Outcome.STANDS_STILL, Outcome.STOPS, Outcome.FLIES)


def moved_deg(drop: Drop) -> NDArray[np.float64]:
    """(3,) how far each joint went from where it began; 0 if nobody began to record."""
    angles = drop.truth[:, 1:4]
    if not len(angles):
        return np.zeros(3)
    return np.asarray(np.rad2deg(np.abs(angles - angles[0]).max(axis=0)), dtype=np.float64)


def moves_at_the_end(drop: Drop) -> bool:
    """Some joint still moved in the last half second of the fall; not where nothing fell."""
    if drop.landed_s is None:
        return False
    t = drop.truth[:, 0]
    angles = drop.truth[(t > drop.landed_s - LAST_S) & (t < drop.landed_s), 1:4]
    return bool(len(angles)) and bool(np.rad2deg(np.ptp(angles, axis=0).max()) > AT_REST_DEG)


def came_of(outcome: Outcome, drop: Drop) -> bool | None:
    """Whether the robot did it; None: it was not dropped, and so did nothing that could be judged."""
    if outcome is Outcome.NOT_DROPPED:
        return drop.refused is not None
    if drop.refused is not None:
        return None
    moved = float(moved_deg(drop).max())
    if outcome is Outcome.STANDS_STILL:
        return moved < STILL_DEG
    if outcome is Outcome.FLIES:
        return moved > FLOWN_DEG
    stopped = drop.sequencer is not None and drop.sequencer.state is SequencerState.FAULT
    return stopped and moved > FLOWN_DEG and not moves_at_the_end(drop)


def strongest(outcomes: Collection[Outcome]) -> Outcome:
    """What must come of several faults at once; of none: it flies."""
    return next((one for one in STRONGEST_FIRST if one in outcomes), Outcome.FLIES)


def designed_for(faults: Collection[Fault], struck: Collection[str]) -> Outcome:
    """What must come of a day on which those of the faults struck that are named."""
    return strongest([fault.outcome for fault in faults if fault.name in struck])
