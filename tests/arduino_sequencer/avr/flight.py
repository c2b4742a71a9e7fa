"""What the emulated board's servo lines say."""

from __future__ import annotations

import random
from itertools import pairwise

from tests.fixtures.sequencer.board import STROKE_LINE, AvrBoard
from tests.fixtures.sequencer.cable import OLD
from tests.fixtures.sequencer.pulses import onsets_ns, pulses

STROKES = [(stroke.joint, stroke.t_us) for stroke in OLD.strokes]
TICK_NS = 500
NOISE_CANCELER_NS = 250


def release(board: AvrBoard, seed: int) -> int:
    """Opens both switches with bounce; returns when both were open for the first time, in ns."""
    random_ = random.Random(seed)
    changes = []
    # Each switch opens within half a millisecond of the other and bounces up to five times.
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
        # The release is the first moment at which both are open, whatever bounces after it.
        if not any(closed):
            both_open_us.append(t_us)
    return both_open_us[0] * 1000


def run_until_lines_are_low(board: AvrBoard) -> None:
    """Takes all edges so far and goes on until no servo line is within a pulse."""
    high: set[int] = set()
    while True:
        for edge in board.edges():
            # A pin whose last edge rose is within a pulse.
            (high.add if edge.high else high.discard)(edge.pin)
        if not high:
            return
        board.run(50)


def assert_maneuver_flown(board: AvrBoard, released_ns: int) -> None:
    """Assert that the pins flew 59/70 since the last call of `edges()`.

    Strokes are exact to the tick, pulses whole, frames even, and each stroke has its mark.
    """
    edges = board.edges()
    onsets = onsets_ns(edges)
    # The strokes' order first: times are compared pair by pair.
    assert [joint for joint, _ in onsets] == [joint for joint, _ in STROKES]
    for (_, onset_ns), (_, start_us) in zip(onsets, STROKES, strict=True):
        # At most a tick early, and late by no more than the noise canceler delays an edge.
        assert -TICK_NS <= onset_ns - released_ns - start_us * 1000 <= NOISE_CANCELER_NS

    widths_us = [sorted({pulse.width_ns / 1000 for pulse in pulses(edges, pin)}) for pin in range(3)]
    # Joint 1 at 0 and 59 deg, joint 2 at 0 and 70, joint 3 at rest: no width in between.
    assert widths_us == [[1000, 1655.5], [1000, 1778], [1000]]
    for pin in range(3):
        gaps_ms = [(after.rise_ns - before.rise_ns) / 1e6 for before, after in pairwise(pulses(edges, pin))]
        # A frame stays 20 ms across the strokes: a servo gets no pulse too soon or too late.
        assert 19.5 <= min(gaps_ms) <= max(gaps_ms) <= 20.5

    marks = pulses(edges, STROKE_LINE)
    assert len(marks) == len(onsets)
    for mark, (_, onset_ns) in zip(marks, onsets, strict=True):
        # The stroke line follows the pulse within the time that other interrupts may take.
        assert 0 < mark.rise_ns - onset_ns < 60_000
        # Its end may wait for the interrupts of all three servo edges.
        assert 990_000 < mark.width_ns < 1_250_000
