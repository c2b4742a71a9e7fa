"""What may be armed, and what ends an arming or a run."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.sequencer.board import (
    JOINTS,
    NEW,
    OLD,
    STROKE_LINE,
    Board,
    assert_servo_signal,
    client,
    connect,
    pulses,
    release,
    rows,
    width_ns,
)
from tfsat_host.devices.client import BoardRefusal
from tfsat_host.maneuver import Maneuver, Stroke, schedule_maneuver
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.messages import (
    ArmReply,
    ArmRequest,
    ErrorReply,
)
from tfsat_host.servo_settings import FACTORY

TICK_NS = 500


@pytest.mark.parametrize(("opened", "mask"), [((0,), 1), ((1,), 2), ((0, 1), 3)])
def test_arming_with_an_open_switch_is_refused(board: Board, opened: tuple[int, ...], mask: int) -> None:
    sequencer = connect(board)
    for index in opened:
        board.switch(index, opened=True)
    with pytest.raises(BoardRefusal) as caught:
        sequencer.arm()
    assert (caught.value.code, caught.value.detail, caught.value.exit_code) == (
        ErrorCode.SWITCH_OPEN,
        mask,
        4,
    )
    board.advance(100_000)
    assert sequencer.status().state == SequencerState.SAFE
    assert sequencer.status().last_refusal == ErrorCode.SWITCH_OPEN
    assert board.edges() == []
    for index in opened:
        board.switch(index, opened=False)
    assert sequencer.arm() == SequencerState.ARMED
    assert sequencer.status().last_refusal == ErrorCode.NONE


def test_arming_while_running_is_refused_and_moves_no_stroke(board: Board) -> None:
    sequencer = connect(board)
    sequencer.arm()
    released_us = release(board)
    board.advance(10_000)
    for _ in range(3):
        with pytest.raises(BoardRefusal) as caught:
            sequencer.arm()
        assert caught.value.code == ErrorCode.WRONG_STATE
    board.advance(2_400_000)
    marks = [pulse.rise_ns for pulse in pulses(board.edges(), STROKE_LINE)]
    assert marks == pytest.approx([1000 * (released_us + start) for _, _, start in rows(OLD)], abs=TICK_NS)


def test_a_token_of_an_earlier_state_does_not_arm(board: Board) -> None:
    sequencer = connect(board)
    token = sequencer.status().arm_token
    link = client(board)
    assert link.request(ArmRequest(token), ArmReply).state == SequencerState.ARMED
    assert link.request(ArmRequest(token), ArmReply).state == SequencerState.ARMED  # the second copy
    sequencer.disarm()
    for stale in (token, (token + 1) & 0xFFFF, (token - 1) & 0xFFFF):
        with pytest.raises(BoardRefusal) as caught:
            link.request(ArmRequest(stale), ArmReply)
        assert caught.value.code == ErrorCode.STALE_TOKEN
    assert sequencer.status().state == SequencerState.SAFE


@pytest.mark.parametrize("after_us", [0, 3000, 6000, 350_000, 1_052_000, 1_600_123])
def test_disarming_stops_the_pulses_in_any_state(board: Board, after_us: int) -> None:
    sequencer = connect(board)
    sequencer.arm()
    board.advance(100_000)
    release(board)
    board.advance(after_us)
    assert sequencer.disarm() == SequencerState.SAFE
    stopped_ns = 1000 * board.now_us
    board.advance(3_000_000)
    edges = board.edges()
    for pin in range(JOINTS):
        train = pulses(edges, pin)
        assert_servo_signal(train)
        assert train[-1].rise_ns <= stopped_ns
    assert sequencer.status().state == SequencerState.SAFE
    assert len(pulses(edges, STROKE_LINE)) == sequencer.status().strokes_started


def test_done_can_be_armed_again_and_flies_again(board: Board) -> None:
    sequencer = connect(board)
    for _ in range(3):
        assert sequencer.arm() == SequencerState.ARMED
        released_us = release(board)
        board.advance(2_500_000)
        assert sequencer.status().state == SequencerState.DONE
        marks = [pulse.rise_ns for pulse in pulses(board.edges(), STROKE_LINE)]
        assert marks == pytest.approx(
            [1000 * (released_us + start) for _, _, start in rows(OLD)], abs=TICK_NS
        )
        with pytest.raises(BoardRefusal) as caught:
            sequencer.arm()
        assert caught.value.code == ErrorCode.SWITCH_OPEN
        board.switch(0, opened=False)
        board.switch(1, opened=False)
        board.advance(30_000)
        assert sequencer.status().state == SequencerState.DONE


@pytest.mark.parametrize("state", [SequencerState.ARMED, SequencerState.RUNNING, SequencerState.DONE])
def test_uploads_are_refused_unless_safe(board: Board, state: SequencerState) -> None:
    sequencer = connect(board)
    sequencer.arm()
    if state != SequencerState.ARMED:
        release(board)
        board.advance(100_000 if state == SequencerState.RUNNING else 2_500_000)
    assert sequencer.status().state == state
    image = board.eeprom()
    with pytest.raises(BoardRefusal) as caught:
        sequencer.upload(NEW)
    assert (caught.value.code, caught.value.exit_code) == (ErrorCode.WRONG_STATE, 4)
    assert "disarm" in caught.value.next_step
    board.advance(500_000)
    assert board.eeprom() == image
    assert sequencer.read_back().strokes == rows(OLD)
    sequencer.disarm()
    assert sequencer.upload(NEW).written


@pytest.mark.parametrize("state", ["armed", "running"])
def test_a_pulled_cable_changes_nothing(board: Board, state: str) -> None:
    sequencer = connect(board)
    sequencer.arm()
    if state == "armed":
        board.cable(False)
        board.advance(60_000_000)
    released_us = release(board)
    board.advance(500_000)
    board.cable(False)
    board.advance(2_000_000)
    board.cable(True)
    marks = [pulse.rise_ns for pulse in pulses(board.edges(), STROKE_LINE)]
    assert marks == pytest.approx([1000 * (released_us + start) for _, _, start in rows(OLD)], abs=TICK_NS)
    assert connect(board).status().state == SequencerState.DONE


def test_status_of_a_shorter_maneuver_after_a_run(new_board: Callable[..., Board]) -> None:
    """STATUS counts the last run's strokes; a maneuver uploaded since may have fewer."""
    board = new_board(b"\x33" * 1024)
    sequencer = connect(board)
    sequencer.upload(OLD)
    sequencer.write_settings(FACTORY)
    sequencer.arm()
    release(board)
    board.advance(2_500_000)
    board.switch(0, opened=False)
    board.switch(1, opened=False)
    sequencer.disarm()
    sequencer.upload(schedule_maneuver(Maneuver((Stroke(3, 77.0),))))
    status = sequencer.status()
    assert status.strokes_started == 4
    assert status.joint_angle_cdeg == (0, 0, 0)


def test_each_disarm_is_answered_and_outdates_every_arm_from_before_it(board: Board) -> None:
    sequencer = connect(board)
    for _ in range(3):
        token = sequencer.status().arm_token
        board.switch(0, opened=True)
        with pytest.raises(BoardRefusal):
            sequencer.arm()
        assert sequencer.disarm() == SequencerState.SAFE
        board.switch(0, opened=False)
        (answer,) = board.ask(Frame(ArmRequest.TYPE, 9, ArmRequest(token).encode()))
        assert ErrorReply.decode(answer.payload).code == ErrorCode.STALE_TOKEN
        assert sequencer.status().state == SequencerState.SAFE


def test_a_run_that_ended_far_from_the_start_is_not_armed_until_disarmed(board: Board) -> None:
    sequencer = connect(board)
    sequencer.upload(schedule_maneuver(Maneuver((Stroke(2, 10.01),))))
    sequencer.arm()
    release(board)
    board.advance(2_500_000)
    for index in (0, 1):
        board.switch(index, opened=False)
    with pytest.raises(BoardRefusal) as caught:
        sequencer.arm()
    assert caught.value.code == ErrorCode.NOT_AT_START_POSE
    board.advance(100_000)
    assert pulses(board.edges(), 1)[-1].width_ns == pytest.approx(width_ns(1001), abs=TICK_NS)
    sequencer.disarm()
    assert sequencer.arm() == SequencerState.ARMED
