"""Requests and replies against a board that repeats, delays, damages, refuses or is silent."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.devices.scripted import Answer, ScriptedTransport, client, hello, live_sample, refusal, reply
from tests.paths import REPOSITORY
from tfsat_host.devices.board_errors import BoardError, BoardRefusal, NoAnswer, WrongBoard, board_error
from tfsat_host.devices.board_identity import IDENTITY
from tfsat_host.devices.client import ATTEMPT_TIMEOUT_S, ATTEMPTS, BUSY_TIMEOUT_S, MAX_BACKLOG, Client
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import Board, ErrorCode, SequencerState
from tfsat_host.protocol.framing import Frame, FrameReceiver, encode_frame
from tfsat_host.protocol.limits import FIRMWARE_VERSION
from tfsat_host.protocol.record import Payload, ProtocolError
from tfsat_host.protocol.remedies import REMEDIES
from tfsat_host.quantity import record

SAFE = msg.DisarmReply(SequencerState.SAFE)
DONE = msg.DisarmReply(SequencerState.DONE)
INTERLOCKS = {
    ErrorCode.WRONG_STATE,
    ErrorCode.SWITCH_OPEN,
    ErrorCode.NO_MANEUVER,
    ErrorCode.STALE_TOKEN,
    ErrorCode.FAULT_LATCHED,
    ErrorCode.NOT_AT_START_POSE,
    ErrorCode.JOG_NOT_CONFIRMED,
    ErrorCode.SETTINGS_DO_NOT_FIT,
    ErrorCode.TOO_MANY_MOVING,
    ErrorCode.STORE_DAMAGED,
    ErrorCode.UPLOAD_INTERRUPTED,
    ErrorCode.STORE_OLD_LAYOUT,
    ErrorCode.RAM_HOLDS_DROP,
}


def test_a_request_is_answered() -> None:
    link, transport = client(lambda frame: [reply(frame, SAFE)])
    assert link.request(msg.DisarmRequest(), msg.DisarmReply) == SAFE
    assert [frame.type for frame in transport.requests] == [msg.DisarmRequest.TYPE]
    assert transport.written.startswith(b"\0")  # ends what a broken cable left half-sent


@pytest.mark.parametrize("silent", range(ATTEMPTS))
def test_a_request_is_repeated_unchanged_until_it_is_answered(silent: int) -> None:
    copies = 0

    def script(frame: Frame) -> Iterator[Answer]:
        nonlocal copies
        copies += 1
        yield reply(frame, SAFE) if copies > silent else None

    link, transport = client(script)
    started_s = transport.now_s()
    assert link.request(msg.DisarmRequest(), msg.DisarmReply) == SAFE
    assert len(transport.requests) == silent + 1
    assert len(set(transport.requests)) == 1
    assert transport.now_s() - started_s == pytest.approx(silent * ATTEMPT_TIMEOUT_S, abs=0.01)


def test_silence_ends_after_all_attempts() -> None:
    link, transport = client(lambda _: [])
    started_s = transport.now_s()
    with pytest.raises(NoAnswer, match="scripted") as caught:
        link.request(msg.DisarmRequest(), msg.DisarmReply)
    assert len(transport.requests) == ATTEMPTS
    assert transport.now_s() - started_s == pytest.approx(ATTEMPTS * ATTEMPT_TIMEOUT_S)
    assert caught.value.exit_code == 1
    assert "tfsat-host ports" in caught.value.next_step


def test_a_board_that_never_stops_talking_does_not_hold_the_host() -> None:
    def script(_: Frame) -> Iterator[Answer]:
        yield from (live_sample(index) for index in range(300))

    link, transport = client(script)
    with pytest.raises(NoAnswer):
        link.request(msg.DisarmRequest(), msg.DisarmReply)
    assert transport.now_s() - 1000 < ATTEMPTS * ATTEMPT_TIMEOUT_S + 0.1


def test_answers_to_older_requests_are_dropped() -> None:
    """Drop late replies: those with an older sequence number or another type are not the answer."""

    def script(frame: Frame) -> Iterator[Answer]:
        yield reply(frame, DONE, sequence=frame.sequence - 1)
        yield reply(frame, DONE, sequence=frame.sequence + 1)
        yield reply(Frame(msg.HelloRequest.TYPE, frame.sequence, b""), hello())
        yield encode_frame(Frame(frame.type, frame.sequence, DONE.encode()))  # an echo is no reply
        yield reply(frame, SAFE)

    link, transport = client(script)
    assert link.request(msg.DisarmRequest(), msg.DisarmReply) == SAFE
    assert len(transport.requests) == 1


def test_a_late_second_answer_does_not_answer_the_next_request() -> None:
    """Late second answers, which arrive with the next request, are not taken for its answer.

    Both copies of a repeated request are answered.
    """
    late: list[bytes] = []

    def script(frame: Frame) -> Iterator[Answer]:
        yield from late
        late.clear()
        number = frame.payload[0]
        answer = reply(frame, msg.ManeuverReadReply(number, 1, 100 * number, 700_000))
        late.append(answer)
        yield answer

    link, _ = client(script)
    for number in range(300):  # past the turn of the sequence number
        index = number % 16
        assert link.request(msg.ManeuverReadRequest(index), msg.ManeuverReadReply).angle_cdeg == 100 * index


def test_sequence_numbers_turn_round() -> None:
    link, transport = client(lambda frame: [reply(frame, SAFE)])
    for _ in range(600):
        link.request(msg.DisarmRequest(), msg.DisarmReply)
    numbers = [frame.sequence for frame in transport.requests]
    assert all((after - before) % 256 == 1 for before, after in pairwise(numbers))


def test_an_answer_in_pieces_among_garbage() -> None:
    def script(frame: Frame) -> Iterator[Answer]:
        yield b"\x17garbage from before\0\0\0"
        for byte in reply(frame, SAFE):
            yield bytes([byte])

    link, transport = client(script)
    assert link.request(msg.DisarmRequest(), msg.DisarmReply) == SAFE
    assert len(transport.requests) == 1


def test_a_damaged_answer_is_asked_for_again() -> None:
    copies = 0

    def script(frame: Frame) -> Iterator[Answer]:
        nonlocal copies
        copies += 1
        answer = reply(frame, SAFE)
        yield bytes([answer[0], answer[1] ^ 4, *answer[2:]]) if copies < 3 else answer

    link, transport = client(script)
    assert link.request(msg.DisarmRequest(), msg.DisarmReply) == SAFE
    assert len(transport.requests) == 3


@given(st.integers(0, 2**32 - 1))
def test_any_losses_end_in_the_right_answer_or_none(seed: int) -> None:
    rng = random.Random(seed)

    def script(frame: Frame) -> Iterator[Answer]:
        number = frame.payload[0]
        answer = reply(frame, msg.ManeuverReadReply(number, 1, 100 * number, 700_000))
        kind = rng.randrange(4)
        if kind == 0:
            yield None
        elif kind == 1:
            at = rng.randrange(len(answer))
            yield answer[:at] + rng.randbytes(rng.randrange(4)) + answer[at + 1 :]
        else:
            yield answer * kind

    link, _ = client(script)
    for _ in range(20):
        index = rng.randrange(16)
        with suppress(NoAnswer):
            assert link.request(msg.ManeuverReadRequest(index), msg.ManeuverReadReply).index == index


@pytest.mark.parametrize("code", [code for code in ErrorCode if code not in (ErrorCode.NONE, ErrorCode.BUSY)])
def test_a_refusal_is_an_error_with_its_remedy(code: ErrorCode) -> None:
    link, transport = client(lambda frame: [refusal(frame, code, 3)])
    with pytest.raises(BoardError) as caught:
        link.request(msg.ArmRequest(1), msg.DisarmReply)
    error = caught.value
    assert (error.code, error.detail) == (code, 3)
    assert isinstance(error, BoardRefusal) == (code in INTERLOCKS)
    assert error.exit_code == (4 if code in INTERLOCKS else 1)
    what, meaning, remedy = REMEDIES[code]
    assert (error.meaning, error.next_step) == (meaning, remedy)
    assert error.what.startswith(what[:-1])
    assert error.what.endswith(".")
    assert meaning
    assert remedy
    assert len(transport.requests) == 1  # a refusal is an answer: it is not asked again


@pytest.mark.parametrize(
    ("about", "code", "detail", "named"),
    [
        (msg.ArmRequest, ErrorCode.SWITCH_OPEN, -1, "A release switch is open."),
        (msg.ArmRequest, ErrorCode.SWITCH_OPEN, 0, "A release switch is open."),
        (msg.ArmRequest, ErrorCode.SWITCH_OPEN, 1, "open (switch 1)."),
        (msg.ArmRequest, ErrorCode.SWITCH_OPEN, 2, "open (switch 2)."),
        (msg.ArmRequest, ErrorCode.SWITCH_OPEN, 3, "open (switches 1 and 2)."),
        (msg.ManeuverStrokeRequest, ErrorCode.ANGLE_OUT_OF_RANGE, 0, "(stroke 1)."),
        (msg.ManeuverCommitRequest, ErrorCode.STROKES_OVERLAP, 15, "(stroke 16)."),
        (msg.ManeuverCommitRequest, ErrorCode.STEP_MISSING, 2, "(stroke 3)."),
        (msg.ManeuverCommitRequest, ErrorCode.TOO_EARLY, -1, None),
        (msg.ManeuverBeginRequest, ErrorCode.TOO_MANY_STROKES, 17, None),
        (msg.SettingsWriteRequest, ErrorCode.SETTING_OUT_OF_RANGE, 1, "(joint 2)."),
        (msg.SettingsWriteRequest, ErrorCode.SETTING_OUT_OF_RANGE, 3, "(the frame)."),
        (msg.JogRequest, ErrorCode.ANGLE_OUT_OF_RANGE, 3, "(joint 3)."),
        (msg.LoggerSettingsWriteRequest, ErrorCode.RATE_TOO_HIGH, 500, "(at most 500 Hz)."),
    ],
)
def test_a_refusal_names_what_its_detail_refers_to(
    about: type[Payload], code: ErrorCode, detail: int, named: str | None
) -> None:
    what = board_error(msg.ErrorReply(about.TYPE, code, detail)).what
    assert what == REMEDIES[code][0] if named is None else what.endswith(named)


def test_a_refusal_of_another_request_is_not_ours() -> None:
    def script(frame: Frame) -> Iterator[Answer]:
        yield refusal(frame, ErrorCode.WRONG_STATE, about=msg.ArmRequest.TYPE)
        yield refusal(Frame(frame.type, (frame.sequence - 1) & 0xFF, b""), ErrorCode.WRONG_STATE)
        yield reply(frame, SAFE)

    link, _ = client(script)
    assert link.request(msg.DisarmRequest(), msg.DisarmReply) == SAFE


@pytest.mark.parametrize("payload", [b"", b"\0\0", b"\x63"])
def test_an_answer_that_makes_no_sense_is_said_so(payload: bytes) -> None:
    """Another length, or a state that this program does not know."""
    link, _ = client(lambda frame: [encode_frame(Frame(frame.type | 0x80, frame.sequence, payload))])
    with pytest.raises(ProtocolError, match="cannot read") as caught:
        link.request(msg.DisarmRequest(), msg.DisarmReply)
    assert "release" in caught.value.next_step


def test_an_unknown_error_code_is_said_so() -> None:
    answer = b"\x21\xee\xff\xff\xff\xff"
    link, _ = client(lambda frame: [encode_frame(Frame(0xFF, frame.sequence, answer))])
    with pytest.raises(ProtocolError, match="238 is no ErrorCode"):
        link.request(msg.DisarmRequest(), msg.DisarmReply)


def test_live_samples_between_the_lines() -> None:
    """Samples that come before, with and after an answer are kept in order, and answer nothing."""

    def script(frame: Frame) -> Iterator[Answer]:
        yield live_sample(1)
        yield live_sample(2) + reply(frame, SAFE) + live_sample(3)
        yield live_sample(4)

    link, transport = client(script)
    assert link.request(msg.DisarmRequest(), msg.DisarmReply) == SAFE
    assert [sample.index for sample in link.live_samples(0.1)] == [1, 2, 3]
    assert [sample.index for sample in link.live_samples(0.1)] == [4]
    before_s = transport.now_s()
    assert link.live_samples(0.1) == []
    assert transport.now_s() - before_s == pytest.approx(0.1)


@pytest.mark.parametrize("change", [lambda payload: payload[:-1], lambda payload: payload + b"\0"])
def test_a_live_sample_of_another_length_is_refused(change: Callable[[bytes], bytes]) -> None:
    link, transport = client(lambda frame: [reply(frame, SAFE)])
    (frame,) = FrameReceiver().feed(live_sample(1))
    transport.say(encode_frame(replace(frame, payload=change(frame.payload))))
    with pytest.raises(ProtocolError, match="LiveSampleStream has"):
        link.live_samples(0.1)


def test_samples_nobody_takes_are_bounded_and_the_newest_stay() -> None:
    link, transport = client(lambda frame: [reply(frame, SAFE)])
    transport.say(b"".join(live_sample(index) for index in range(MAX_BACKLOG + 10)))
    link.request(msg.DisarmRequest(), msg.DisarmReply)
    samples = link.live_samples(0.1)
    assert len(samples) == MAX_BACKLOG
    assert samples[-1].index == MAX_BACKLOG + 9


def test_hello_says_who_answers() -> None:
    link, _ = client(lambda frame: [reply(frame, hello())])
    identity = link.hello(Board.SEQUENCER)
    assert record(IDENTITY, identity) == {
        "board": "sequencer",
        "serial": "00000102030405ff",
        "firmware": "1.2.3",
        "image_crc": "00c0ffee",
        "protocol_hash": hello().protocol_hash.hex(),
    }
    assert link.hello() == identity


def test_a_chip_without_a_serial_number_has_none() -> None:
    link, _ = client(lambda frame: [reply(frame, hello(serial=bytes(8)))])
    assert link.hello().serial == ""


@pytest.mark.parametrize(
    ("expected_board", "actual_board"), [(Board.SEQUENCER, Board.LOGGER), (Board.LOGGER, Board.SEQUENCER)]
)
def test_the_other_board_is_told_apart(expected_board: Board, actual_board: Board) -> None:
    link, transport = client(lambda frame: [reply(frame, hello(actual_board))])
    with pytest.raises(WrongBoard) as caught:
        link.hello(expected_board)
    error = caught.value
    assert error.what.startswith(f"The board at scripted is the {actual_board.name.lower()}")
    assert "--port" in error.next_step
    assert expected_board.name.lower() in error.next_step
    assert error.exit_code == 1
    assert {frame.type for frame in transport.requests} == {msg.HelloRequest.TYPE}


@pytest.mark.parametrize(
    ("version", "expected_text", "unsaid"),
    [
        (bytes(FIRMWARE_VERSION), "Update the sequencer: flash this checkout", "install"),
        (b"\0\0\x09", "The sequencer is the older side (0.0.9): flash this checkout", "install"),
        (b"\x01\x02\x03", "This program is the older side (0.2.0): check out tfsat 1.2.3 and install", None),
    ],
    ids=["same", "board older", "host older"],
)
def test_another_protocol_says_which_side_to_update(
    version: bytes, expected_text: str, unsaid: str | None
) -> None:
    other = bytes(range(8))
    answer = replace(hello(protocol_hash=other), firmware_version=version)
    link, transport = client(lambda frame: [reply(frame, answer)])
    with pytest.raises(WrongBoard) as caught:
        link.hello(Board.SEQUENCER)
    assert other.hex() in caught.value.what
    assert hello().protocol_hash.hex() in caught.value.what
    step = caught.value.next_step
    assert step.startswith(expected_text)
    assert step.endswith("make firmware && tfsat-host flash sequencer --port scripted")
    assert unsaid is None or unsaid not in step
    assert caught.value.code == "other-protocol"
    assert {frame.type for frame in transport.requests} == {msg.HelloRequest.TYPE}


def test_the_sketch_that_errors_name_exists() -> None:
    link, _ = client(lambda frame: [reply(frame, hello(Board.LOGGER, bytes(8)))])
    with pytest.raises(WrongBoard) as caught:
        link.hello()
    sketch = caught.value.next_step.rpartition(" ")[2]
    assert (REPOSITORY / sketch / f"{Path(sketch).name}.ino").is_file()


def test_the_wrong_board_is_told_before_its_protocol() -> None:
    link, _ = client(lambda frame: [reply(frame, hello(Board.LOGGER, bytes(8)))])
    with pytest.raises(WrongBoard, match="is the logger"):
        link.hello(Board.SEQUENCER)


def test_hello_of_an_unknown_kind_of_board() -> None:
    payload = b"\x09" + hello().encode()[1:]
    link, _ = client(lambda frame: [encode_frame(Frame(msg.HelloReply.TYPE, frame.sequence, payload))])
    with pytest.raises(ProtocolError, match="9 is no Board"):
        link.hello()


def test_closing_lets_go_of_the_port() -> None:
    link, transport = client(lambda _: [])
    link.close()
    assert transport.closed


def test_a_board_that_stays_busy_is_given_up() -> None:
    busy_times_s: list[float] = []
    transport = ScriptedTransport(lambda frame: [refusal(frame, ErrorCode.BUSY)])
    waiting = Client(transport, on_busy=lambda: busy_times_s.append(transport.now_s()))
    with pytest.raises(BoardError, match="counting the free room") as caught:
        waiting.request(msg.LogListRequest(0), msg.LogListReply)
    assert caught.value.code == ErrorCode.BUSY
    assert len(busy_times_s) == 1
    assert transport.now_s() - busy_times_s[0] == pytest.approx(BUSY_TIMEOUT_S, abs=1.0)
