"""The real host client talking to the emulated board, and what its servo lines say."""

from __future__ import annotations

import random
from dataclasses import dataclass
from itertools import pairwise

from tests.emulator_avr.avr_board import AvrBoard, Edge
from tfsat_host.devices.sequencer import SequencerClient

STROKE_LINE = 3


class BoardTransport:
    """The cable, in the board's virtual time."""

    def __init__(self, board: AvrBoard) -> None:
        self._board = board

    @property
    def name(self) -> str:
        return "emulated Arduino Micro"

    def now_s(self) -> float:
        return self._board.now_us / 1e6

    def write(self, data: bytes) -> None:
        while data:
            data = data[self._board.send(data) :]
            self._board.run(250)

    def read(self, timeout_s: float) -> bytes:
        deadline_s = self.now_s() + timeout_s
        while not (data := self._board.receive()) and self.now_s() < deadline_s:
            self._board.run(250)
        return data

    def close(self) -> None:
        self._board.cable(False)


@dataclass(frozen=True)
class Pulse:
    rise_ns: int
    width_ns: int


def pulses(edges: list[Edge], pin: int) -> list[Pulse]:
    """The complete pulses on one pin."""
    mine = [edge for edge in edges if edge.pin == pin]
    if mine and not mine[0].high:
        raise ValueError(f"pin {pin} falls at {mine[0].t_ns} ns before it rises")
    whole = mine[: len(mine) // 2 * 2]
    return [
        Pulse(rise.t_ns, fall.t_ns - rise.t_ns) for rise, fall in zip(whole[::2], whole[1::2], strict=True)
    ]


def onsets_ns(edges: list[Edge]) -> list[tuple[int, int]]:
    """(joint, rise) of the first pulse of each new width, in order of time."""
    found = [
        (after.rise_ns, joint + 1)
        for joint in range(3)
        for before, after in pairwise(pulses(edges, joint))
        if after.width_ns != before.width_ns
    ]
    return [(joint, rise_ns) for rise_ns, joint in sorted(found)]


def release(board: AvrBoard, seed: int) -> int:
    """Opens both switches with bounce; returns when both were open for the first time, in ns."""
    random_ = random.Random(seed)
    changes = []
    for index in (0, 1):
        t_us = board.now_us + random_.randrange(100, 600)
        changes.append((t_us, index, False))
        for _ in range(random_.randrange(6)):
            t_us += random_.randrange(20, 300)
            changes.append((t_us, index, True))
            t_us += random_.randrange(20, 150)
            changes.append((t_us, index, False))
    closed = [True, True]
    both_open_us = []
    for t_us, index, is_closed in sorted(changes):
        board.run_to(t_us)
        board.switch(index, closed=is_closed)
        closed[index] = is_closed
        if not any(closed):
            both_open_us.append(t_us)
    return both_open_us[0] * 1000


def connect(board: AvrBoard) -> SequencerClient:
    board.connect()
    return SequencerClient.connect(BoardTransport(board))
