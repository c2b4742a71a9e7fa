"""What the host makes of boards that misbehave; the good cases fly elsewhere."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import pytest

from tests.devices.scripted import Answer, ScriptedTransport, hello, reply
from tfsat_host.devices.client import NoAnswer, VerifyError, WrongBoard
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.sequencer import STORE_TIMEOUT_S, SequencerClient, maneuver_crc
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import (
    Board,
    Origin,
    SequencerState,
)
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.messages import (
    DisarmReply,
    DisarmRequest,
    HelloReply,
    HelloRequest,
    ManeuverBeginReply,
    ManeuverBeginRequest,
    ManeuverCommitReply,
    ManeuverCommitRequest,
    ManeuverInfoReply,
    ManeuverInfoRequest,
    ManeuverReadReply,
    ManeuverReadRequest,
    ManeuverStrokeReply,
    ManeuverStrokeRequest,
)
from tfsat_host.protocol.record import Record

SCHEDULE = schedule_maneuver(four_stroke(59, 70))
CRC = maneuver_crc(SCHEDULE)


class Sequencer:
    """A sequencer's answers, each of which a test may spoil."""

    def __init__(self) -> None:
        self.commits_until_stored = 3
        self.angle_offset_cdeg = 0
        self.crc = CRC
        self.speed_cdeg_s = SCHEDULE.speed_cdeg_s

    def __call__(self, frame: Frame) -> Iterable[Answer]:
        return [reply(frame, self.answer(frame))]

    def answer(self, frame: Frame) -> Record:
        match frame.type:
            case HelloRequest.TYPE:
                return hello()
            case ManeuverBeginRequest.TYPE:
                return ManeuverBeginReply(frame.payload[0])
            case ManeuverStrokeRequest.TYPE:
                return ManeuverStrokeReply(frame.payload[0])
            case ManeuverCommitRequest.TYPE:
                self.commits_until_stored -= 1
                return ManeuverCommitReply(int(self.commits_until_stored <= 0), 1)
            case ManeuverInfoRequest.TYPE:
                count = len(SCHEDULE.strokes)
                return ManeuverInfoReply(Origin.UPLOADED, count, self.speed_cdeg_s, self.crc, 2_231_765, 1)
            case ManeuverReadRequest.TYPE:
                stroke = SCHEDULE.strokes[frame.payload[0]]
                angle_cdeg = stroke.angle_cdeg + self.angle_offset_cdeg
                return ManeuverReadReply(frame.payload[0], stroke.joint, angle_cdeg, stroke.t_us)
        raise AssertionError(f"nobody asked for {frame.type:#x}")


def sequencer(board: Sequencer) -> tuple[SequencerClient, ScriptedTransport]:
    transport = ScriptedTransport(board)
    return SequencerClient.connect(transport), transport


def test_an_upload_is_staged_committed_and_read_back() -> None:
    client, transport = sequencer(Sequencer())
    result = client.upload(SCHEDULE)
    assert result.written
    assert result.stored.crc == CRC
    assert result.stored.strokes == (
        (1, 5900, 700_000),
        (2, 7000, 1_050_000),
        (1, -5900, 1_470_000),
        (2, -7000, 1_820_000),
    )
    kinds = [frame.type for frame in transport.requests]
    assert kinds == [0x01, 0x10, *[0x11] * 4, *[0x12] * 3, 0x13, *[0x14] * 4]
    assert client.port == "scripted"
    client.close()
    assert transport.closed


def test_what_is_read_back_must_be_what_was_sent() -> None:
    board = Sequencer()
    board.speed_cdeg_s += 1
    board.crc = 0x3C23
    with pytest.raises(VerifyError, match="do not fit its CRC"):
        sequencer(board)[0].upload(SCHEDULE)


def test_a_board_that_holds_another_maneuver_than_was_sent() -> None:
    client, _ = sequencer(Sequencer())
    with pytest.raises(VerifyError, match="was sent") as caught:
        client.upload(schedule_maneuver(four_stroke(59, 69)))
    assert "Do not arm" in caught.value.meaning
    assert caught.value.exit_code == 1


def test_strokes_that_do_not_fit_their_crc() -> None:
    board = Sequencer()
    board.angle_offset_cdeg = 1
    with pytest.raises(VerifyError, match="do not fit its CRC") as caught:
        sequencer(board)[0].read_back()
    assert "Do not arm" in caught.value.meaning


def test_a_board_that_writes_for_ever_is_given_up() -> None:
    board = Sequencer()
    board.commits_until_stored = 10**9
    client, transport = sequencer(board)
    started_s = transport.now_s()
    with pytest.raises(VerifyError, match="still writing") as caught:
        client.upload(SCHEDULE)
    assert transport.now_s() - started_s == pytest.approx(STORE_TIMEOUT_S, abs=0.1)
    assert "before is still stored" in caught.value.meaning


def test_the_loggers_port_given_to_the_sequencers_command() -> None:
    transport = ScriptedTransport(lambda frame: [reply(frame, hello(Board.LOGGER))])
    with pytest.raises(WrongBoard, match="is the logger; this command is for the sequencer"):
        SequencerClient.connect(transport)
    assert [frame.type for frame in transport.requests] == [HelloRequest.TYPE]


def test_a_sequencer_of_another_protocol_is_disarmed() -> None:
    """HELLO and DISARM are frozen: an armed robot can be made safe by any host."""

    def board(frame: Frame) -> Iterator[Answer]:
        if frame.type == HelloRequest.TYPE:
            yield reply(frame, hello(protocol_hash=bytes(8)))
        elif frame.type == DisarmRequest.TYPE:
            yield reply(frame, DisarmReply(SequencerState.SAFE))

    with pytest.raises(WrongBoard):
        SequencerClient.connect(ScriptedTransport(board))
    client = SequencerClient.connect_any_protocol(ScriptedTransport(board))
    assert not client.identity.speaks_this_protocol
    assert client.disarm() == SequencerState.SAFE


def test_the_frozen_messages_are_what_they_were() -> None:
    assert (HelloRequest.TYPE, HelloRequest.SIZE, HelloReply.TYPE, HelloReply.SIZE) == (0x01, 0, 0x81, 24)
    assert (
        ("board", Board, None),
        ("firmware_version", "B", 3),
        ("board_serial", "B", 8),
        ("image_crc", "I", None),
        ("protocol_hash", "B", 8),
    ) == HelloReply.LAYOUT
    assert (DisarmRequest.TYPE, DisarmRequest.SIZE, DisarmReply.TYPE, DisarmReply.SIZE) == (0x21, 0, 0xA1, 1)
    assert (Board.SEQUENCER, Board.LOGGER, SequencerState.SAFE) == (1, 2, 0)


def test_the_loggers_port_is_not_disarmed() -> None:
    transport = ScriptedTransport(lambda frame: [reply(frame, hello(Board.LOGGER, bytes(8)))])
    with pytest.raises(WrongBoard, match="is the logger"):
        SequencerClient.connect_any_protocol(transport)
    assert [frame.type for frame in transport.requests] == [HelloRequest.TYPE]


@pytest.mark.parametrize("kind", [SequencerClient, LoggerClient])
def test_nobody_answers(kind: type[SequencerClient] | type[LoggerClient]) -> None:
    with pytest.raises(NoAnswer):
        kind.connect(ScriptedTransport(lambda _: []))
