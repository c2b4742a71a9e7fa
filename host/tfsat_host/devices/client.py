"""Requests and replies on a link: who answers, numbering, repeating, matching."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable
from typing import ClassVar, Self, TypeVar

from tfsat_host.debug_log import STREAM
from tfsat_host.devices.board_errors import BoardError, NoAnswer, WrongBoard, board_error, other_protocol
from tfsat_host.devices.board_identity import BoardIdentity, Device
from tfsat_host.devices.serial_ports import PortProblem
from tfsat_host.devices.transport import Transport
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import Board, ErrorCode
from tfsat_host.protocol.framing import Frame, FrameReceiver, encode_frame
from tfsat_host.protocol.limits import REPLY_BIT
from tfsat_host.protocol.live_sample import LiveSample
from tfsat_host.protocol.record import Payload

_LOG = logging.getLogger(__name__)
_MESSAGE_NAMES = {
    message.TYPE: name
    for name, message in vars(msg).items()
    if isinstance(message, type) and issubclass(message, Payload) and message is not Payload
}

Reply = TypeVar("Reply", bound=Payload)
LogPiece = msg.LogPartStream | msg.LogZerosStream

ATTEMPT_TIMEOUT_S = 0.25
"""A board answers within a few milliseconds; a USB hub may add tens."""
ATTEMPTS = 8
BUSY_TIMEOUT_S = 60.0
"""The largest FAT32 card in its smallest clusters is counted in 4 s, at a sampling rate of 1 kHz in 20 s."""
BUSY_POLL_S = 0.25
MAX_BACKLOG = 4096
"""Live samples kept until they are taken: 15 s at 280 Hz, 4 s at 1 kHz."""


_STREAMS = (msg.LiveSampleStream.TYPE, msg.LogPartStream.TYPE, msg.LogZerosStream.TYPE)


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
        self._live: deque[LiveSample] = deque(maxlen=MAX_BACKLOG)
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
                # BUSY is no refusal: ask on, for as long as the board may take from the first such answer.
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
        # One number for all repetitions of a request: whichever copy is answered, the reply fits.
        self._sequence = (self._sequence + 1) & 0xFF
        frame = encode_frame(Frame(request_type, self._sequence, message.encode()))
        for attempt in range(1, attempts + 1):
            _LOG.debug(
                "%s > %s, number %d, attempt %d",
                self.transport.name,
                type(message).__name__,
                self._sequence,
                attempt,
            )
            # A zero first ends whatever a broken cable left half-sent.
            self.transport.write(b"\0" + frame)
            payload = self._await(request_type)
            if payload is not None:
                return payload
        raise NoAnswer(self.transport.name)

    def _await(self, request_type: int) -> bytes | None:
        """Wait for the reply and return its payload, or None on timeout."""
        deadline = self.transport.now_s() + ATTEMPT_TIMEOUT_S
        while (remaining_s := deadline - self.transport.now_s()) > 0:
            for frame in self._receive(remaining_s):
                if frame.sequence != self._sequence:
                    # A late answer to an earlier request.
                    continue
                if frame.type == request_type | REPLY_BIT:
                    return frame.payload
                if frame.type == msg.ErrorReply.TYPE:
                    error = msg.ErrorReply.decode(frame.payload)
                    # An error names the request that it refuses; one about another request is stale.
                    if error.request == request_type:
                        raise board_error(error)
        return None

    def _receive(self, timeout_s: float) -> list[Frame]:
        """Frames that have arrived, what was sent unasked set apart."""
        frames = []
        # Streams come unasked between replies: queue them for their own readers.
        for frame in self._receiver.feed(self.transport.read(timeout_s)):
            level = STREAM if frame.type in _STREAMS else logging.DEBUG
            _LOG.log(
                level,
                "%s < %s, number %d, %d bytes",
                self.transport.name,
                _MESSAGE_NAMES.get(frame.type, f"type {frame.type:#04x}"),
                frame.sequence,
                len(frame.payload),
            )
            if frame.type == msg.LiveSampleStream.TYPE:
                self._live.append(LiveSample.from_payload(frame.payload))
            elif frame.type == msg.LogPartStream.TYPE:
                self._log_pieces.append(msg.LogPartStream.decode(frame.payload))
            elif frame.type == msg.LogZerosStream.TYPE:
                self._log_pieces.append(msg.LogZerosStream.decode(frame.payload))
            else:
                if frame.type == msg.LogReadReply.TYPE:
                    self._log_pieces.clear()  # those before it belong to an earlier request
                frames.append(frame)
        return frames

    def live_samples(self, timeout_s: float) -> list[LiveSample]:
        """Live samples that have arrived, waiting up to `timeout_s` for the first. Raises PortError."""
        deadline = self.transport.now_s() + timeout_s
        while not self._live and (remaining_s := deadline - self.transport.now_s()) > 0:
            self._receive(remaining_s)  # a read may end in the middle of a frame
        samples = list(self._live)
        self._live.clear()
        return samples

    def log_pieces(self, timeout_s: float) -> list[LogPiece]:
        """Pieces of the recording that LOG_READ asked for last, waiting up to `timeout_s`. Raises PortError."""
        deadline = self.transport.now_s() + timeout_s
        while not self._log_pieces and (remaining_s := deadline - self.transport.now_s()) > 0:
            self._receive(remaining_s)
        pieces, self._log_pieces = self._log_pieces, []
        return pieces

    def wait(self, duration_s: float) -> None:
        """Lets time pass on the transport's clock; live samples are kept. Raises PortError."""
        deadline = self.transport.now_s() + duration_s
        # Read on while time passes: what the board sends meanwhile must not wait in the port's buffer.
        while (remaining_s := deadline - self.transport.now_s()) > 0:
            self._receive(remaining_s)

    def identify(self, expected: Board | None = None) -> BoardIdentity:
        """Asks who answers and insists on `expected` (None: any board), whatever protocol it speaks.

        HELLO, and DISARM of the sequencer, are frozen: their numbers and layouts are the same in every
        revision of the protocol, so that any host can ask any board who it is and make a robot safe.

        Raises:
            WrongBoard: another board.
        """
        identity = BoardIdentity.from_reply(self.request(msg.HelloRequest(), msg.HelloReply))
        if expected is not None and identity.board != expected:
            name, expected_name = identity.board.name.lower(), expected.name.lower()
            raise WrongBoard(
                what=f"The board at {self.transport.name} is the {name}; this command is for the {expected_name}.",
                meaning="Nothing was changed: only its identity was asked.",
                next_step=Advice(
                    f"Give the {expected_name}'s port with --port; ", NextStep("ports"), " lists them."
                ),
                code=PortProblem.OTHER_BOARD,
            )
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


class BoardClient:
    """A board of one kind at the other end of a link, identified."""

    board: ClassVar[Board]

    def __init__(self, client: Client, identity: BoardIdentity) -> None:
        self._client = client
        self.identity = identity

    @classmethod
    def connect(cls, transport: Transport, *, on_busy: Callable[[], None] = lambda: None) -> Self:
        """Asks who answers; `on_busy` as in `Client`. Raises WrongBoard, NoAnswer, PortError."""
        client = Client(transport, on_busy=on_busy)
        return cls(client, client.hello(cls.board))

    @classmethod
    def connect_any_protocol(cls, transport: Transport) -> Self:
        """Asks who answers and takes a board of any revision, of which HELLO and DISARM alone are frozen.

        Raises WrongBoard (another kind of board), NoAnswer, PortError.
        """
        client = Client(transport)
        return cls(client, client.identify(cls.board))

    @property
    def port(self) -> str:
        """What a person calls the port."""
        return self._client.transport.name

    def device(self) -> Device:
        """Return the port and the identity of the board on it."""
        return Device(self.port, self.identity)

    def now_s(self) -> float:
        """Seconds on the transport's clock."""
        return self._client.transport.now_s()

    def wait(self, duration_s: float) -> None:
        """Lets time pass. Raises PortError."""
        self._client.wait(duration_s)

    def close(self) -> None:
        """Lets go of the port."""
        self._client.close()
