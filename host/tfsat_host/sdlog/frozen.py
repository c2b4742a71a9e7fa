"""Takes back what an IMU repeated before the logger noticed that it had stopped measuring."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.enums import ErrorCode

from .events import DropEvent


def invalidate_frozen(
    events: Iterable[DropEvent], t_us: NDArray[np.int64], imu_valid: NDArray[np.bool_]
) -> None:
    """Clear the validity, in place, of the samples during which an output stood still.

    The logger marks a frozen IMU invalid only from the sample on at which it is certain; the event says
    for how many µs before it the output had not changed by one bit.

    Args:
        events: Of the recording, by time.
        t_us: (n,) sample times.
        imu_valid: (n, 4) bool; changed.
    """
    spans = [
        (event.index, event.t_us - event.value, event.t_us)
        for event in events
        if event.name == "sensor_fault" and event.arg == ErrorCode.SENSOR_FROZEN and event.value > 0
    ]
    if not spans:
        return
    order = np.argsort(t_us, kind="stable")
    for imu in range(imu_valid.shape[1]):
        own = sorted((start_us, end_us) for index, start_us, end_us in spans if index == imu)
        if not own:
            continue
        bounds = np.searchsorted(t_us, np.array(own), sorter=order)
        done = 0
        for first, last in bounds.tolist():
            imu_valid[order[max(first, done) : last], imu] = False
            done = max(done, last)
