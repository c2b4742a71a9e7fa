"""When a board said how long it has been running: two such moments tell its clock's pace."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from tfsat_host.preflight.evidence import Pace
from tfsat_host.protocol.messages import LoggerStatusReply, SequencerStatusReply

Status = TypeVar("Status", SequencerStatusReply, LoggerStatusReply)

_TICK_S = 1e-3
"""Uptimes are whole milliseconds."""


@dataclass(frozen=True, slots=True)
class Moment(Generic[Status]):
    """A status, and when it was asked for and had, on the transport's clock."""

    status: Status
    asked_s: float
    had_s: float


def status_at(ask: Callable[[], Status], now_s: Callable[[], float]) -> Moment[Status]:
    """Asks for a status. Raises what `ask` raises."""
    asked_s = now_s()
    status = ask()
    return Moment(status, asked_s, now_s())


def pace_between(first: Moment[Status], last: Moment[Status]) -> Pace | None:
    """How fast the board's clock runs; None: it restarted in between."""
    board_s = (last.status.uptime_ms - first.status.uptime_ms) / 1000
    if board_s < 0.0:
        return None
    middle = (last.asked_s + last.had_s - first.asked_s - first.had_s) / 2
    doubt_s = (last.had_s - last.asked_s + first.had_s - first.asked_s) / 2 + _TICK_S
    return Pace(board_s, middle, doubt_s)
