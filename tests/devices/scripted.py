"""A board that says what the test scripted, on a clock that only reading moves."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable

from tfsat_host.devices.client import Client
from tfsat_host.protocol.enums import Board, ErrorCode
from tfsat_host.protocol.framing import Frame, FrameReceiver, encode_frame
from tfsat_host.protocol.limits import PROTOCOL_HASH, REPLY_BIT
from tfsat_host.protocol.messages import ErrorReply, HelloReply, ImuReading, LiveSampleStream, Sample
from tfsat_host.protocol.record import Record

Answer = bytes | None
"""Bytes that the board sends, or silence."""
Script = Callable[[Frame], Iterable[Answer]]


class ScriptedTransport:
    """Calls `script` with each frame that arrives; what it yields is read piece by piece.

    A piece takes 1 ms; None lets a read run out of time.
    """

    name = "scripted"

    def __init__(self, script: Script) -> None:
        self._script = script
        self._receiver = FrameReceiver()
        self._answers: deque[Answer] = deque()
        self._now_s = 1000.0
        self.requests: list[Frame] = []
        self.written = b""
        self.closed = False

    def now_s(self) -> float:
        return self._now_s

    def write(self, data: bytes) -> None:
        self.written += data
        for frame in self._receiver.feed(data):
            self.requests.append(frame)
            self._answers += self._script(frame)

    def say(self, data: Answer) -> None:
        """Queue data that the board sends without being asked."""
        self._answers.append(data)

    def read(self, timeout_s: float) -> bytes:
        answer = self._answers.popleft() if self._answers else None
        if answer is None:
            self._now_s += timeout_s
            return b""
        self._now_s += 0.001
        return answer

    def close(self) -> None:
        self.closed = True


def client(script: Script) -> tuple[Client, ScriptedTransport]:
    transport = ScriptedTransport(script)
    return Client(transport), transport


def reply(request: Frame, payload: Record, sequence: int | None = None) -> bytes:
    """Return the encoded frame that answers `request`."""
    chosen = request.sequence if sequence is None else sequence
    return encode_frame(Frame(request.type | REPLY_BIT, chosen & 0xFF, payload.encode()))


def refusal(request: Frame, code: ErrorCode, detail: int = -1, about: int | None = None) -> bytes:
    """Return the encoded error frame that answers `request`."""
    error = ErrorReply(request.type if about is None else about, code, detail)
    return encode_frame(Frame(ErrorReply.TYPE, request.sequence, error.encode()))


def hello(
    board: Board = Board.SEQUENCER,
    protocol_hash: bytes = PROTOCOL_HASH,
    serial: bytes = b"\0\0\x01\x02\x03\x04\x05\xff",
) -> HelloReply:
    return HelloReply(board, b"\x01\x02\x03", serial, 0x00C0FFEE, protocol_hash)


def live_sample(index: int) -> bytes:
    still = ImuReading((0, 0, 16384), 0, (0, 0, 0))
    sample = Sample(0, 0x3FF, (still,) * 4, (0,) * 6)
    stream = LiveSampleStream(index, 1000 * index, sample)
    return encode_frame(Frame(LiveSampleStream.TYPE, index & 0xFF, stream.encode()))
