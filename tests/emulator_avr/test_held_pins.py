"""A servo pin that is held: what the board says of it, and what it tells the servo after a reset."""

from __future__ import annotations

import pytest

from tests.emulator_avr.avr_board import AvrBoard, PinHold, ResetCause
from tests.emulator_avr.board_link import connect
from tests.emulator_avr.flight import onsets_ns, pulses
from tfsat_host.protocol.enums import ErrorCode, SequencerState

BEFORE_FIRST_STROKE_US = 690_000
AFTER_TWO_STROKES_US = 1_200_000
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
    sequencer.run(AFTER_TWO_STROKES_US)
    assert [joint for joint, _ in onsets_ns(sequencer.edges())] == [2]
    status = connect(sequencer).status()
    assert status.strokes_started == 1
    assert status.joint_angle_cdeg == (0, 7000, 0)
    run_until_lines_are_low_but(sequencer)
    sequencer.hold_pin(1, PinHold.FREE)
    sequencer.reset(ResetCause.BROWN_OUT)
    sequencer.edges()
    sequencer.run(100_000)
    edges = sequencer.edges()
    widths = [{pulse.width_ns for pulse in pulses(edges, pin)} for pin in range(3)]
    assert widths == [{START_POSE_NS}, {JOINT_2_OPEN_NS}, {START_POSE_NS}]
    sequencer.cable(False)
    status = connect(sequencer).status()
    assert (status.state, status.fault) == (SequencerState.FAULT, ErrorCode.RESET_WHILE_RUNNING)
    assert status.joint_angle_cdeg == (0, 7000, 0)


def run_until_lines_are_low_but(board: AvrBoard) -> None:
    board.edges()
    board.run(5_000)
