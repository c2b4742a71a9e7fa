"""The board's report of a run, next to the schedule that it flew."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.arduino_sequencer.conftest import board, board_library, new_board
from tests.fixtures.sequencer.board import Board, PinHold
from tests.fixtures.sequencer.cable import NEW, OLD, connect
from tests.fixtures.sequencer.pulses import release
from tfsat_host.devices.last_run import LastRun, Onset, StrokeStatus, last_run
from tfsat_host.devices.sequencer import StoredManeuver
from tfsat_host.protocol.enums import ErrorCode, ResetCause, SequencerState
from tfsat_host.protocol.limits import STROKE_NOT_BEGUN_US, STROKE_TIME_UNKNOWN_US
from tfsat_host.protocol.messages import RunReportReply, SequencerStatusReply

__all__ = ["board", "board_library", "new_board"]


def ask_board(board: Board) -> tuple[RunReportReply, SequencerStatusReply, StoredManeuver]:
    sequencer = connect(board)
    return sequencer.run_report(), sequencer.status(), sequencer.read_back()


def find_run(report: RunReportReply, status: SequencerStatusReply, maneuver: StoredManeuver) -> LastRun:
    run = last_run(report, status, maneuver)
    assert run is not None
    return run


def arm_board(board: Board) -> None:
    connect(board).arm()
    board.run(100_000)


def released_for(board: Board, duration_us: int) -> LastRun:
    arm_board(board)
    release(board)
    board.run(duration_us)
    return find_run(*ask_board(board))


def fly_maneuver(board: Board) -> LastRun:
    return released_for(board, 3_000_000)


def test_no_run_yet(board: Board) -> None:
    assert last_run(*ask_board(board)) is None
    connect(board).arm()
    assert last_run(*ask_board(board)) is None


def test_every_stroke_against_its_schedule(board: Board) -> None:
    arm_board(board)
    uptime_us = connect(board).status().uptime_ms * 1000
    asked_us = board.now_us
    released_us = release(board)
    board.run(3_000_000)
    since_us = board.now_us - released_us
    run = find_run(*ask_board(board))
    assert run.released_us - uptime_us == pytest.approx(released_us - asked_us, abs=3000)
    assert run.since_release_s is not None
    assert since_us / 1e6 - 0.001 <= run.since_release_s <= (board.now_us - released_us) / 1e6 + 0.001
    assert [onset.scheduled_us for onset in run.onsets] == [stroke.t_us for stroke in OLD.strokes]
    for onset in run.onsets:
        assert onset.scheduled_us is not None and onset.error_us is not None
        assert onset.start_us == onset.scheduled_us + onset.error_us
        assert abs(onset.error_us) <= 50
    assert run.bounces >= 0


def test_half_a_run(board: Board) -> None:
    run = released_for(board, 1_200_000)
    assert [onset.scheduled_us for onset in run.onsets] == [stroke.t_us for stroke in OLD.strokes]
    assert [onset.booking for onset in run.onsets] == [StrokeStatus.BEGUN] * 2 + [StrokeStatus.NOT_BEGUN] * 2
    assert (run.begun, run.missed) == (2, 0)
    connect(board).disarm()
    ended = find_run(*ask_board(board))
    assert ended.onsets == run.onsets
    connect(board).upload(NEW)
    ended = find_run(*ask_board(board))
    assert [onset.scheduled_us for onset in ended.onsets] == [None] * 4
    assert [onset.booking for onset in ended.onsets] == [onset.booking for onset in run.onsets]


def test_a_run_that_ended_before_its_first_stroke_tells_nothing_of_its_maneuver(board: Board) -> None:
    released_for(board, 300_000)
    connect(board).disarm()
    assert find_run(*ask_board(board)).onsets == (Onset(StrokeStatus.NOT_BEGUN, None, None),) * 4


def test_after_a_reset_nobody_knows_how_long_ago_it_was(board: Board) -> None:
    fly_maneuver(board)
    flight, status, maneuver = ask_board(board)
    reset = replace(status, state=SequencerState.SAFE, reset_cause=ResetCause.EXTERNAL)
    run = find_run(flight, reset, maneuver)
    assert run.since_release_s is None
    assert run.begun == 4


def test_a_fault_that_is_not_of_the_run_says_nothing_of_its_maneuver(board: Board) -> None:
    fly_maneuver(board)
    flight, status, maneuver = ask_board(board)
    late = replace(flight, start_us=(flight.start_us[0] + 9000, *flight.start_us[1:]))
    for fault, compared in (
        (ErrorCode.RESET_WHILE_ARMED, False),
        (ErrorCode.RESET_WHILE_RUNNING, True),
        (ErrorCode.STROKE_MISSED, True),
    ):
        run = find_run(late, replace(status, state=SequencerState.FAULT, fault=fault), maneuver)
        assert (run.onsets[0].error_us is not None) == compared


def test_after_disarm_the_same_schedule_is_recognised(board: Board) -> None:
    before = fly_maneuver(board)
    connect(board).disarm()
    after = find_run(*ask_board(board))
    assert after.onsets == before.onsets


def test_a_maneuver_uploaded_since_is_not_compared_with(board: Board) -> None:
    before = fly_maneuver(board)
    sequencer = connect(board)
    sequencer.disarm()
    sequencer.upload(NEW)
    after = find_run(*ask_board(board))
    assert [onset.start_us for onset in after.onsets] == [onset.start_us for onset in before.onsets]
    assert {onset.error_us for onset in after.onsets} == {None}


def test_a_late_stroke_is_compared_while_its_maneuver_is_surely_there(board: Board) -> None:
    fly_maneuver(board)
    late, status, maneuver = ask_board(board)
    late = replace(late, start_us=(late.start_us[0] + 9000, *late.start_us[1:]))
    assert status.state == SequencerState.DONE
    run = find_run(late, status, maneuver)
    assert run.onsets[0].error_us == pytest.approx(9000, abs=50)
    run = find_run(late, replace(status, state=SequencerState.SAFE), maneuver)
    assert run.onsets[0].error_us is None


def test_a_stroke_that_was_passed_over_was_missed(board: Board) -> None:
    fly_maneuver(board)
    flight, status, maneuver = ask_board(board)

    def stroke_bookings(*strokes: int | None, fault: ErrorCode = ErrorCode.NONE) -> list[StrokeStatus]:
        starts_us = [STROKE_NOT_BEGUN_US if start_us is None else start_us for start_us in strokes]
        report = replace(flight, start_us=(*starts_us, *flight.start_us[4:]))
        run = find_run(report, replace(status, fault=fault), maneuver)
        return [onset.booking for onset in run.onsets]

    begun, missed, not_begun = StrokeStatus.BEGUN, StrokeStatus.MISSED, StrokeStatus.NOT_BEGUN
    assert stroke_bookings(None, 1_050_000, None, None) == [missed, begun, not_begun, not_begun]
    assert stroke_bookings(700_000, None, None, None, fault=ErrorCode.STROKE_MISSED) == [
        begun,
        missed,
        missed,
        missed,
    ]
    unknown = STROKE_TIME_UNKNOWN_US
    assert stroke_bookings(None, unknown, None, None) == [
        missed,
        StrokeStatus.BEGUN_UNTIMED,
        not_begun,
        not_begun,
    ]


def test_a_pin_that_was_held_and_let_go_is_a_late_stroke(board: Board) -> None:
    board.hold_pin(1, PinHold.LOW)
    arm_board(board)
    release(board)
    board.run(1_000_000)
    board.hold_pin(1, PinHold.FREE)
    board.run(2_000_000)
    run = find_run(*ask_board(board))
    assert (run.begun, run.missed) == (4, 0)
    late_us = run.onsets[0].error_us
    assert late_us is not None and 300_000 <= late_us <= 320_000
    assert connect(board).status().state == SequencerState.DONE


def test_a_pin_that_is_held_misses_its_strokes(board: Board) -> None:
    board.hold_pin(1, PinHold.HIGH)
    run = fly_maneuver(board)
    assert [onset.booking for onset in run.onsets] == [StrokeStatus.MISSED, StrokeStatus.BEGUN] * 2
    assert connect(board).status().fault == ErrorCode.STROKE_MISSED
