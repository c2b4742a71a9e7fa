"""A USB host that takes milliseconds over each stage of a control transfer, or resets the bus, stretches no pulse."""

from __future__ import annotations

import pytest

from tests.arduino_sequencer.avr.flight import run_until_lines_are_low
from tests.fixtures.sequencer.board import AvrBoard, ResetCause
from tests.fixtures.sequencer.cable import connect
from tests.fixtures.sequencer.pulses import pulses
from tfsat_host.protocol.enums import SequencerState

HOLD_WIDTH_NS = 1_000_000
FRAME_US = 20_000


def reset_while_armed(board: AvrBoard) -> None:
    """Reset the armed board by the watchdog between two pulses, cable in: the host enumerates it again."""
    connect(board).arm()
    board.run(50_000)
    run_until_lines_are_low(board)
    board.reset(ResetCause.WATCHDOG)


def assert_only_whole_pulses(board: AvrBoard, run_us: int) -> None:
    """Assert that each line has a whole pulse in every frame but the first few, never stuck high or low."""
    edges = board.edges()
    for pin in range(3):
        train = pulses(edges, pin)
        assert {pulse.width_ns for pulse in train} == {HOLD_WIDTH_NS}
        # The first frames after a reset may be missing.
        assert len(train) > run_us // FRAME_US - 3


@pytest.mark.parametrize("pause_us", [1000, 2000, 3000])
def test_a_host_that_enumerates_during_start_up_stretches_no_pulse(
    sequencer: AvrBoard, pause_us: int
) -> None:
    sequencer.usb_stage_pause(pause_us)
    reset_while_armed(sequencer)
    sequencer.run(600_000)
    assert_only_whole_pulses(sequencer, 600_000)
    sequencer.cable(False)
    status = connect(sequencer).status()
    assert (status.state, status.resets_while_armed) == (SequencerState.ARMED, 1)


@pytest.mark.parametrize("pause_us", [1000, 2000, 3000])
@pytest.mark.parametrize("pulled_after_us", range(24_000, 36_000, 1500))
def test_a_cable_pulled_during_start_up_leaves_no_line_high(
    sequencer: AvrBoard, pause_us: int, pulled_after_us: int
) -> None:
    sequencer.usb_stage_pause(pause_us)
    reset_while_armed(sequencer)
    sequencer.run(pulled_after_us)
    sequencer.cable(False)
    sequencer.run(300_000)
    assert_only_whole_pulses(sequencer, 300_000)
    sequencer.usb_stage_pause(0)
    status = connect(sequencer).status()
    assert (status.state, status.resets_while_armed) == (SequencerState.ARMED, 1)


@pytest.mark.parametrize("after_us", range(0, 20_000, 150))
def test_a_bus_reset_with_a_request_right_after_it_stretches_no_pulse(
    sequencer: AvrBoard, after_us: int
) -> None:
    """Bus resets that a request follows immediately stretch no pulse.

    The Arduino core's reset handler can be interrupted by its request handler, which waits for the host.
    """
    client = connect(sequencer)
    client.arm()
    sequencer.run(50_000 + after_us)
    run_until_lines_are_low(sequencer)
    # A stage of 30 ms is longer than a frame.
    sequencer.usb_stage_pause(30_000)
    for _ in range(3):
        # Three bus resets, each while the last request still waits.
        sequencer.reset_usb_bus()
        sequencer.run(40_000)
    sequencer.cable(False)
    sequencer.run(100_000)
    assert_only_whole_pulses(sequencer, 220_000)
    sequencer.usb_stage_pause(0)
    assert connect(sequencer).status().state == SequencerState.ARMED
