"""What the board refuses, with which number, and that a refusal changes nothing on it."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.sequencer.board import (
    ERASED,
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
from tests.sequencer.maneuvers import RawManeuver, defect, flyable, raw_maneuvers
from tests.sequencer.store_model import without_markers
from tfsat_host.devices.client import BoardError, BoardRefusal
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
    """All of an upload, whatever the host's own checks would say."""
    return send(board, raw.requests())


FLOWN = RawManeuver.of(NEW)


def with_stroke(index: int, **fields: int) -> RawManeuver:
    strokes = [dict(zip(("joint", "angle", "start"), stroke, strict=True)) for stroke in FLOWN.strokes]
    strokes[index].update(fields)
    return RawManeuver(FLOWN.speed_cdeg_s, tuple((s["joint"], s["angle"], s["start"]) for s in strokes))


def wire(*requests: Payload) -> list[Payload]:
    return list(requests)


STROKE = ManeuverStrokeRequest(0, 1, 1000, 700_000)
REFUSED: dict[str, tuple[list[Payload], ErrorCode, int]] = {
    "no stroke": (wire(ManeuverBeginRequest(0, 17000)), ErrorCode.TOO_MANY_STROKES, 0),
    "17 strokes": (wire(ManeuverBeginRequest(17, 17000)), ErrorCode.TOO_MANY_STROKES, 17),
    "255 strokes": (wire(ManeuverBeginRequest(255, 17000)), ErrorCode.TOO_MANY_STROKES, 255),
    "stroke without begin": (wire(STROKE), ErrorCode.NO_STAGED_MANEUVER, -1),
    "commit without begin": (wire(ManeuverCommitRequest(0)), ErrorCode.NO_STAGED_MANEUVER, -1),
    "stroke beyond the end": (
        wire(ManeuverBeginRequest(1, 17000), ManeuverStrokeRequest(1, 1, 1000, 700_000)),
        ErrorCode.INDEX_OUT_OF_RANGE,
        1,
    ),
    "read beyond the end": (wire(ManeuverReadRequest(4)), ErrorCode.INDEX_OUT_OF_RANGE, 4),
    "commit with strokes missing": (
        [request for number, request in enumerate(FLOWN.requests()) if number != 3],
        ErrorCode.STEP_MISSING,
        2,
    ),
    "commit with another crc": (
        [*FLOWN.requests()[:-1], ManeuverCommitRequest(0x1234)],
        ErrorCode.CRC_MISMATCH,
        -1,
    ),
    "joint 0": (with_stroke(1, joint=0).requests(), ErrorCode.JOINT_UNKNOWN, 1),
    "joint 4": (with_stroke(2, joint=4).requests(), ErrorCode.JOINT_UNKNOWN, 2),
    "beyond 90 deg": (with_stroke(0, angle=9001).requests(), ErrorCode.ANGLE_OUT_OF_RANGE, 0),
    "below 0 deg": (with_stroke(2, angle=-4151).requests(), ErrorCode.ANGLE_OUT_OF_RANGE, 2),
    "no movement": (with_stroke(3, angle=0).requests(), ErrorCode.ANGLE_OUT_OF_RANGE, 3),
    "least angle of the wire": (with_stroke(0, angle=-32768).requests(), ErrorCode.ANGLE_OUT_OF_RANGE, 0),
    "before the pause": (with_stroke(0, start=699_999).requests(), ErrorCode.TOO_EARLY, 0),
    "at release": (with_stroke(0, start=0).requests(), ErrorCode.TOO_EARLY, 0),
    "overlap": (with_stroke(1, start=FLOWN.strokes[0][2] + 244_117).requests(), ErrorCode.STROKES_OVERLAP, 1),
    "closer than the grid": (
        RawManeuver(40_000, ((1, 1, 700_000), (1, -1, 709_999))).requests(),
        ErrorCode.STROKES_OVERLAP,
        1,
    ),
    "out of order": (with_stroke(2, start=700_000).requests(), ErrorCode.STROKES_OVERLAP, 2),
    "outlasts the fall": (with_stroke(3, start=2_400_000).requests(), ErrorCode.TOO_LONG, 3),
    "starts after the fall": (with_stroke(3, start=2**32 - 1).requests(), ErrorCode.TOO_LONG, 3),
    "too slow": (RawManeuver(999, FLOWN.strokes).requests(), ErrorCode.SPEED_OUT_OF_RANGE, -1),
    "no speed": (RawManeuver(0, FLOWN.strokes).requests(), ErrorCode.SPEED_OUT_OF_RANGE, -1),
    "too fast": (RawManeuver(40_001, FLOWN.strokes).requests(), ErrorCode.SPEED_OUT_OF_RANGE, -1),
}


@pytest.mark.parametrize("stored", ["factory", "uploaded"])
@pytest.mark.parametrize("what", REFUSED)
def test_refused_with_its_number_and_nothing_changed(
    new_board: Callable[..., Board], what: str, stored: str
) -> None:
    requests, code, detail = REFUSED[what]
    board = new_board(ERASED if stored == "factory" else None)
    image = board.eeprom()
    assert send(board, requests) == (code, detail)
    board.advance(1_000_000)
    assert without_markers(board.eeprom()) == without_markers(image)
    held = connect(board).read_back()
    assert held.strokes == rows(OLD)
    assert held.origin == (Origin.UPLOADED if stored == "uploaded" else Origin.FACTORY)
    assert board.edges() == []


@pytest.mark.parametrize("reply_type", [0x80, 0x81, 0x90, 0xFF])
def test_an_echo_of_a_reply_is_not_answered(board: Board, reply_type: int) -> None:
    """Two ends that answered each other's errors would never stop."""
    assert board.ask(Frame(reply_type, 77, b"\x01\x02")) == []


@pytest.mark.parametrize("request_type", [0x00, 0x03, 0x05, 0x17, 0x24, 0x40, 0x42, 0x60, 0x7F])
def test_an_unknown_request_is_named(board: Board, request_type: int) -> None:
    (answer,) = board.ask(Frame(request_type, 77, b"\x01\x02"))
    assert (answer.type, answer.sequence) == (ErrorReply.TYPE, 77)
    assert ErrorReply.decode(answer.payload) == ErrorReply(request_type, ErrorCode.UNKNOWN_MESSAGE, -1)


@pytest.mark.parametrize("request_type", [0x01, 0x02, 0x04, *range(0x10, 0x17), *range(0x20, 0x24)])
def test_a_request_of_another_length_is_refused(board: Board, request_type: int) -> None:
    lengths = {0x10: 3, 0x11: 8, 0x12: 2, 0x14: 1, 0x15: 29, 0x20: 2, 0x22: 6, 0x23: 9}
    right = lengths.get(request_type, 0)
    for length in {right + 1, max(0, right - 1), 96} - {right}:
        (answer,) = board.ask(Frame(request_type, 5, bytes(length)))
        assert ErrorReply.decode(answer.payload) == ErrorReply(request_type, ErrorCode.BAD_LENGTH, -1)
    assert board.edges() == []


@settings(max_examples=150)
@given(maneuver=flyable())
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


@settings(max_examples=400)
@given(raw=raw_maneuvers())
def test_the_board_believes_no_host(new_board: Callable[..., Board], raw: RawManeuver) -> None:
    board = new_board()
    image = board.eeprom()
    expected = defect(raw)
    assert upload_raw(board, raw) == expected
    board.advance(700_000)
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


@settings(max_examples=120)
@given(maneuver=flyable(), seed=st.integers(0, 2**16))
def test_every_pulse_of_a_random_maneuver(
    new_board: Callable[..., Board], maneuver: Maneuver, seed: int
) -> None:
    """Each stroke's first pulse rises on its tick; no pulse anywhere is cut short or out of range."""
    schedule = schedule_maneuver(maneuver)
    board = new_board()
    sequencer = connect(board)
    sequencer.upload(schedule)
    sequencer.arm()
    board.advance(seed)
    released_us = release(board)
    board.advance(2_600_000)
    assert sequencer.status().strokes_started == len(schedule.strokes)
    sequencer.disarm()
    board.advance(10_000)
    edges = board.edges()
    rises = [pulse.rise_ns for pulse in pulses(edges, STROKE_LINE)]
    assert rises == [1000 * (released_us + stroke.t_us) for stroke in schedule.strokes]
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


def test_an_identical_maneuver_is_not_written_again(fresh_board: Board) -> None:
    board = fresh_board
    sequencer = connect(board)
    assert sequencer.upload(NEW).written
    image = board.eeprom()
    again = sequencer.upload(NEW)
    assert (again.written, again.stored.generation) == (False, 1)
    board.power_cycle()
    assert connect(board).upload(NEW).written is False
    assert board.eeprom() == image
    assert connect(board).upload(OLD).stored.generation == 2


def test_a_factory_maneuver_that_is_uploaded_counts_as_uploaded(fresh_board: Board) -> None:
    board = fresh_board
    assert connect(board).read_back().origin == Origin.FACTORY
    assert connect(board).upload(OLD).written
    board.power_cycle()
    held = connect(board).read_back()
    assert (held.origin, held.strokes) == (Origin.UPLOADED, rows(OLD))
