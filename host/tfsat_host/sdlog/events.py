"""What happened during a recording."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.enums import EventCode


@dataclass(frozen=True)
class DropEvent:
    """One event of the log.

    Attributes:
        t_us: The logger's clock, µs since power-up.
        name: Lower-case name of the EventCode; `code_17` for a code that this release does not know.
        index: Which switch, stroke or IMU, from 0.
        arg: See EventCode.
        value: See EventCode.
    """

    t_us: int
    name: str
    index: int
    arg: int
    value: int


def read_events(raw: NDArray[np.void]) -> tuple[DropEvent, ...]:
    """Turn (e,) records of EVENT_DTYPE into events, by time."""
    names = {int(code): code.name.lower() for code in EventCode}
    events = [
        DropEvent(time_us, names.get(code, f"code_{code}"), index, arg, value)
        for time_us, code, index, arg, value in raw.tolist()
    ]
    return tuple(sorted(events, key=lambda event: event.t_us))
