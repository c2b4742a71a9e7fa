"""What happened during a recording, and which IMUs were exchanged by it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from tfsat_host.arrays import RecordArray
from tfsat_host.protocol.enums import EventCode
from tfsat_host.protocol.messages import LogHeader


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


def read_events(raw: RecordArray) -> tuple[DropEvent, ...]:
    """Turn (e,) records of EVENT_DTYPE into events, by time."""
    names = {int(code): code.name.lower() for code in EventCode}
    events = [
        DropEvent(time_us, names.get(code, f"code_{code}"), index, arg, value)
        for time_us, code, index, arg, value in raw.tolist()
    ]
    # An event waits for a free slot in a block: the order of the log is not that of time.
    return tuple(sorted(events, key=lambda event: event.t_us))


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


def complete_header(header: LogHeader, events: Iterable[DropEvent]) -> LogHeader:
    """Add to the header the parts of those IMUs that answered only after the recording began."""
    who_am_i = bytearray(header.who_am_i)
    for event in events:
        # Fill in only IMUs that were silent at the start, by their first answer; 0 is earlier firmware's.
        if event.name == "sensor_recovered" and event.index < len(who_am_i) and 0 < event.value <= 0xFF:
            who_am_i[event.index] = who_am_i[event.index] or event.value
    return replace(header, who_am_i=bytes(who_am_i))


def find_exchanges(header: LogHeader, events: Sequence[DropEvent]) -> tuple[Exchange, ...]:
    """IMUs that came back as other parts than in the completed header; events are by time."""
    exchanges = []
    for index, named in enumerate(header.who_am_i):
        # State of one IMU's walk through its events: failed since when, and the exchange that is open.
        failed_us: int | None = None
        open_: Exchange | None = None
        for event in (event for event in events if event.index == index):
            if event.name == "sensor_fault" and failed_us is None:
                # The first fault counts; a second one before a recovery only changes the reason.
                failed_us = event.t_us
            elif event.name == "sensor_recovered":
                # A WHO_AM_I of 0 names no part, so it proves no exchange.
                is_other = 0 < event.value <= 0xFF and event.value != named
                if open_ and event.value == named:
                    # The header's part is back, and with it the header's scales and the calibration.
                    exchanges.append(replace(open_, until_us=event.t_us))
                    open_ = None
                elif is_other and open_ is None:
                    # It may have been exchanged at any time since the fault: distrust all of that.
                    from_us = event.t_us if failed_us is None else failed_us
                    open_ = Exchange(index, from_us, None, event.t_us, event.value)
                failed_us = None
        if open_:
            exchanges.append(open_)
    return tuple(exchanges)
