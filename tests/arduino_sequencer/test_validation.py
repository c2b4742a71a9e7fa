"""What the board refuses, with which number, and that a refusal changes nothing on it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.arduino_sequencer.maneuvers import RawManeuver, defect, flyable, overlapping, raw_maneuvers
from tests.arduino_sequencer.store_model import without_markers
from tests.fixtures.sequencer.board import ERASED, JOINTS, STROKE_LINE, Board
from tests.fixtures.sequencer.cable import OLD, client, connect, rows
from tests.fixtures.sequencer.pulses import assert_servo_signal, pulses, release, width_ns
from tfsat_host.devices.board_errors import BoardError, BoardRefusal
from tfsat_host.maneuver import Maneuver, schedule_maneuver
from tfsat_host.protocol.enums import ErrorCode, Origin
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.messages import (
    ErrorReply,
    ManeuverBeginReply,
    ManeuverBeginRequest,
    ManeuverCommitReply,
    ManeuverCommitRequest,
    ManeuverReadReply,
    ManeuverReadRequest,
    ManeuverStrokeReply,
    ManeuverStrokeRequest,
)
from tfsat_host.protocol.record import Payload
from tfsat_host.servo_settings import FACTORY

REPLIES: dict[type[Payload], type[Payload]] = {
    ManeuverBeginRequest: ManeuverBeginReply,
    ManeuverStrokeRequest: ManeuverStrokeReply,
    ManeuverCommitRequest: ManeuverCommitReply,
    ManeuverReadRequest: ManeuverReadReply,
}


def send(board: Board, requests: list[Payload]) -> tuple[ErrorCode, int]:
    """Sends raw requests up to the first refusal; its code and detail."""
    link = client(board)
    for request in requests:
        try:
            link.request(request, REPLIES[type(request)])
        except BoardError as error:
            return error.code, error.detail
    return ErrorCode.NONE, -1


def upload_raw(board: Board, raw: RawManeuver) -> tuple[ErrorCode, int]:
    """Upload the whole maneuver, bypassing the host's own checks."""
    return send(board, raw.requests())


@pytest.mark.parametrize("reply_type", [0x80, 0x81, 0x90, 0xFF])
def test_an_echo_of_a_reply_is_not_answered(board: Board, reply_type: int) -> None:
    """Echoed replies get no answer: two ends answering each other's errors would never stop."""
    assert board.ask(Frame(reply_type, 77, b"\x01\x02")) == []


@pytest.mark.parametrize("request_type", [0x00, 0x03, 0x05, 0x17, 0x24, 0x40, 0x42, 0x60, 0x7F])
def test_an_unknown_request_is_named(board: Board, request_type: int) -> None:
    (answer,) = board.ask(Frame(request_type, 77, b"\x01\x02"))
    assert (answer.type, answer.sequence) == (ErrorReply.TYPE, 77)
    assert ErrorReply.decode(answer.payload) == ErrorReply(request_type, ErrorCode.UNKNOWN_MESSAGE, -1)


@pytest.mark.parametrize("request_type", [0x01, 0x02, 0x04, *range(0x10, 0x17), *range(0x20, 0x24)])
def test_a_request_of_another_length_is_refused(board: Board, request_type: int) -> None:
    lengths = {0x10: 3, 0x11: 8, 0x12: 2, 0x14: 1, 0x15: 30, 0x20: 2, 0x22: 6, 0x23: 9}
    right = lengths.get(request_type, 0)
    for length in {right + 1, max(0, right - 1), 96} - {right}:
        (answer,) = board.ask(Frame(request_type, 5, bytes(length)))
        assert ErrorReply.decode(answer.payload) == ErrorReply(request_type, ErrorCode.BAD_LENGTH, -1)
    assert board.edges() == []


@settings(max_examples=60)
@given(maneuver=flyable() | overlapping())
def test_what_the_host_schedules_the_board_accepts(
    new_board: Callable[..., Board], maneuver: Maneuver
) -> None:
    schedule = schedule_maneuver(maneuver)
    board = new_board(ERASED)
    result = connect(board).upload(schedule)
    assert result.stored.strokes == rows(schedule)
    assert result.stored.end_us == schedule.end_us
    assert (result.written, result.stored.origin, result.stored.generation) == (
        True,
        Origin.UPLOADED,
        1,
    )


@settings(max_examples=120)
@given(raw=raw_maneuvers())
def test_the_board_believes_no_host(new_board: Callable[..., Board], raw: RawManeuver) -> None:
    board = new_board()
    image = board.eeprom()
    expected = defect(raw)
    assert upload_raw(board, raw) == expected
    board.run(700_000)
    if expected[0] == ErrorCode.NONE:
        assert connect(board).read_back().strokes == raw.strokes
    else:
        assert without_markers(board.eeprom()) == without_markers(image)
        sequencer = connect(board)
        assert sequencer.read_back().strokes == rows(OLD)
        with pytest.raises(BoardRefusal) as caught:
            sequencer.arm()
        assert caught.value.code == ErrorCode.UPLOAD_INTERRUPTED


@pytest.mark.parametrize("speed_cdeg_s", [1000, 16_999, 17_000, 33_333, 40_000])
@pytest.mark.parametrize("angle_cdeg", [1, 3333, 5900, 9000])
def test_the_last_microsecond_of_the_fall(board: Board, speed_cdeg_s: int, angle_cdeg: int) -> None:
    duration_us = -(-angle_cdeg * 1_000_000 // speed_cdeg_s)
    latest_us = 2_500_000 - duration_us
    if latest_us < 700_000:
        raw = RawManeuver(speed_cdeg_s, ((1, angle_cdeg, 700_000),))
        assert upload_raw(board, raw) == (ErrorCode.TOO_LONG, 0)
        return
    assert (
        upload_raw(board, RawManeuver(speed_cdeg_s, ((1, angle_cdeg, latest_us + 1),)))[0]
        == ErrorCode.TOO_LONG
    )
    assert upload_raw(board, RawManeuver(speed_cdeg_s, ((1, angle_cdeg, latest_us),)))[0] == ErrorCode.NONE


@settings(max_examples=40)
@given(maneuver=flyable() | overlapping(), seed=st.integers(0, 2**16))
def test_every_pulse_of_a_random_maneuver(
    new_board: Callable[..., Board], maneuver: Maneuver, seed: int
) -> None:
    """First pulses of strokes rise on their tick, and no pulse is cut short or out of range."""
    schedule = schedule_maneuver(maneuver)
    board = new_board()
    sequencer = connect(board)
    sequencer.write_settings(replace(FACTORY, moving_at_once=JOINTS))
    sequencer.upload(schedule)
    sequencer.arm()
    board.run(seed)
    released_us = release(board)
    board.run(2_600_000)
    assert sequencer.status().strokes_started == len(schedule.strokes)
    sequencer.disarm()
    board.run(10_000)
    edges = board.edges()
    rises = [pulse.rise_ns for pulse in pulses(edges, STROKE_LINE)]
    # Strokes that begin together share one mark.
    assert rises == [1000 * (released_us + t_us) for t_us in sorted({s.t_us for s in schedule.strokes})]
    for joint in range(1, JOINTS + 1):
        train = pulses(edges, joint - 1)
        assert_servo_signal(train)
        changes = [(0, 0)]
        for stroke in schedule.strokes:
            if stroke.joint == joint:
                changes.append((1000 * (released_us + stroke.t_us), changes[-1][1] + stroke.angle_cdeg))
        for pulse in train:
            angle_cdeg = next(angle for onset_ns, angle in reversed(changes) if onset_ns <= pulse.rise_ns)
            assert pulse.width_ns == pytest.approx(width_ns(angle_cdeg), abs=500)
        onsets = {pulse.rise_ns for pulse in train}
        assert all(onset_ns in onsets for onset_ns, _ in changes[1:])
