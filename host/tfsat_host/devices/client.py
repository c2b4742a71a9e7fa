"""Requests and replies on a link: numbering, repeating, matching, and what refusals mean."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TypeVar

from tfsat_host.devices.transport import Transport
from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.protocol.enums import Board, ErrorCode
from tfsat_host.protocol.framing import Frame, FrameReceiver, encode_frame
from tfsat_host.protocol.limits import PROTOCOL_HASH, REPLY_BIT
from tfsat_host.protocol.messages import ErrorReply, HelloReply, HelloRequest, LiveSampleStream
from tfsat_host.protocol.record import Record
from tfsat_host.protocol.remedies import REMEDIES

Reply = TypeVar("Reply", bound=Record)

ATTEMPT_TIMEOUT_S = 0.25
"""A board answers within a few milliseconds; a USB hub may add tens."""
ATTEMPTS = 8
LONGEST_BACKLOG = 4096
"""Live samples kept while nobody takes them: 15 s at 280 Hz."""


class BoardError(TfsatError):
    """A board refused a request; `code` says why, `detail` what it refers to."""

    def __init__(self, reply: ErrorReply) -> None:
        what, meaning, next_step = REMEDIES[reply.code]
        where = f" (stroke {reply.detail + 1})" if _names_a_stroke(reply) else ""
        super().__init__(what=f"{what[:-1]}{where}.", meaning=meaning, next_step=next_step)
        self.code = reply.code
        self.detail = reply.detail


class BoardRefusal(BoardError, RefusedError):
    """An interlock of the board refused; the robot is as it was."""


class NoAnswer(TfsatError):
    """Nobody answered on the port."""


class WrongBoard(TfsatError):
    """Another board, or a board with another protocol, answered."""


@dataclass(frozen=True, slots=True)
class BoardIdentity:
    """What HELLO says.

    Attributes:
        board: Kind of board.
        serial: Serial number, hexadecimal; empty where the chip has none.
        firmware: Version, such as 0.1.0.
        image_crc: CRC-32/ISO-HDLC of the flashed image, 8 hexadecimal digits; zeros where a core runs natively.
        protocol_hash: Of the specification that the firmware was built with, hexadecimal.
    """

    board: Board
    serial: str
    firmware: str
    image_crc: str
    protocol_hash: str

    def describe(self) -> str:
        """For people: firmware, image and serial number, where there are any."""
        parts = [f"{self.board.name.lower()} firmware {self.firmware}"]
        parts.append(f"image {self.image_crc}" if int(self.image_crc, 16) else "core run natively, no image")
        if self.serial:
            parts.append(f"serial number {self.serial}")
        return ", ".join(parts)

    def as_dict(self) -> dict[str, str]:
        """For `--json`."""
        return {
            "board": self.board.name.lower(),
            "serial": self.serial,
            "firmware": self.firmware,
            "image_crc": self.image_crc,
            "protocol_hash": self.protocol_hash,
        }


class Client:
    """The host's end of a link to one board.

    A request is repeated until it is answered: the protocol makes a second copy harmless. Replies are
    matched by type and sequence number; what answers an older copy is dropped.
    """

    def __init__(self, transport: Transport) -> None:
        self.transport = transport
        self._receiver = FrameReceiver()
        self._sequence = 0
        self._live: deque[LiveSampleStream] = deque(maxlen=LONGEST_BACKLOG)

    def request(self, message: Record, reply_type: type[Reply]) -> Reply:
        """Sends `message` and returns the board's reply.

        Raises:
            BoardError: the board refused (BoardRefusal where an interlock did).
            NoAnswer: nothing came back after several attempts.
            PortError: the connection broke.
            ProtocolError: the reply has an unknown value or a wrong length.
        """
        request_type = _type_of(message)
        self._sequence = (self._sequence + 1) & 0xFF
        frame = encode_frame(Frame(request_type, self._sequence, message.encode()))
        for _ in range(ATTEMPTS):
            # A zero first ends whatever a broken cable left half-sent.
            self.transport.write(b"\0" + frame)
            payload = self._await(request_type)
            if payload is not None:
                return reply_type.decode(payload)
        raise NoAnswer(
            what=f"No answer from {self.transport.name}.",
            meaning="There is no tfsat board at this port, or it hangs. Nothing is known of its state.",
            next_step="Unplug and plug the board, check that the sketch is flashed, then: tfsat-host ports",
        )

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
        """Frames that have arrived, live samples set apart."""
        frames = []
        for frame in self._receiver.feed(self.transport.read(timeout_s)):
            if frame.type == LiveSampleStream.TYPE:
                self._live.append(LiveSampleStream.decode(frame.payload))
            else:
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

    def wait(self, duration_s: float) -> None:
        """Lets time pass on the transport's clock; live samples are kept. Raises PortError."""
        deadline = self.transport.now_s() + duration_s
        while (left := deadline - self.transport.now_s()) > 0:
            self._receive(left)

    def hello(self, expected: Board | None = None) -> BoardIdentity:
        """Asks who answers and insists on `expected` (None: any board) with this protocol.

        Raises:
            WrongBoard: another board, or another protocol; says which side to update.
        """
        reply = self.request(HelloRequest(), HelloReply)
        identity = BoardIdentity(
            board=reply.board,
            serial=reply.board_serial.hex() if any(reply.board_serial) else "",
            firmware=".".join(str(part) for part in reply.firmware_version),
            image_crc=f"{reply.image_crc:08x}",
            protocol_hash=reply.protocol_hash.hex(),
        )
        if expected is not None and identity.board != expected:
            raise _other_board(self.transport.name, identity.board, expected)
        if reply.protocol_hash != PROTOCOL_HASH:
            raise _other_protocol(self.transport.name, identity)
        return identity

    def close(self) -> None:
        """Lets go of the port."""
        self.transport.close()


def board_error(reply: ErrorReply) -> BoardError:
    """The exception for an error reply: a refusal where an interlock spoke."""
    interlocks = (
        ErrorCode.WRONG_STATE,
        ErrorCode.SWITCH_OPEN,
        ErrorCode.NO_MANEUVER,
        ErrorCode.STALE_TOKEN,
        ErrorCode.FAULT_LATCHED,
    )
    return BoardRefusal(reply) if reply.code in interlocks else BoardError(reply)


def _names_a_stroke(reply: ErrorReply) -> bool:
    about_strokes = (
        ErrorCode.STEP_MISSING,
        ErrorCode.JOINT_UNKNOWN,
        ErrorCode.ANGLE_OUT_OF_RANGE,
        ErrorCode.STROKES_OVERLAP,
        ErrorCode.TOO_EARLY,
        ErrorCode.TOO_LONG,
        ErrorCode.INDEX_OUT_OF_RANGE,
    )
    return reply.code in about_strokes and reply.detail >= 0


def _type_of(message: Record) -> int:
    number: int = type(message).TYPE  # type: ignore[attr-defined]
    return number


def _other_board(port: str, found: Board, expected: Board) -> WrongBoard:
    return WrongBoard(
        what=f"The board at {port} is the {found.name.lower()}; this command is for the {expected.name.lower()}.",
        meaning="Nothing was sent to it but the question who it is.",
        next_step=f"Give the {expected.name.lower()}'s port with --port; tfsat-host ports lists them.",
    )


def _other_protocol(port: str, identity: BoardIdentity) -> WrongBoard:
    name = identity.board.name.lower()
    return WrongBoard(
        what=f"The {name} at {port} runs firmware {identity.firmware} with protocol {identity.protocol_hash}; "
        f"this program speaks {PROTOCOL_HASH.hex()}.",
        meaning="They might misunderstand each other, so nothing was sent.",
        next_step=f"Flash the {name} with the sketch of this release (firmware/), or install the host package "
        f"of firmware {identity.firmware}.",
    )
