"""What the host makes of sequencers that misbehave; the good cases are on the native board."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import pytest

from tests.devices.scripted import Answer, ScriptedTransport, hello, reply
from tfsat_host.devices.board_errors import NoAnswer, VerifyError, WrongBoard
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.sequencer import STORE_TIMEOUT_S, SequencerClient, maneuver_crc
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import (
    Board,
    Origin,
    SequencerState,
)
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.record import Record
from tfsat_host.servo_settings import FACTORY, ServoSettings

SCHEDULE = schedule_maneuver(four_stroke(59, 70))
CRC = maneuver_crc(SCHEDULE)


WANTED = replace(FACTORY, frame_us=10_000)


class Sequencer:
    """A sequencer's answers, each of which a test may spoil."""

    def __init__(self) -> None:
        self.repeats_until_stored = 3
        self.angle_offset_cdeg = 0
        self.crc = CRC
        self.speed_cdeg_s = SCHEDULE.speed_cdeg_s
        self.settings_in_use = FACTORY
        self.settings_stored = WANTED
        self.generation = 7

    def __call__(self, frame: Frame) -> Iterable[Answer]:
        return [reply(frame, self.answer(frame))]

    def answer(self, frame: Frame) -> Record:
        match frame.type:
            case msg.HelloRequest.TYPE:
                return hello()
            case msg.ManeuverBeginRequest.TYPE:
                return msg.ManeuverBeginReply(frame.payload[0])
            case msg.ManeuverStrokeRequest.TYPE:
                return msg.ManeuverStrokeReply(frame.payload[0])
            case msg.ManeuverCommitRequest.TYPE:
                self.repeats_until_stored -= 1
                return msg.ManeuverCommitReply(int(self.repeats_until_stored <= 0), 1)
            case msg.ManeuverInfoRequest.TYPE:
                count, end_us = len(SCHEDULE.strokes), 2_231_765
                return msg.ManeuverInfoReply(Origin.UPLOADED, count, self.speed_cdeg_s, self.crc, end_us, 1)
            case msg.ManeuverReadRequest.TYPE:
                stroke = SCHEDULE.strokes[frame.payload[0]]
                angle_cdeg = stroke.angle_cdeg + self.angle_offset_cdeg
                return msg.ManeuverReadReply(frame.payload[0], stroke.joint, angle_cdeg, stroke.t_us)
            case msg.SettingsReadRequest.TYPE:
                settings_fields = (
                    self.settings_in_use.frame_us,
                    self.settings_in_use.servos,
                    self.settings_in_use.moving_at_once,
                )
                return msg.SettingsReadReply(Origin.UPLOADED, self.generation, *settings_fields)
            case msg.SettingsWriteRequest.TYPE:
                self.repeats_until_stored -= 1
                if self.repeats_until_stored == 0 and self.settings_in_use != self.settings_stored:
                    self.settings_in_use = self.settings_stored
                    self.generation += 1
                return msg.SettingsWriteReply(int(self.repeats_until_stored <= 0), 1)
        raise AssertionError(f"{frame.type:#x} was not to be asked")


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


@pytest.mark.parametrize(
    ("upload", "expected_meaning"),
    [
        (lambda client: client.upload(SCHEDULE), "before is still stored"),
        (lambda client: client.write_settings(WANTED), "settings from before are still in force"),
    ],
)
def test_a_board_that_writes_for_ever_is_given_up(
    upload: Callable[[SequencerClient], object], expected_meaning: str
) -> None:
    board = Sequencer()
    board.repeats_until_stored = 10**9
    client, transport = sequencer(board)
    started_s = transport.now_s()
    with pytest.raises(VerifyError, match="still writing") as caught:
        upload(client)
    assert transport.now_s() - started_s == pytest.approx(STORE_TIMEOUT_S, abs=0.1)
    assert expected_meaning in caught.value.meaning


def test_the_write_is_repeated_until_it_is_stored() -> None:
    client, transport = sequencer(Sequencer())
    settings_upload = client.write_settings(WANTED)
    assert (settings_upload.written, settings_upload.stored.settings, settings_upload.stored.generation) == (
        True,
        WANTED,
        8,
    )
    assert [frame.type for frame in transport.requests] == [0x01, 0x16, *[0x15] * 3, 0x16]
    writes = {frame.payload for frame in transport.requests if frame.type == msg.SettingsWriteRequest.TYPE}
    assert writes == {
        msg.SettingsWriteRequest(WANTED.frame_us, WANTED.servos, WANTED.moving_at_once).encode()
    }


def test_whether_it_was_there_already_is_told_by_the_generation() -> None:
    """Compare generations to tell whether the settings were already stored.

    The board's `written` refers to its last request of that content, which may be of an earlier upload.
    """
    board = Sequencer()
    board.settings_in_use = WANTED
    assert sequencer(board)[0].write_settings(WANTED).written is False


OTHER_LIMIT = replace(WANTED.servos[2], max_cdeg=8999)


OTHER_LIMIT = replace(WANTED.servos[2], max_cdeg=8999)


@pytest.mark.parametrize(
    "stored_settings",
    [replace(WANTED, frame_us=10_001), replace(WANTED, servos=(*WANTED.servos[:2], OTHER_LIMIT))],
)
def test_settings_read_back_must_be_those_that_were_sent(stored_settings: ServoSettings) -> None:
    board = Sequencer()
    board.settings_stored = stored_settings
    with pytest.raises(VerifyError, match="was sent") as caught:
        sequencer(board)[0].write_settings(WANTED)
    assert "Do not arm" in caught.value.meaning


@pytest.mark.parametrize("connect", [SequencerClient.connect, SequencerClient.connect_any_protocol])
def test_the_logger_is_no_sequencer(connect: Callable[[ScriptedTransport], object]) -> None:
    transport = ScriptedTransport(lambda frame: [reply(frame, hello(Board.LOGGER, bytes(8)))])
    with pytest.raises(WrongBoard, match="is the logger; this command is for the sequencer"):
        connect(transport)
    assert [frame.type for frame in transport.requests] == [msg.HelloRequest.TYPE]


def test_a_sequencer_of_another_protocol_is_disarmed() -> None:
    """HELLO and DISARM are frozen: an armed robot can be made safe by any host."""

    def board(frame: Frame) -> Iterator[Answer]:
        if frame.type == msg.HelloRequest.TYPE:
            yield reply(frame, hello(protocol_hash=bytes(8)))
        elif frame.type == msg.DisarmRequest.TYPE:
            yield reply(frame, msg.DisarmReply(SequencerState.SAFE))

    with pytest.raises(WrongBoard):
        SequencerClient.connect(ScriptedTransport(board))
    client = SequencerClient.connect_any_protocol(ScriptedTransport(board))
    assert not client.identity.speaks_this_protocol
    assert client.disarm() == SequencerState.SAFE


def test_the_frozen_messages_are_what_they_were() -> None:
    assert (msg.HelloRequest.TYPE, msg.HelloRequest.SIZE, msg.HelloReply.TYPE, msg.HelloReply.SIZE) == (
        0x01,
        0,
        0x81,
        24,
    )
    assert (
        ("board", Board, None),
        ("firmware_version", "B", 3),
        ("board_serial", "B", 8),
        ("image_crc", "I", None),
        ("protocol_hash", "B", 8),
    ) == msg.HelloReply.LAYOUT
    assert (msg.DisarmRequest.TYPE, msg.DisarmRequest.SIZE, msg.DisarmReply.TYPE, msg.DisarmReply.SIZE) == (
        0x21,
        0,
        0xA1,
        1,
    )
    assert (Board.SEQUENCER, Board.LOGGER, SequencerState.SAFE) == (1, 2, 0)


@pytest.mark.parametrize("kind", [SequencerClient, LoggerClient])
def test_nobody_answers(kind: type[SequencerClient] | type[LoggerClient]) -> None:
    with pytest.raises(NoAnswer):
        kind.connect(ScriptedTransport(lambda _: []))
