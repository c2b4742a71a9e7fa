"""Resets: what the board knew, it goes on with where that moves nothing; else it holds still and says so."""

from __future__ import annotations

import pytest

from tests.sequencer.board import (
    JOINTS,
    OLD,
    STROKE_LINE,
    Board,
    Reset,
    assert_servo_signal,
    client,
    connect,
    pulses,
    release,
    rows,
    width_ns,
)
from tfsat_host.devices.client import BoardRefusal
from tfsat_host.protocol.enums import ErrorCode, ResetCause, SequencerState
from tfsat_host.protocol.limits import JOG_CONFIRM, RELEASE_DEBOUNCE_US, STROKE_NOT_BEGUN_US
from tfsat_host.protocol.messages import (
    ArmReply,
    ArmRequest,
    JogReply,
    JogRequest,
    RunReportReply,
    RunReportRequest,
)

TICK_NS = 500
SETTLED_US = 2 * RELEASE_DEBOUNCE_US
REPORTED = {
    Reset.WATCHDOG: ResetCause.WATCHDOG,
    Reset.BROWN_OUT: ResetCause.BROWN_OUT,
    Reset.EXTERNAL: ResetCause.EXTERNAL,
}
every_cause = pytest.mark.parametrize("cause", list(Reset))


def into(board: Board, state: SequencerState) -> None:
    """Brings a board that is SAFE into `state`."""
    sequencer = connect(board)
    if state == SequencerState.JOGGING:
        client(board).request(JogRequest(2, 1000, 4000, JOG_CONFIRM), JogReply)
    elif state != SequencerState.SAFE:
        sequencer.arm()
        board.advance(100_000)
        if state == SequencerState.FAULT:
            board.switch(0, opened=True)
            board.reset(Reset.WATCHDOG)
            board.advance(SETTLED_US)
        elif state != SequencerState.ARMED:
            release(board)
            board.advance(100_000 if state == SequencerState.RUNNING else 2_500_000)
    assert sequencer.status().state == state


def reset(board: Board, cause: Reset) -> None:
    """Resets and forgets the edges of before: a pulse that the reset cut is nobody's fault."""
    board.reset(cause)
    board.edges()


def assert_held(board: Board, angles_cdeg: tuple[int, ...]) -> None:
    """Since the edges were last taken each servo has had pulses, all of its angle's width; no stroke."""
    edges = board.edges()
    for joint, angle_cdeg in enumerate(angles_cdeg):
        train = pulses(edges, joint)
        assert_servo_signal(train)
        assert train, f"joint {joint + 1} went limp"
        assert {pulse.width_ns for pulse in train} == {round(width_ns(angle_cdeg) / TICK_NS) * TICK_NS}
    assert pulses(edges, STROKE_LINE) == []


def assert_latched(board: Board, fault: ErrorCode) -> None:
    status = connect(board).status()
    assert (status.state, status.fault) == (SequencerState.FAULT, fault)
    with pytest.raises(BoardRefusal) as caught:
        connect(board).arm()
    assert caught.value.code == ErrorCode.FAULT_LATCHED


@every_cause
def test_armed_with_both_switches_closed_is_armed_again_and_flies_on_time(board: Board, cause: Reset) -> None:
    sequencer = connect(board)
    assert sequencer.status().reset_cause == ResetCause.POWER_ON
    sequencer.arm()
    for number in range(1, 4):
        board.advance(100_000)
        reset(board, cause)
        board.advance(SETTLED_US)
        status = sequencer.status()
        assert (status.state, status.fault) == (SequencerState.ARMED, ErrorCode.NONE)
        assert (status.resets_while_armed, status.reset_cause) == (number, REPORTED[cause])
    board.advance(60_000_000)
    assert_held(board, (0,) * JOINTS)
    released_us = release(board)
    board.advance(2_500_000)
    marks = [pulse.rise_ns for pulse in pulses(board.edges(), STROKE_LINE)]
    assert marks == pytest.approx([1000 * (released_us + start) for _, _, start in rows(OLD)], abs=TICK_NS)
    status = sequencer.status()
    assert (status.state, status.resets_while_armed) == (SequencerState.DONE, 3)
    assert sequencer.disarm() == SequencerState.SAFE
    assert sequencer.status().resets_while_armed == 0


@every_cause
@pytest.mark.parametrize("opened", [(0,), (1,), (0, 1)])
@pytest.mark.parametrize("after_us", [-1000, 0, 1, 2500, RELEASE_DEBOUNCE_US - 100])
def test_armed_with_a_switch_open_holds_still(
    board: Board, opened: tuple[int, ...], after_us: int, cause: Reset
) -> None:
    connect(board).arm()
    board.advance(100_000)
    if after_us > 0:
        reset(board, cause)
        board.advance(after_us)
    for index in opened:
        board.switch(index, opened=True)
    if after_us <= 0:
        board.advance(-after_us)
        reset(board, cause)
    board.advance(3_000_000)
    assert_latched(board, ErrorCode.RESET_WHILE_ARMED)
    assert connect(board).status().resets_while_armed == 1
    assert_held(board, (0,) * JOINTS)
    for index in opened:
        board.switch(index, opened=False)
    board.advance(100_000)
    reset(board, cause)
    board.advance(100_000)
    assert_latched(board, ErrorCode.RESET_WHILE_ARMED)
    assert_held(board, (0,) * JOINTS)
    assert connect(board).disarm() == SequencerState.SAFE
    assert connect(board).status().fault == ErrorCode.NONE
    assert connect(board).arm() == SequencerState.ARMED


@pytest.mark.parametrize("index", [0, 1])
@pytest.mark.parametrize("after_us", [100, 2000, 4500])
def test_a_switch_that_bounces_after_the_reset_is_not_closed(board: Board, index: int, after_us: int) -> None:
    connect(board).arm()
    board.reset(Reset.WATCHDOG)
    board.advance(after_us)
    board.switch(index, opened=True)
    board.advance(100)
    board.switch(index, opened=False)
    board.advance(1_000_000)
    assert_latched(board, ErrorCode.RESET_WHILE_ARMED)


@every_cause
def test_a_drop_right_after_the_board_is_armed_again(board: Board, cause: Reset) -> None:
    connect(board).arm()
    reset(board, cause)
    board.advance(RELEASE_DEBOUNCE_US + 100)
    released_us = release(board)
    board.advance(2_500_000)
    marks = [pulse.rise_ns for pulse in pulses(board.edges(), STROKE_LINE)]
    assert marks == pytest.approx([1000 * (released_us + start) for _, _, start in rows(OLD)], abs=TICK_NS)


@every_cause
@pytest.mark.parametrize(
    ("after_us", "angles_cdeg"),
    [
        (6000, (0, 0, 0)),
        (699_900, (0, 0, 0)),
        (701_600, (0, 0, 0)),  # its first pulse is cut short by the reset
        (701_700, (5900, 0, 0)),
        (1_200_000, (5900, 7000, 0)),
        (1_471_100, (0, 7000, 0)),
        (1_900_000, (0, 0, 0)),
    ],
)
def test_running_ends_where_the_strokes_had_come_to(
    board: Board, after_us: int, angles_cdeg: tuple[int, ...], cause: Reset
) -> None:
    connect(board).arm()
    release(board)
    board.advance(after_us)
    reset(board, cause)
    board.advance(3_000_000)
    assert_latched(board, ErrorCode.RESET_WHILE_RUNNING)
    assert_held(board, angles_cdeg)
    reset(board, cause)
    board.advance(100_000)
    assert_latched(board, ErrorCode.RESET_WHILE_RUNNING)
    assert_held(board, angles_cdeg)


def assert_safe_and_silent(board: Board) -> None:
    status = connect(board).status()
    assert (status.state, status.fault) == (SequencerState.SAFE, ErrorCode.NONE)
    assert status.resets_while_armed == 0
    assert status.joint_angle_cdeg == (0, 0, 0)
    release(board)
    board.advance(3_000_000)
    assert board.edges() == []
    assert connect(board).status().state == SequencerState.SAFE


@every_cause
@pytest.mark.parametrize("state", [SequencerState.SAFE, SequencerState.DONE, SequencerState.JOGGING])
def test_what_need_not_be_kept_starts_safe_and_silent(
    board: Board, state: SequencerState, cause: Reset
) -> None:
    into(board, state)
    reset(board, cause)
    board.advance(SETTLED_US)
    assert_safe_and_silent(board)
    assert connect(board).status().reset_cause == REPORTED[cause]


@pytest.mark.parametrize("state", list(SequencerState))
def test_a_power_cycle_starts_safe_and_silent_in_any_state(board: Board, state: SequencerState) -> None:
    into(board, state)
    board.power(False)
    board.advance(50_000)
    board.edges()
    board.power(True)
    board.advance(SETTLED_US)
    assert_safe_and_silent(board)
    assert connect(board).status().reset_cause == ResetCause.POWER_ON


@pytest.mark.parametrize("state", list(SequencerState))
def test_no_token_from_before_a_reset_arms(board: Board, state: SequencerState) -> None:
    into(board, state)
    tokens = {connect(board).status().arm_token}
    for cause in [*Reset, *Reset]:
        board.reset(cause)
        board.advance(SETTLED_US)
        token = connect(board).status().arm_token
        assert token not in tokens
        tokens.add(token)
    for index in (0, 1):
        board.switch(index, opened=False)
    connect(board).disarm()
    for token in tokens - {connect(board).status().arm_token}:
        with pytest.raises(BoardRefusal) as caught:
            client(board).request(ArmRequest(token), ArmReply)
        assert caught.value.code == ErrorCode.STALE_TOKEN


@every_cause
def test_knocks_and_the_last_run_survive_a_reset_and_no_power_cut(board: Board, cause: Reset) -> None:
    sequencer = connect(board)
    sequencer.arm()
    for opened in (True, False):
        for index in (0, 1):
            board.switch(index, opened=opened)
        board.advance(1000 if opened else 50_000)
    reset(board, cause)
    board.advance(SETTLED_US)
    assert sequencer.status().knocks == 1
    release(board)
    board.advance(1_000_000)
    before = client(board).request(RunReportRequest(), RunReportReply)
    assert (before.released, before.stroke_count) == (1, 4)
    assert [start_us != STROKE_NOT_BEGUN_US for start_us in before.start_us[:4]] == [
        True,
        False,
        False,
        False,
    ]
    reset(board, cause)
    board.advance(SETTLED_US)
    assert sequencer.status().knocks == 1
    assert client(board).request(RunReportRequest(), RunReportReply) == before
    board.power_cycle()
    assert sequencer.status().knocks == 0
    assert client(board).request(RunReportRequest(), RunReportReply).released == 0
