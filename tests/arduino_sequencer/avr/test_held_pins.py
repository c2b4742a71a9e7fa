"""A servo pin that is held: what the board says of it, and what it tells the servo after a reset."""

from __future__ import annotations

import pytest

from tests.fixtures.sequencer.board import AvrBoard, PinHold, ResetCause
from tests.fixtures.sequencer.cable import connect
from tests.fixtures.sequencer.pulses import onsets_ns, pulses
from tfsat_host.protocol.enums import ErrorCode, SequencerState

AFTER_TWO_STROKES_US = 1_200_000
BEFORE_THE_LAST_US = 1_500_000
START_POSE_NS, JOINT_2_OPEN_NS = 1_000_000, 1_778_000


def fall(board: AvrBoard) -> None:
    client = connect(board)
    client.arm()
    board.run(50_000)
    client.close()
    for index in (0, 1):
        board.switch(index, closed=False)


@pytest.mark.parametrize("hold", [PinHold.LOW, PinHold.HIGH])
def test_no_joint_moves_after_a_reset_when_the_pin_of_another_was_held(
    sequencer: AvrBoard, hold: PinHold
) -> None:
    sequencer.hold_pin(1, hold)
    fall(sequencer)
    # Strokes 1 and 2 are due by then.
    sequencer.run(AFTER_TWO_STROKES_US)
    assert [joint for joint, _ in onsets_ns(sequencer.edges())] == [2]
    status = connect(sequencer).status()
    # Joint 1 got no pulse: its stroke has not begun, and its angle is where it was.
    assert status.strokes_started == 1
    assert status.joint_angle_cdeg == (0, 7000, 0)
    sequencer.hold_pin(1, PinHold.FREE)
    sequencer.reset(ResetCause.BROWN_OUT)
    sequencer.edges()
    sequencer.run(100_000)
    edges = sequencer.edges()
    widths = [{pulse.width_ns for pulse in pulses(edges, pin)} for pin in range(3)]
    # After the reset each servo is held where it was told to be: joint 1 at its start, joint 2 open.
    assert widths == [{START_POSE_NS}, {JOINT_2_OPEN_NS}, {START_POSE_NS}]
    sequencer.cable(False)
    status = connect(sequencer).status()
    assert (status.state, status.fault) == (SequencerState.FAULT, ErrorCode.RESET_WHILE_RUNNING)
    assert status.joint_angle_cdeg == (0, 7000, 0)


@pytest.mark.parametrize("hold", [PinHold.LOW, PinHold.HIGH])
def test_a_pin_that_is_let_go_after_the_run_moves_no_joint(sequencer: AvrBoard, hold: PinHold) -> None:
    fall(sequencer)
    sequencer.run(BEFORE_THE_LAST_US)
    sequencer.hold_pin(2, hold)
    sequencer.run(1_000_000)
    sequencer.edges()
    sequencer.hold_pin(2, PinHold.FREE)
    sequencer.run(100_000)
    # A pulse that was high when it was let go is not whole: it is left out.
    pin_edges = [edge for edge in sequencer.edges() if edge.pin == 1]
    widths = {pulse.width_ns for pulse in pulses(pin_edges[not pin_edges[0].high :], 1)}
    assert widths == {JOINT_2_OPEN_NS}
    status = connect(sequencer).status()
    assert (status.state, status.fault) == (SequencerState.FAULT, ErrorCode.STROKE_MISSED)
    # Stroke 4 would have closed joint 2: it never came, so that the joint stays open.
    assert (status.strokes_started, status.joint_angle_cdeg) == (3, (0, 7000, 0))


@pytest.mark.parametrize("within_us", [-300, 300, 1_000, 1_700])
def test_a_first_pulse_that_is_cut_is_not_the_stroke(sequencer: AvrBoard, within_us: int) -> None:
    """D10 is held low for a moment at the first pulse of stroke 2: the next pulse begins it, a frame later."""
    fall(sequencer)
    sequencer.run(1_050_000 + within_us)
    sequencer.hold_pin(2, PinHold.LOW)
    sequencer.run(500)
    sequencer.hold_pin(2, PinHold.FREE)
    sequencer.run(100_000)
    report = connect(sequencer).run_report()
    assert report.start_us[0] == 700_000
    # One frame of 20 ms later.
    assert report.start_us[1] == pytest.approx(1_070_000, abs=2_000)
