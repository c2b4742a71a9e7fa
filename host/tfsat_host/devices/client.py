"""Requests and replies on a link: numbering, repeating, matching, and what refusals mean."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import TypeVar

from tfsat_host.devices.board_errors import (
    BoardError,
    BoardRefusal,
    NoAnswer,
    WrongBoard,
    board_error,
    other_board,
    other_protocol,
)
from tfsat_host.devices.identity import BoardIdentity
from tfsat_host.devices.transport import Transport
from tfsat_host.protocol.enums import Board, ErrorCode
from tfsat_host.protocol.framing import Frame, FrameReceiver, encode_frame
from tfsat_host.protocol.limits import REPLY_BIT
from tfsat_host.protocol.messages import (
    ErrorReply,
    HelloReply,
    HelloRequest,
    LiveSampleStream,
    LogPartStream,
    LogReadReply,
    LogZerosStream,
)
from tfsat_host.protocol.record import Payload

__all__ = ["BoardError", "BoardIdentity", "BoardRefusal", "Client", "NoAnswer", "WrongBoard", "board_error"]

Reply = TypeVar("Reply", bound=Payload)
LogPiece = LogPartStream | LogZerosStream

ATTEMPT_TIMEOUT_S = 0.25
"""A board answers within a few milliseconds; a USB hub may add tens."""
ATTEMPTS = 8
BUSY_TIMEOUT_S = 60.0
"""The largest FAT32 card in its smallest clusters is counted in 4 s, at a sampling rate of 1 kHz in 20 s."""
BUSY_POLL_S = 0.25
LONGEST_BACKLOG = 4096
"""Live samples kept while nobody takes them: 15 s at 280 Hz, 4 s at 1 kHz."""


class Client:
    """The host's end of a link to one board.

    A request is repeated until it is answered: the protocol makes a second copy harmless. Replies are
    matched by type and sequence number; what answers an older copy is dropped.
    """

    def __init__(self, transport: Transport, *, on_busy: Callable[[], None] = lambda: None) -> None:
        """`on_busy` is called when a request has to wait until the board is not busy any more."""
        self.transport = transport
        self._on_busy = on_busy
        self._receiver = FrameReceiver()
        self._sequence = 0
        self._live: deque[LiveSampleStream] = deque(maxlen=LONGEST_BACKLOG)
        self._log_pieces: list[LogPiece] = []

    def request(self, message: Payload, reply_type: type[Reply], *, attempts: int = ATTEMPTS) -> Reply:
        """Sends `message`, up to `attempts` times, and returns the board's reply; waits while it is busy.

        Raises:
            BoardError: the board refused (BoardRefusal where an interlock did), or was busy for BUSY_TIMEOUT_S.
            NoAnswer: nothing came back after all attempts.
            PortError: the connection broke.
            ProtocolError: the reply has an unknown value or a wrong length.
        """
        deadline: float | None = None
        while True:
            try:
                return reply_type.decode(self._exchange(message, attempts))
            except BoardError as error:
                if error.code != ErrorCode.BUSY or (
                    deadline is not None and self.transport.now_s() > deadline
                ):
                    raise
            if deadline is None:
                deadline = self.transport.now_s() + BUSY_TIMEOUT_S
                self._on_busy()
            self.wait(BUSY_POLL_S)

    def _exchange(self, message: Payload, attempts: int) -> bytes:
        request_type = message.TYPE
        self._sequence = (self._sequence + 1) & 0xFF
        frame = encode_frame(Frame(request_type, self._sequence, message.encode()))
        for _ in range(attempts):
            # A zero first ends whatever a broken cable left half-sent.
            self.transport.write(b"\0" + frame)
            payload = self._await(request_type)
            if payload is not None:
                return payload
        raise NoAnswer(self.transport.name)

    def _await(self, request_type: int) -> bytes | None:
        """The reply's payload, or None when it did not come in time."""
        deadline = self.transport.now_s() + ATTEMPT_TIMEOUT_S
        while (left := deadline - self.transport.now_s()) > 0:
            for frame in self._receive(left):
                if frame.sequence != self._sequence:
                    continue
                if frame.type == request_type | REPLY_BIT:
                    return frame.payload
                if frame.type == ErrorReply.TYPE:
                    error = ErrorReply.decode(frame.payload)
                    if error.request == request_type:
                        raise board_error(error)
        return None

    def _receive(self, timeout_s: float) -> list[Frame]:
        """Frames that have arrived, what was sent unasked set apart."""
        frames = []
        for frame in self._receiver.feed(self.transport.read(timeout_s)):
            if frame.type == LiveSampleStream.TYPE:
                self._live.append(LiveSampleStream.decode(frame.payload))
            elif frame.type == LogPartStream.TYPE:
                self._log_pieces.append(LogPartStream.decode(frame.payload))
            elif frame.type == LogZerosStream.TYPE:
                self._log_pieces.append(LogZerosStream.decode(frame.payload))
            else:
                if frame.type == LogReadReply.TYPE:
                    self._log_pieces.clear()  # those before it belong to an earlier request
                frames.append(frame)
        return frames

    def live_samples(self, timeout_s: float) -> list[LiveSampleStream]:
        """Live samples that have arrived, waiting up to `timeout_s` for the first. Raises PortError."""
        deadline = self.transport.now_s() + timeout_s
        while not self._live and (left := deadline - self.transport.now_s()) > 0:
            self._receive(left)  # a read may end in the middle of a frame
        samples = list(self._live)
        self._live.clear()
        return samples

    def log_pieces(self, timeout_s: float) -> list[LogPiece]:
        """Pieces of the recording that LOG_READ asked for last, waiting up to `timeout_s`. Raises PortError."""
        deadline = self.transport.now_s() + timeout_s
        while not self._log_pieces and (left := deadline - self.transport.now_s()) > 0:
            self._receive(left)
        pieces, self._log_pieces = self._log_pieces, []
        return pieces

    def wait(self, duration_s: float) -> None:
        """Lets time pass on the transport's clock; live samples are kept. Raises PortError."""
        deadline = self.transport.now_s() + duration_s
        while (left := deadline - self.transport.now_s()) > 0:
            self._receive(left)

    def identify(self, expected: Board | None = None) -> BoardIdentity:
        """Asks who answers and insists on `expected` (None: any board), whatever protocol it speaks.

        HELLO, and DISARM of the sequencer, are frozen: their numbers and layouts are the same in every
        revision of the protocol, so that any host can ask any board who it is and make a robot safe.

        Raises:
            WrongBoard: another board.
        """
        identity = BoardIdentity.from_reply(self.request(HelloRequest(), HelloReply))
        if expected is not None and identity.board != expected:
            raise other_board(self.transport.name, identity.board, expected)
        return identity

    def hello(self, expected: Board | None = None) -> BoardIdentity:
        """Asks who answers and insists on `expected` (None: any board) with this protocol.

        Raises:
            WrongBoard: another board, or another protocol; says which side to update.
        """
        identity = self.identify(expected)
        if not identity.speaks_this_protocol:
            raise other_protocol(self.transport.name, identity)
        return identity

    def close(self) -> None:
        """Lets go of the port."""
        self.transport.close()
