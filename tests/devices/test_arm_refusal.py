"""What the host says of ARM beforehand is what the board answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.arduino_sequencer.conftest import board, board_library, fresh_board, new_board
from tests.fixtures.sequencer.board import Board, ResetCause
from tests.fixtures.sequencer.cable import client, connect
from tests.fixtures.sequencer.pulses import release
from tfsat_host.devices.arm_refusal import arm_refusal, joints_off_start_pose
from tfsat_host.devices.board_errors import BoardError, BoardRefusal
from tfsat_host.maneuver import Maneuver, Stroke, schedule_maneuver
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.limits import JOG_CONFIRM, JOINT_REPORT_AGE_MS
from tfsat_host.protocol.messages import JogReply, JogRequest, ManeuverBeginRequest
from tfsat_host.protocol.remedies import REMEDIES
from tfsat_host.servo_settings import FACTORY

__all__ = ["board", "board_library", "fresh_board", "new_board"]

AT_REST = (0, 0, 0)
BENDS_JOINT_1 = schedule_maneuver(Maneuver((Stroke(joint=1, angle_deg=59.0),), 170.0))
FOLDED_45 = replace(FACTORY, servos=tuple(replace(servo, max_cdeg=4500) for servo in FACTORY.servos))


def _finish_run(board: Board) -> None:
    _arm_board(board)
    release(board)
    board.run(3_000_000)


def _done_and_seated(board: Board) -> None:
    _finish_run(board)
    board.switch(0, closed=True)
    board.switch(1, closed=True)
    board.run(10_000)


def _done_and_bent(board: Board) -> None:
    connect(board).upload(BENDS_JOINT_1)
    _done_and_seated(board)


def _arm_board(board: Board) -> None:
    connect(board).arm()
    board.run(10_000)


def _begin_run(board: Board) -> None:
    _arm_board(board)
    release(board)
    board.run(1_000_000)


def _faulty(board: Board) -> None:
    _arm_board(board)
    board.switch(1, closed=False)
    board.reset(ResetCause.WATCHDOG)
    board.run(100_000)


def _begin_jog(board: Board) -> None:
    client(board).request(JogRequest(1, 0, 1000, JOG_CONFIRM), JogReply)


def _open(board: Board) -> None:
    board.switch(1, closed=False)


def _limit_angles(board: Board) -> None:
    connect(board).write_settings(FOLDED_45)


def predict_refusal(board: Board, joints_cdeg: Sequence[int] | None = None) -> BoardError | None:
    sequencer = connect(board)
    stored = sequencer.read_back()
    return arm_refusal(sequencer.status(), stored, sequencer.settings().settings, joints_cdeg)


def try_to_arm(board: Board) -> ErrorCode | None:
    try:
        connect(board).arm()
    except BoardError as error:
        return error.code
    return None


@pytest.mark.parametrize(
    ("do", "code", "words"),
    [
        (lambda _: None, None, ""),
        (_done_and_seated, None, ""),
        (_done_and_bent, ErrorCode.NOT_AT_START_POSE, "but joint 1 is held at 59 deg"),
        (_open, ErrorCode.SWITCH_OPEN, "A release switch is open (switch 2)."),
        (_finish_run, ErrorCode.SWITCH_OPEN, "A release switch is open (switches 1 and 2)."),
        (_begin_run, ErrorCode.WRONG_STATE, "present state"),
        (_begin_jog, ErrorCode.WRONG_STATE, "present state"),
        (_faulty, ErrorCode.FAULT_LATCHED, "latched: the board restarted while it was armed"),
        (_limit_angles, ErrorCode.SETTINGS_DO_NOT_FIT, "stroke 1 takes joint 1 to 59 deg"),
    ],
)
def test_host_and_board_agree(
    board: Board, do: Callable[[Board], None], code: ErrorCode | None, words: str
) -> None:
    do(board)
    refusal = predict_refusal(board)
    assert (refusal and refusal.code) == code
    if refusal is not None:
        assert isinstance(refusal, BoardRefusal)
        assert refusal.exit_code == 4
        assert words in refusal.what
        assert refusal.next_step
    assert try_to_arm(board) == code


def test_what_the_factory_gave_is_not_flown(fresh_board: Board) -> None:
    refusal = predict_refusal(fresh_board)
    assert refusal is not None
    assert (refusal.code, refusal.exit_code) == (ErrorCode.NO_MANEUVER, 4)
    assert "tfsat-host upload-sequence" in refusal.next_step
    assert try_to_arm(fresh_board) == ErrorCode.NO_MANEUVER


def test_joints_that_a_run_left_bent_are_let_go_first(board: Board) -> None:
    _done_and_bent(board)
    refusal = predict_refusal(board, AT_REST)
    assert refusal is not None and refusal.code == ErrorCode.NOT_AT_START_POSE
    assert refusal.next_step.startswith("tfsat-host disarm")
    connect(board).disarm()
    assert predict_refusal(board) is None
    assert try_to_arm(board) is None


def test_the_board_itself_names_the_open_switch(board: Board) -> None:
    _open(board)
    with pytest.raises(BoardRefusal) as caught:
        connect(board).arm()
    assert caught.value.what == "A release switch is open (switch 2)."


def test_a_latched_fault_brings_its_own_cure(board: Board) -> None:
    _faulty(board)
    refusal = predict_refusal(board)
    assert refusal is not None
    assert refusal.next_step.startswith(REMEDIES[ErrorCode.RESET_WHILE_ARMED][2])
    assert refusal.next_step.endswith("Only tfsat-host disarm clears the fault.")


def test_an_armed_board_is_in_the_wrong_state(board: Board) -> None:
    _arm_board(board)
    refusal = predict_refusal(board)
    assert refusal is not None and refusal.code == ErrorCode.WRONG_STATE


@settings(max_examples=60)
@given(st.tuples(*[st.integers(-1002, 1002) | st.sampled_from([-32_768, 0, 1000, -1000, 1001])] * 3))
def test_a_joint_off_its_start_pose(
    new_board: Callable[..., Board], joints_cdeg: tuple[int, int, int]
) -> None:
    board = new_board()
    refusal = predict_refusal(board, joints_cdeg)
    assert connect(board).report_joints(joints_cdeg) == (joints_off_start_pose(joints_cdeg) == [])
    assert (refusal and refusal.code) == try_to_arm(board)
    assert (refusal is None) == (joints_off_start_pose(joints_cdeg) == [])


def test_the_joint_is_named(board: Board) -> None:
    refusal = predict_refusal(board, (0, 3400, -1001))
    assert refusal is not None
    assert "joint 2 is at 34 deg, joint 3 is at -10.01 deg" in refusal.what
    assert "0 ± 10 deg" in refusal.what
    assert "jog" in refusal.next_step


def test_a_report_counts_while_it_is_fresh(board: Board) -> None:
    connect(board).report_joints((0, 1001, 0))
    board.run((JOINT_REPORT_AGE_MS - 1000) * 1000)
    assert try_to_arm(board) == ErrorCode.NOT_AT_START_POSE
    assert connect(board).status().last_refusal == ErrorCode.NOT_AT_START_POSE
    board.run(1_000_000)
    assert try_to_arm(board) is None
    assert connect(board).status().state == SequencerState.ARMED


@pytest.mark.parametrize(
    ("addresses", "expected_text"),
    [
        ([522], "The stored maneuver is damaged"),
        ([782, 910], "The servo settings are damaged"),
        ([522, 782], "The stored maneuver and the servo settings are damaged"),
    ],
)
def test_what_is_damaged_in_the_store_is_named(
    new_board: Callable[..., Board], addresses: list[int], expected_text: str
) -> None:
    healthy = new_board()
    connect(healthy).write_settings(FOLDED_45)
    connect(healthy).write_settings(FACTORY)
    image = bytearray(healthy.eeprom())
    for address in addresses:
        image[address] ^= 0x10
    damaged = new_board(bytes(image))
    refusal = predict_refusal(damaged, AT_REST)
    assert refusal is not None
    assert (refusal.code, refusal.exit_code) == (ErrorCode.STORE_DAMAGED, 4)
    assert refusal.what.startswith(expected_text)
    assert try_to_arm(damaged) == ErrorCode.STORE_DAMAGED


@pytest.mark.parametrize(
    ("before", "code", "expected_text"),
    [
        (b"", ErrorCode.UPLOAD_INTERRUPTED, "The stored maneuver was to be replaced by an upload"),
        (b"\xa5", ErrorCode.STORE_OLD_LAYOUT, "The servo settings were stored by an earlier firmware"),
    ],
)
def test_an_upload_cut_short_and_an_old_layout_are_named(
    new_board: Callable[..., Board], before: bytes, code: ErrorCode, expected_text: str
) -> None:
    image = bytearray(new_board().eeprom())
    if before:
        image[256:257] = before
    healthy = new_board(bytes(image))
    if not before:
        healthy.ask(Frame(ManeuverBeginRequest.TYPE, 1, ManeuverBeginRequest(4, 17_000).encode()))
        healthy.run(20_000)
    refusal = predict_refusal(healthy, AT_REST)
    assert refusal is not None
    assert (refusal.code, refusal.exit_code) == (code, 4)
    assert refusal.what.startswith(expected_text)
    assert "upload-" in refusal.next_step
    assert try_to_arm(healthy) == code
