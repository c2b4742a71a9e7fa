"""What happened during a recording, and when the robot was released."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tfsat_host.protocol.enums import EventCode
from tfsat_host.protocol.limits import RELEASE_DEBOUNCE_US, SWITCH_COUNT

_ALL_OPEN = (1 << SWITCH_COUNT) - 1


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


def release_time_us(
    events: tuple[DropEvent, ...], t_us: NDArray[np.int64], switch_open: NDArray[np.bool_]
) -> int | None:
    """When the robot was released, by the sequencer's own rule; None if it was not.

    A release is: both switches open without interruption for RELEASE_DEBOUNCE_US, after both had been
    closed for as long. Its time is the first edge at which both were open; the contacts may chatter
    after it. Of several (the robot was handled during the recording), it is the last before the
    first stroke, or without strokes the first.

    Args:
        events: By time; the switch edges among them carry the time to the microsecond.
        t_us: (n,) sample times.
        switch_open: (n, 2) the switches' states at the samples; used where no edge was recorded.
    """
    edges = [(event.t_us, event.index, event.arg != 0) for event in events if event.name == "switch_edge"]
    start = switch_open[0].tolist() if len(switch_open) else [False] * SWITCH_COUNT
    end_us = max([edge[0] for edge in edges] + t_us[-1:].tolist(), default=0)
    releases = _releases(edges, start, end_us) or _releases(_edges_of(t_us, switch_open), start, end_us)
    first_stroke = next((event.t_us for event in events if event.name == "stroke"), None)
    if first_stroke is not None:
        before = [release for release in releases if release <= first_stroke]
        return before[-1] if before else None
    return releases[0] if releases else None


def _edges_of(t_us: NDArray[np.int64], switch_open: NDArray[np.bool_]) -> list[tuple[int, int, bool]]:
    """The changes that the samples show, each at the first sample after it."""
    if not switch_open.any() or switch_open.all():
        return []
    rows, switches = np.nonzero(switch_open[1:] != switch_open[:-1])
    return [
        (int(t_us[row + 1]), int(switch), bool(switch_open[row + 1, switch]))
        for row, switch in zip(rows.tolist(), switches.tolist(), strict=True)
    ]


def _releases(edges: list[tuple[int, int, bool]], start: list[bool], end_us: int) -> list[int]:
    """The times of all releases; `start` tells which switches without an edge are open."""
    edges = [edge for edge in edges if edge[1] < SWITCH_COUNT]
    first = {switch: is_open for _, switch, is_open in reversed(edges)}
    state = sum(1 << i for i, is_open in enumerate(start) if (not first[i] if i in first else is_open))
    releases = []
    candidate: int | None = None
    watching = state == 0
    ends = [edge[0] for edge in edges[1:]] + [end_us]
    for (time_us, switch, is_open), until_us in zip(edges, ends, strict=False):
        state = state | 1 << switch if is_open else state & ~(1 << switch)
        if state == _ALL_OPEN and watching and candidate is None:
            candidate = time_us
        if until_us - time_us < RELEASE_DEBOUNCE_US:
            continue
        if state == _ALL_OPEN and candidate is not None:
            releases.append(candidate)
            watching = False
        elif state == 0:
            watching = True
        candidate = None
    return releases
