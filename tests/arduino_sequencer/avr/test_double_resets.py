"""A second reset hits the board while it takes up its servos after the first: none of them moves."""

from __future__ import annotations

from typing import NamedTuple

import pytest

from tests.arduino_sequencer.avr.flight import run_until_lines_are_low
from tests.fixtures.sequencer.board import AvrBoard, ResetCause
from tests.fixtures.sequencer.cable import connect
from tests.fixtures.sequencer.pulses import pulses
from tfsat_host.protocol.enums import ErrorCode, SequencerState

# Start-up reaches what it kept of the run before, and then the servos, about 3 ms after a reset.
BETWEEN_RESETS_US = range(2660, 3800, 45)
GRID = pytest.mark.parametrize("every", [5, pytest.param(1, marks=pytest.mark.prove)])
WATCHED_US = 120_000
MIN_PULSES = 5


class Outcome(NamedTuple):
    state: SequencerState
    fault: ErrorCode
    widths_ns: list[set[int]]
    """Of the whole pulses, by servo."""


START_POSE = [{1_000_000}, {1_000_000}, {1_000_000}]
AFTER_TWO_STROKES = [{1_655_500}, {1_778_000}, {1_000_000}]


def arm(board: AvrBoard) -> None:
    for index in (0, 1):
        board.switch(index, closed=True)
    board.run(20_000)
    board.cable(False)
    client = connect(board)
    client.disarm()
    client.arm()
    board.run(50_000)


def dip_twice(board: AvrBoard, between_us: int) -> Outcome:
    """Cause two brown-outs between two pulses and return the outcome."""
    # Between two pulses, so that none is cut by the first reset.
    run_until_lines_are_low(board)
    board.reset(ResetCause.BROWN_OUT)
    board.run(between_us)
    second_ns = board.now_us * 1000
    board.reset(ResetCause.BROWN_OUT)
    board.run(WATCHED_US)
    edges = board.edges()
    # A pulse that the second reset cuts off is not the firmware's.
    trains = [
        [pulse.width_ns for pulse in pulses(edges, pin) if pulse.rise_ns + pulse.width_ns != second_ns]
        for pin in range(3)
    ]
    # A servo gets no pulses at all or all of them, never a few.
    assert all(train == [] or len(train) >= MIN_PULSES for train in trains)
    board.cable(False)
    status = connect(board).status()
    return Outcome(status.state, status.fault, [set(train) for train in trains])


def assert_held(outcomes: dict[int, Outcome], expected_outcome: Outcome) -> None:
    """Assert that every outcome equals `expected_outcome`, by the time between the resets in us."""
    # Compared as a dictionary: the message has every moment that failed.
    assert {at: outcome for at, outcome in outcomes.items() if outcome != expected_outcome} == {}


@GRID
def test_a_run_that_is_reset_twice_holds_its_joints_where_they_are(sequencer: AvrBoard, every: int) -> None:
    outcomes = {}
    for between_us in BETWEEN_RESETS_US[::every]:
        arm(sequencer)
        for index in (0, 1):
            sequencer.switch(index, closed=False)
        # Two of the four strokes have begun.
        sequencer.run(1_200_000)
        outcomes[between_us] = dip_twice(sequencer, between_us)
    expected_outcome = Outcome(SequencerState.FAULT, ErrorCode.RESET_WHILE_RUNNING, AFTER_TWO_STROKES)
    assert_held(outcomes, expected_outcome)


@GRID
def test_an_armed_board_that_is_reset_twice_holds_its_joints_at_the_start_pose(
    sequencer: AvrBoard, every: int
) -> None:
    outcomes = {}
    for between_us in BETWEEN_RESETS_US[::every]:
        arm(sequencer)
        outcomes[between_us] = dip_twice(sequencer, between_us)
    expected_outcome = Outcome(SequencerState.ARMED, ErrorCode.NONE, START_POSE)
    assert_held(outcomes, expected_outcome)
