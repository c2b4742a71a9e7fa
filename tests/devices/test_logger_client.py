"""The host's end of the logger: starting, stopping, live samples, what failed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest

from tests.devices.scripted import Answer, ScriptedTransport, hello, live_sample, refusal, reply
from tests.devices.scripted import client as scripted_client
from tfsat_host.devices.board_errors import BoardError
from tfsat_host.devices.logger import POLL_S, START_TIMEOUT_S, STOP_TIMEOUT_S, CardError, LoggerClient
from tfsat_host.errors import TfsatError
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import (
    Board,
    ErrorCode,
    LoggerState,
)
from tfsat_host.protocol.framing import Frame, encode_frame


class Logger:
    """A logger's answers."""

    def __init__(self, stops_until_stopped: int = 3) -> None:
        self.stops_until_stopped = stops_until_stopped
        self.polls_until_written = 5
        self.state = LoggerState.RECORDING
        self.ram_holds_drop = 0
        self.live: list[int] = []
        self.numbers: list[bytes] = []
        self.stop: Callable[[Frame], bytes] | None = None

    def __call__(self, frame: Frame) -> Iterator[Answer]:
        if frame.type == msg.HelloRequest.TYPE:
            yield reply(frame, hello(Board.LOGGER))
        elif frame.type == msg.RecordStartRequest.TYPE:
            self.numbers.append(frame.payload)
            yield reply(frame, msg.RecordStartReply(LoggerState.RECORDING, 0xABCD))
        elif frame.type == msg.LoggerStatusRequest.TYPE:
            self.polls_until_written -= 1
            written = int(self.polls_until_written <= 0)
            error = ErrorCode.CARD_WRITE_FAILED if self.state == LoggerState.FAILED else ErrorCode.NONE
            yield reply(
                frame,
                replace(
                    msg.LoggerStatusReply.decode(bytes(msg.LoggerStatusReply.SIZE)),
                    state=self.state,
                    error=error,
                    blocks_written=written,
                    rate_hz=280,
                    ram_holds_drop=self.ram_holds_drop,
                ),
            )
        elif frame.type == msg.RecordStopRequest.TYPE and self.stop:
            yield self.stop(frame)
        elif frame.type == msg.RecordStopRequest.TYPE:
            self.stops_until_stopped -= 1
            state = LoggerState.STOPPED if self.stops_until_stopped <= 0 else LoggerState.STOPPING
            yield reply(frame, msg.RecordStopReply(state, 0xABCD, 100, 0))
        elif frame.type == msg.LiveRequest.TYPE:
            self.live.append(frame.payload[0])
            yield reply(
                frame,
                msg.LiveReply(
                    frame.payload[0], 280, 65.5, 4096.0, 4096, 3, bytes([0x68] * 4), (0,) * 4, (0,) * 6
                ),
            )


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
    with pytest.raises(TfsatError, match="took nothing for 25 s") as caught:
        client.wait_for_card()
    assert transport.now_s() - 1000 == pytest.approx(START_TIMEOUT_S, abs=0.3)
    assert "Do not drop" in caught.value.meaning


@pytest.mark.parametrize(
    ("state", "expected_message"),
    [
        (LoggerState.FAILED, "card refused a write"),
        (LoggerState.IDLE, "does not record any more: it is idle"),
    ],
)
def test_a_recording_that_ended_before_it_began(state: LoggerState, expected_message: str) -> None:
    board = Logger()
    board.state = state
    with pytest.raises(TfsatError, match=expected_message):
        logger(board)[0].wait_for_card()


def test_stopping_waits_for_the_card() -> None:
    client, transport = logger(Logger(5))
    assert client.stop_recording().state == LoggerState.STOPPED
    assert [frame.type for frame in transport.requests].count(msg.RecordStopRequest.TYPE) == 5


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
    client.start_recording(unix_us=1_790_000_000_000_000)
    client.start_recording()
    requests = [msg.RecordStartRequest.decode(payload) for payload in board.numbers]
    assert [request.number for request in requests[:3]] == [0, 7, 2**32 - 1]
    assert len({request.number for request in requests}) == 5
    assert [request.unix_us for request in requests] == [0, 0, 0, 1_790_000_000_000_000, 0]


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
    board = Logger()
    board.stop = lambda frame: refusal(frame, ErrorCode.CARD_WRITE_FAILED)
    client, _ = logger(board)
    with pytest.raises(BoardError) as caught:
        client.stop_recording()
    assert (caught.value.code, caught.value.exit_code) == (ErrorCode.CARD_WRITE_FAILED, 1)
    assert "Replace the card" in caught.value.next_step


@pytest.mark.parametrize(
    ("ram_holds_drop", "meaning"),
    [
        (1, "The drop is in the logger's RAM only"),
        (0, "The card has no end of it. RAM keeps the newest 19 s"),
    ],
)
def test_a_recording_that_has_failed_before_it_was_stopped_is_in_ram(
    ram_holds_drop: int, meaning: str
) -> None:
    board = Logger()
    board.stop = lambda frame: reply(frame, msg.RecordStopReply(LoggerState.FAILED, 0xABCD, 100, 0))
    board.state, board.ram_holds_drop = LoggerState.FAILED, ram_holds_drop
    with pytest.raises(CardError) as caught:
        logger(board)[0].stop_recording()
    assert (caught.value.code, caught.value.exit_code) == (ErrorCode.CARD_WRITE_FAILED, 1)
    assert caught.value.meaning.startswith(meaning)
    assert caught.value.next_step == "Keep the power on. tfsat-host log fetch ram"


def test_pieces_from_before_the_answer_belong_to_an_earlier_request() -> None:
    def script(frame: Frame) -> Iterator[Answer]:
        late, asked_for = (
            encode_frame(Frame(msg.LogZerosStream.TYPE, 0, z.encode())) for z in (LATE, ASKED_FOR)
        )
        yield late + reply(frame, msg.LogReadReply(2)) + asked_for

    link, _ = scripted_client(script)
    link.request(msg.LogReadRequest(1, 0xABCD, 10, 2), msg.LogReadReply)
    assert link.log_pieces(0.1) == [ASKED_FOR]
    assert link.log_pieces(0.1) == []


LATE = msg.LogZerosStream(first_block=0, count=10)
ASKED_FOR = msg.LogZerosStream(first_block=10, count=2)
