"""Which parts the IMUs of a recording are: by its header, and by what they said of themselves later on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.imus import IMU_PARTS, ImuPart
from tfsat_host.protocol.messages import LogHeader

from .events import DropEvent

MPU_6050 = next(iter(IMU_PARTS))
"""What an IMU is taken for that did not say what it is, where no other one did."""


@dataclass(frozen=True, slots=True)
class Exchange:
    """An IMU that came back as another part than the header's.

    Attributes:
        index: Which, from 0.
        from_us: When it failed, on the logger's clock.
        until_us: When the header's part was back; None if it never was.
        back_us: When it came back as the other part.
        who_am_i: Of that part.
    """

    index: int
    from_us: int
    until_us: int | None
    back_us: int
    who_am_i: int


def parts_of(who_am_i: Sequence[int]) -> tuple[ImuPart, ...]:
    """What each IMU is; one that did not say it is what most others are, for they are bought together."""
    known = Counter(one for one in who_am_i if one in IMU_PARTS)
    likely = known.most_common(1)[0][0] if known else MPU_6050
    return tuple(IMU_PARTS.get(one, IMU_PARTS[likely]) for one in who_am_i)


def completed(header: LogHeader, events: Iterable[DropEvent]) -> LogHeader:
    """The header with the parts of those IMUs that answered only after the recording began."""
    who_am_i = bytearray(header.who_am_i)
    for event in _recoveries(events, len(who_am_i)):
        who_am_i[event.index] = who_am_i[event.index] or event.value
    return replace(header, who_am_i=bytes(who_am_i))


def find_exchanges(header: LogHeader, events: Sequence[DropEvent]) -> tuple[Exchange, ...]:
    """IMUs that came back as other parts.

    Args:
        header: Completed.
        events: By time.
    """
    found = []
    for index, named in enumerate(header.who_am_i):
        failed_us: int | None = None
        open_: Exchange | None = None
        for event in events:
            if event.index != index:
                continue
            if event.name == "sensor_fault" and failed_us is None:
                failed_us = event.t_us
            elif event.name == "sensor_recovered":
                is_other = 0 < event.value <= 0xFF and event.value != named
                if open_ and event.value == named:
                    found.append(replace(open_, until_us=event.t_us))
                    open_ = None
                elif is_other and open_ is None:
                    from_us = event.t_us if failed_us is None else failed_us
                    open_ = Exchange(index, from_us, None, event.t_us, event.value)
                failed_us = None
        if open_:
            found.append(open_)
    return tuple(found)


def invalidate_exchanged(
    exchanges: Iterable[Exchange], t_us: NDArray[np.int64], imu_valid: NDArray[np.bool_]
) -> None:
    """Clear the validity, in place, of what another part than the header's said.

    Args:
        exchanges: Of the recording.
        t_us: (n,) sample times.
        imu_valid: (n, 4) bool; changed.
    """
    for one in exchanges:
        other = t_us >= one.from_us
        if one.until_us is not None:
            other &= t_us < one.until_us
        imu_valid[other, one.index] = False


def exchange_doubts(header: LogHeader, exchanges: Iterable[Exchange]) -> Iterator[str]:
    """Yield a sentence for each IMU that came back as another part: what, what it means, and what to do."""
    for one in exchanges:
        yield (
            f"IMU {one.index + 1} came back as another part at {one.back_us / 1e6:.6f} s of the logger's clock: "
            f"{_name(one.who_am_i)}, and the header has {_name(header.who_am_i[one.index])}. Its readings from the "
            "fault on are taken for invalid, for neither the header's scales nor the calibration are that part's. "
            "Calibrate with the part that is to stay, and record again"
        )


def _name(who_am_i: int) -> str:
    part = IMU_PARTS.get(who_am_i)
    return f"{'an unknown part' if part is None else part.name} (WHO_AM_I 0x{who_am_i:02x})"


def _recoveries(events: Iterable[DropEvent], count: int) -> Iterator[DropEvent]:
    """Of an IMU that said what it is."""
    for event in events:
        if event.name == "sensor_recovered" and event.index < count and 0 < event.value <= 0xFF:
            yield event
