"""What can be wrong with a board that was asked: a refusal, silence, another board, another protocol."""

from __future__ import annotations

from enum import StrEnum

from tfsat_host.devices.identity import BoardIdentity
from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.protocol.enums import Board, ErrorCode
from tfsat_host.protocol.limits import FIRMWARE_VERSION, JOINT_COUNT, PROTOCOL_HASH, SWITCH_COUNT
from tfsat_host.protocol.messages import ErrorReply, JogRequest, LoggerSettings
from tfsat_host.protocol.remedies import REMEDIES

_INTERLOCKS = (
    ErrorCode.WRONG_STATE,
    ErrorCode.SWITCH_OPEN,
    ErrorCode.NO_MANEUVER,
    ErrorCode.STALE_TOKEN,
    ErrorCode.FAULT_LATCHED,
    ErrorCode.NOT_AT_START_POSE,
    ErrorCode.JOG_NOT_CONFIRMED,
    ErrorCode.SETTINGS_DO_NOT_FIT,
    ErrorCode.STORE_DAMAGED,
    ErrorCode.UPLOAD_INTERRUPTED,
    ErrorCode.STORE_OLD_LAYOUT,
    ErrorCode.RAM_HOLDS_DROP,
)
_ABOUT_STROKES = (
    ErrorCode.STEP_MISSING,
    ErrorCode.JOINT_UNKNOWN,
    ErrorCode.ANGLE_OUT_OF_RANGE,
    ErrorCode.STROKES_OVERLAP,
    ErrorCode.TOO_EARLY,
    ErrorCode.TOO_LONG,
    ErrorCode.INDEX_OUT_OF_RANGE,
)
_LOGGER_SKETCH = "firmware/teensy_logger"


class LinkProblem(StrEnum):
    """Stable names of what is wrong with whoever answers, or does not."""

    NO_ANSWER = "no-answer"
    OTHER_BOARD = "other-board"
    OTHER_PROTOCOL = "other-protocol"


class BoardError(TfsatError):
    """A board refused a request; `code` says why, `detail` what it refers to."""

    def __init__(self, reply: ErrorReply) -> None:
        what, meaning, next_step = REMEDIES[reply.code]
        super().__init__(what=f"{what[:-1]}{_where(reply)}.", meaning=meaning, next_step=next_step)
        self.code = reply.code
        self.detail = reply.detail


def _where(reply: ErrorReply) -> str:
    """What the detail refers to, in words; it depends on the request."""
    if reply.detail < 0:
        return ""
    if reply.request == JogRequest.TYPE:
        return f" (joint {reply.detail})"
    if reply.code == ErrorCode.SWITCH_OPEN:
        return _switches(reply.detail)
    if reply.code == ErrorCode.SETTING_OUT_OF_RANGE:
        return f" (joint {reply.detail + 1})" if reply.detail < JOINT_COUNT else " (the frame)"
    if reply.code == ErrorCode.RATE_TOO_HIGH:
        return f" (at most {reply.detail} Hz)"
    if reply.code == ErrorCode.LOGGER_SETTING_OUT_OF_RANGE and reply.detail < len(LoggerSettings.LAYOUT):
        return f" ({LoggerSettings.LAYOUT[reply.detail][0]})"
    return f" (stroke {reply.detail + 1})" if reply.code in _ABOUT_STROKES else ""


def _switches(bits: int) -> str:
    numbers = [str(bit + 1) for bit in range(SWITCH_COUNT) if bits >> bit & 1]
    if not numbers:
        return ""
    return f" (switch{'es' if len(numbers) > 1 else ''} {' and '.join(numbers)})"


class BoardRefusal(BoardError, RefusedError):
    """An interlock of the board refused; the robot is as it was."""


class NoAnswer(TfsatError):
    """Nobody answered on the port."""

    code = LinkProblem.NO_ANSWER

    def __init__(self, port: str) -> None:
        super().__init__(
            what=f"No answer from {port}.",
            meaning="There is no tfsat board at this port, or it hangs. Nothing is known of its state.",
            next_step="Unplug and plug the board, check that the sketch is flashed, then: tfsat-host ports",
        )


class WrongBoard(TfsatError):
    """Another board, or a board with another protocol, answered; `code` says which."""

    def __init__(self, code: LinkProblem, *, what: str, meaning: str, next_step: str) -> None:
        super().__init__(what=what, meaning=meaning, next_step=next_step)
        self.code = code


def board_error(reply: ErrorReply) -> BoardError:
    """The exception for an error reply: a refusal where an interlock spoke."""
    return BoardRefusal(reply) if reply.code in _INTERLOCKS else BoardError(reply)


def other_board(port: str, found: Board, expected: Board) -> WrongBoard:
    """The cable leads to the other board."""
    return WrongBoard(
        LinkProblem.OTHER_BOARD,
        what=f"The board at {port} is the {found.name.lower()}; this command is for the {expected.name.lower()}.",
        meaning="Nothing was sent to it but the question who it is.",
        next_step=f"Give the {expected.name.lower()}'s port with --port; tfsat-host ports lists them.",
    )


def other_protocol(port: str, identity: BoardIdentity) -> WrongBoard:
    """Board and host were built from different specifications; says which side to update, and how."""
    name = identity.board.name.lower()
    return WrongBoard(
        LinkProblem.OTHER_PROTOCOL,
        what=f"The {name} at {port} runs firmware {identity.firmware} with protocol {identity.protocol_hash}; "
        f"this program, {_version_text()}, speaks {PROTOCOL_HASH.hex()}.",
        meaning="They might misunderstand each other, so nothing was sent.",
        next_step=_update(port, identity),
    )


def _update(port: str, identity: BoardIdentity) -> str:
    name = identity.board.name.lower()
    if identity.board is Board.SEQUENCER:
        flash = f"flash this checkout's firmware:\nmake firmware && tfsat-host flash sequencer --port {port}"
    else:
        flash = (
            f"flash the sketch of this checkout, {_LOGGER_SKETCH}: open it in the Arduino IDE and upload it, or type\n"
            f"arduino-cli compile --upload --fqbn teensy:avr:teensy41 --port {port} {_LOGGER_SKETCH}"
        )
    board_version = tuple(int(part) for part in identity.firmware.split("."))
    if board_version == FIRMWARE_VERSION:
        return f"Update the {name}: {flash}"
    if board_version < FIRMWARE_VERSION:
        return f"The {name} is the older side ({identity.firmware}): {flash}"
    return (
        f"This program is the older side ({_version_text()}): check out tfsat {identity.firmware} and install its "
        f"host package there: python -m pip install .\nOr take the {name} back to {_version_text()}: {flash}"
    )


def _version_text() -> str:
    return ".".join(str(part) for part in FIRMWARE_VERSION)
