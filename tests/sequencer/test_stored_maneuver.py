"""What the board stores decides whether it arms: nothing, half an upload, an old layout, damage."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.sequencer.board import (
    ERASED,
    NEW,
    OLD,
    Board,
    Cable,
    connect,
    rows,
)
from tests.sequencer.store_model import BEGUN, MANEUVER_AT, MARKER_BYTES, SLOT_BYTES
from tfsat_host.devices.client import BoardRefusal
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.protocol.enums import ErrorCode, SequencerState
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.messages import (
    ManeuverBeginRequest,
    ManeuverStrokeRequest,
)
from tfsat_host.servo_settings import FACTORY


class Interrupted(Exception):
    """The host was stopped here."""


class StopsAtFirstByteOfTheRecord(Cable):
    """The host dies as soon as the board has begun to store more than the marker of an upload begun."""

    def read(self, timeout_s: float) -> bytes:
        slots = (MANEUVER_AT + slot * SLOT_BYTES for slot in (0, 1))
        if any(self.board.eeprom()[at : at + MARKER_BYTES + 1] == BEGUN + b"\x02" for at in slots):
            raise Interrupted
        return super().read(timeout_s)


def test_arming_while_the_eeprom_is_written_is_refused(board: Board) -> None:
    with pytest.raises(Interrupted):
        SequencerClient.connect(StopsAtFirstByteOfTheRecord(board)).upload(NEW)
    sequencer = connect(board)
    with pytest.raises(BoardRefusal) as caught:
        sequencer.arm()
    assert caught.value.code == ErrorCode.WRONG_STATE
    board.advance(600_000)
    assert sequencer.read_back().strokes == rows(NEW)
    assert sequencer.arm() == SequencerState.ARMED


def assert_refused(board: Board, code: ErrorCode) -> None:
    with pytest.raises(BoardRefusal) as caught:
        connect(board).arm()
    assert (caught.value.code, caught.value.exit_code) == (code, 4)


def test_a_board_to_which_nothing_was_uploaded_does_not_arm(fresh_board: Board) -> None:
    assert_refused(fresh_board, ErrorCode.NO_MANEUVER)
    fresh_board.advance(100_000)
    assert fresh_board.edges() == []
    connect(fresh_board).upload(OLD)
    assert connect(fresh_board).arm() == SequencerState.ARMED


def test_an_upload_that_died_half_way_is_named_until_one_is_complete(board: Board) -> None:
    """The maneuver before is still there to be read, and is not flown."""
    for request in (ManeuverBeginRequest(4, 17_000), ManeuverStrokeRequest(0, *rows(OLD)[0])):
        board.ask(Frame(request.TYPE, 1, request.encode()))
    board.advance(20_000)  # to write the marker takes 14 ms
    for _ in range(3):
        board.power_cycle()
        sequencer = connect(board)
        assert sequencer.read_back().strokes == rows(OLD)
        assert_refused(board, ErrorCode.UPLOAD_INTERRUPTED)
        assert sequencer.status().stores_damaged == 1 << 2
    connect(board).upload(OLD)
    assert connect(board).arm() == SequencerState.ARMED


def test_a_store_of_the_old_layout_is_named_until_both_are_uploaded(new_board: Callable[..., Board]) -> None:
    """Layout 1: from address 0 and 256 on, the marker 0xA5 first."""
    image = bytearray(ERASED)
    image[0], image[256] = 0xA5, 0xA5
    board = new_board(bytes(image))
    sequencer = connect(board)
    assert sequencer.status().stores_damaged == 0b11_0000
    assert_refused(board, ErrorCode.STORE_OLD_LAYOUT)
    sequencer.upload(NEW)
    assert sequencer.status().stores_damaged == 0b10_0000
    assert_refused(board, ErrorCode.STORE_OLD_LAYOUT)
    assert sequencer.write_settings(FACTORY).written
    board.power_cycle()
    assert connect(board).arm() == SequencerState.ARMED


@pytest.mark.parametrize("slot_marker", range(MARKER_BYTES))
def test_one_bit_in_the_newest_marker_does_not_bring_the_older_maneuver_back(
    board: Board, slot_marker: int
) -> None:
    connect(board).upload(NEW)
    image = bytearray(board.eeprom())
    image[MANEUVER_AT + SLOT_BYTES + slot_marker] ^= 1
    board.power_cycle(bytes(image))
    assert_refused(board, ErrorCode.STORE_DAMAGED)


@pytest.mark.parametrize("hit", [(0,), (1,), (0, 1)])
def test_a_maneuver_damaged_in_the_dark_is_told_and_healed_by_one_upload(
    board: Board, hit: tuple[int, ...]
) -> None:
    """Both slots hold a maneuver."""
    connect(board).upload(NEW)
    image = bytearray(board.eeprom())
    for slot in hit:
        image[MANEUVER_AT + SLOT_BYTES * slot + 30] ^= 1
    board.power_cycle(bytes(image))
    assert_refused(board, ErrorCode.STORE_DAMAGED)
    assert connect(board).upload(NEW).stored.strokes == rows(NEW)
    for _ in range(2):
        assert connect(board).arm() == SequencerState.ARMED
        board.power_cycle()
