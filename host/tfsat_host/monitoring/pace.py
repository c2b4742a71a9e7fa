"""How often a live view asks: it must never disturb."""

from __future__ import annotations

from tfsat_host.protocol.enums import SequencerState

REFRESH_S = 0.2
"""The picture is drawn anew, and a board at rest is asked, five times a second."""
BUSY_S = 0.5
"""An armed or running sequencer is asked twice a second."""

_BUSY = (SequencerState.ARMED, SequencerState.RUNNING)


def status_interval_s(state: SequencerState) -> float:
    """Least time between two questions to a sequencer in this state."""
    return BUSY_S if state in _BUSY else REFRESH_S
