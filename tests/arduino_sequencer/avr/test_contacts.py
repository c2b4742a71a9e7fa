"""Contacts that chatter faster than an interrupt can follow do not blind a switch to the release."""

from __future__ import annotations

import random

import pytest

from tests.arduino_sequencer.avr.flight import assert_maneuver_flown
from tests.fixtures.sequencer.board import AvrBoard
from tests.fixtures.sequencer.cable import connect

BETWEEN_SWITCHES_US = 300


def close_with_chatter(board: AvrBoard, index: int, chatter: random.Random) -> None:
    board.switch(index, closed=True)
    for _ in range(chatter.randrange(2, 6)):
        for closed in (False, True):
            # 2 to 14 us: shorter than the interrupt takes.
            board.run(chatter.randrange(2, 15))
            board.switch(index, closed=closed)


def release_cleanly(board: AvrBoard, second: int) -> int:
    """Opens both switches without bounce; returns when `second`, the later, opened, in ns."""
    board.switch(1 - second, closed=False)
    board.run(BETWEEN_SWITCHES_US)
    board.switch(second, closed=False)
    return board.now_us * 1000


@pytest.mark.parametrize("seed", range(8))
def test_chatter_while_the_robot_is_hung_up_moves_no_stroke(sequencer: AvrBoard, seed: int) -> None:
    client = connect(sequencer)
    chatter = random.Random(seed)
    sequencer.switch(0, closed=False)
    sequencer.switch(1, closed=False)
    # Open for longer than the debounce, so that hanging up is a change.
    sequencer.run(20_000)
    for index in (0, 1):
        close_with_chatter(sequencer, index, chatter)
        sequencer.run(20_000)
    client.arm()
    # Another phase of the main loop for each seed.
    sequencer.run(50_000 + chatter.randrange(20_000))
    released_ns = release_cleanly(sequencer, second=seed % 2)
    sequencer.run(2_600_000)
    assert_maneuver_flown(sequencer, released_ns)


@pytest.mark.parametrize(
    ("closed_us", "open_us"), [(4, 12), (6, 10), (8, 8), (8, 12), (10, 6), (10, 10), (12, 4)]
)
def test_a_bounce_at_the_end_of_a_knock_moves_no_stroke(
    sequencer: AvrBoard, closed_us: int, open_us: int
) -> None:
    client = connect(sequencer)
    client.arm()
    sequencer.run(30_000)
    sequencer.switch(0, closed=False)
    # Eight milliseconds open: a knock, and at its end one bounce of some microseconds.
    sequencer.run(8_000)
    sequencer.switch(0, closed=True)
    sequencer.run(closed_us)
    sequencer.switch(0, closed=False)
    sequencer.run(open_us)
    sequencer.switch(0, closed=True)
    # Another phase for each pair of durations.
    sequencer.run(50_000 + 137 * closed_us + 71 * open_us)
    assert client.status().knocks == 1
    released_ns = release_cleanly(sequencer, second=0)
    sequencer.run(2_600_000)
    assert_maneuver_flown(sequencer, released_ns)
