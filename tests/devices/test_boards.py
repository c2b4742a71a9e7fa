"""What the host makes of a sequencer and a logger that misbehave; the good cases fly elsewhere."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import pytest

from tests.devices.scripted import Answer, ScriptedTransport, hello, live_sample, refusal, reply
from tfsat_host.devices.client import BoardError, NoAnswer, WrongBoard
from tfsat_host.devices.logger import POLL_S, START_TIMEOUT_S, STOP_TIMEOUT_S, LoggerClient
from tfsat_host.devices.maneuver_transfer import maneuver_crc
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.devices.stored_record import STORE_TIMEOUT_S, VerifyError
from tfsat_host.errors import TfsatError
from tfsat_host.maneuver import four_stroke, schedule_maneuver
from tfsat_host.protocol.enums import (
    Board,
    ErrorCode,
    LoggerState,
    Origin,
    SequencerState,
)
from tfsat_host.protocol.framing import Frame
from tfsat_host.protocol.messages import (
    DisarmReply,
    DisarmRequest,
    HelloReply,
    HelloRequest,
    LiveReply,
    LiveRequest,
    LoggerStatusReply,
    LoggerStatusRequest,
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
    RecordStartReply,
    RecordStartRequest,
    RecordStopReply,
    RecordStopRequest,
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


class Logger:
    """A logger's answers."""

    def __init__(self, stops_until_stopped: int = 3) -> None:
        self.stops_until_stopped = stops_until_stopped
        self.polls_until_written = 5
        self.state = LoggerState.RECORDING
        self.live: list[int] = []
        self.numbers: list[bytes] = []

    def __call__(self, frame: Frame) -> Iterator[Answer]:
        if frame.type == HelloRequest.TYPE:
            yield reply(frame, hello(Board.LOGGER))
        elif frame.type == RecordStartRequest.TYPE:
            self.numbers.append(frame.payload)
            yield reply(frame, RecordStartReply(LoggerState.RECORDING, 0xABCD))
        elif frame.type == LoggerStatusRequest.TYPE:
            self.polls_until_written -= 1
            written = int(self.polls_until_written <= 0)
            error = ErrorCode.CARD_WRITE_FAILED if self.state == LoggerState.FAILED else ErrorCode.NONE
            yield reply(
                frame,
                LoggerStatusReply(
                    self.state, error, 15, 0, 0xABCD, 0, 0, written, 0, 0, 280, bytes([0x68] * 4), 1
                ),
            )
        elif frame.type == RecordStopRequest.TYPE:
            self.stops_until_stopped -= 1
            state = LoggerState.STOPPED if self.stops_until_stopped <= 0 else LoggerState.STOPPING
            yield reply(frame, RecordStopReply(state, 0xABCD, 100, 0))
        elif frame.type == LiveRequest.TYPE:
            self.live.append(frame.payload[0])
            yield reply(frame, LiveReply(frame.payload[0], 280, 65.5, 4096.0, 4096))


def logger(board: Logger) -> tuple[LoggerClient, ScriptedTransport]:
    transport = ScriptedTransport(board)
    return LoggerClient.connect(transport), transport


def test_starting_waits_until_the_card_takes_blocks() -> None:
    client, transport = logger(Logger())
    assert client.wait_for_card().blocks_written == 1
    assert transport.now_s() - 1000 == pytest.approx(4 * POLL_S, abs=0.05)


def test_a_card_that_takes_nothing_is_given_up() -> None:
    board = Logger()
    board.polls_until_written = 10**9
    client, transport = logger(board)
    with pytest.raises(TfsatError, match="took nothing for 15 s") as caught:
        client.wait_for_card()
    assert transport.now_s() - 1000 == pytest.approx(START_TIMEOUT_S, abs=0.3)
    assert "Do not drop" in caught.value.meaning


@pytest.mark.parametrize(
    ("state", "said"),
    [
        (LoggerState.FAILED, "card refused a write"),
        (LoggerState.IDLE, "does not record any more: it is idle"),
    ],
)
def test_a_recording_that_ended_before_it_began(state: LoggerState, said: str) -> None:
    board = Logger()
    board.state = state
    with pytest.raises(TfsatError, match=said):
        logger(board)[0].wait_for_card()


def test_stopping_waits_for_the_card() -> None:
    client, transport = logger(Logger(5))
    assert client.stop_recording().state == LoggerState.STOPPED
    assert [frame.type for frame in transport.requests].count(RecordStopRequest.TYPE) == 5


def test_a_card_that_never_takes_the_rest_is_given_up() -> None:
    client, transport = logger(Logger(10**9))
    with pytest.raises(TfsatError, match="still writing") as caught:
        client.stop_recording()
    assert transport.now_s() - 1000 == pytest.approx(STOP_TIMEOUT_S, abs=0.1)
    assert "Keep the power on" in caught.value.next_step


def test_each_start_has_its_number() -> None:
    board = Logger()
    client, _ = logger(board)
    for number in (0, 7, 2**32 - 1):
        assert client.start_recording(number).session == 0xABCD
    client.start_recording()
    client.start_recording()
    assert board.numbers[:3] == [n.to_bytes(4, "little") for n in (0, 7, 2**32 - 1)]
    assert len(set(board.numbers)) == 5


def test_live_sampling_ends_with_its_block() -> None:
    board = Logger()
    client, transport = logger(board)
    with client.live() as scales:
        assert scales.rate_hz == 280
        transport.say(live_sample(1) + live_sample(2))
        assert [sample.index for sample in client.live_samples()] == [1, 2]
        with pytest.raises(TfsatError, match="No live sample within 1 s"):
            client.live_samples()
    assert board.live == [1, 0]


def test_live_sampling_ends_when_the_block_fails() -> None:
    board = Logger()
    client, _ = logger(board)
    with pytest.raises(ZeroDivisionError), client.live():
        raise ZeroDivisionError
    assert board.live == [1, 0]


def test_a_card_that_failed_is_the_boards_error() -> None:
    class Failed(Logger):
        def __call__(self, frame: Frame) -> Iterator[Answer]:
            if frame.type == RecordStopRequest.TYPE:
                yield refusal(frame, ErrorCode.CARD_WRITE_FAILED)
            else:
                yield from super().__call__(frame)

    client, _ = logger(Failed())
    with pytest.raises(BoardError) as caught:
        client.stop_recording()
    assert (caught.value.code, caught.value.exit_code) == (ErrorCode.CARD_WRITE_FAILED, 1)
    assert "Replace the card" in caught.value.next_step


@pytest.mark.parametrize("kind", [SequencerClient, LoggerClient])
def test_nobody_answers(kind: type[SequencerClient] | type[LoggerClient]) -> None:
    with pytest.raises(NoAnswer):
        kind.connect(ScriptedTransport(lambda _: []))
