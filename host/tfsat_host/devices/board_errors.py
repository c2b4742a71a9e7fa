"""Why a board does not do what was asked: its refusals in words, silence, another board, another protocol."""

from __future__ import annotations

from tfsat_host.devices.board_identity import BoardIdentity
from tfsat_host.devices.serial_ports import PortProblem
from tfsat_host.errors import RefusedError, TfsatError
from tfsat_host.next_step import Advice, NextStep
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import Board, ErrorCode
from tfsat_host.protocol.limits import FIRMWARE_VERSION, JOINT_COUNT, PROTOCOL_HASH, SWITCH_COUNT
from tfsat_host.protocol.remedies import REMEDIES

# Refusals by which the board protects the robot, which is unchanged.
_INTERLOCKS = (
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
)
# Refusals whose detail is the index of a stroke.
_ABOUT_STROKES = (
    ErrorCode.STEP_MISSING,
    ErrorCode.JOINT_UNKNOWN,
    ErrorCode.ANGLE_OUT_OF_RANGE,
    ErrorCode.STROKES_OVERLAP,
    ErrorCode.STARTS_TOO_CLOSE,
    ErrorCode.TOO_EARLY,
    ErrorCode.TOO_LONG,
    ErrorCode.INDEX_OUT_OF_RANGE,
)
_LOGGER_SKETCH = "firmware/teensy_logger"


class BoardError(TfsatError):
    """A board refused a request; `code` says why, `detail` what it refers to."""

    code: ErrorCode

    def __init__(self, reply: msg.ErrorReply) -> None:
        what, meaning, next_step = REMEDIES[reply.code]
        super().__init__(
            what=f"{what[:-1]}{_where(reply)}.", meaning=meaning, next_step=next_step, code=reply.code
        )
        self.detail = reply.detail


def _where(reply: msg.ErrorReply) -> str:
    """Describe in words what the reply's detail refers to, which depends on the request."""
    if reply.detail < 0:
        return ""
    # JOG counts joints from 1; switches are bits, and settings and strokes are counted from 0.
    if reply.request == msg.JogRequest.TYPE:
        return f" (joint {reply.detail})"
    if reply.code == ErrorCode.SWITCH_OPEN:
        return _switches(reply.detail)
    if reply.code == ErrorCode.SETTING_OUT_OF_RANGE:
        names = [f"joint {joint}" for joint in range(1, JOINT_COUNT + 1)] + ["the frame", "moving_at_once"]
        return f" ({names[reply.detail]})" if reply.detail < len(names) else ""
    if reply.code == ErrorCode.RATE_TOO_HIGH:
        return f" (at most {reply.detail} Hz)"
    if reply.code == ErrorCode.LOGGER_SETTING_OUT_OF_RANGE and reply.detail < len(msg.LoggerSettings.LAYOUT):
        return f" ({msg.LoggerSettings.LAYOUT[reply.detail][0]})"
    return f" (stroke {reply.detail + 1})" if reply.code in _ABOUT_STROKES else ""


def _switches(bits: int) -> str:
    numbers = [str(bit + 1) for bit in range(SWITCH_COUNT) if bits >> bit & 1]
    if not numbers:
        return ""
    return f" (switch{'es' if len(numbers) > 1 else ''} {' and '.join(numbers)})"


class BoardRefusal(BoardError, RefusedError):
    """An interlock of the board refused; the robot is unchanged."""


class NoAnswer(TfsatError):
    """No board answered on the port."""

    def __init__(self, port: str) -> None:
        super().__init__(
            what=f"No answer from {port}.",
            meaning="There is no tfsat board at this port, or it hangs. Nothing is known of its state.",
            next_step=Advice(
                "Unplug and plug the board, check that the sketch is flashed, then: ", NextStep("ports")
            ),
            code=PortProblem.NO_ANSWER,
        )


class WrongBoard(TfsatError):
    """Another board, or a board with another protocol, answered; `code` is other-board or other-protocol."""


class VerifyError(TfsatError):
    """What was read back is not what was sent."""

    code = "verify-failed"


def board_error(reply: msg.ErrorReply) -> BoardError:
    """Build the exception for an error reply: a BoardRefusal if an interlock refused."""
    return BoardRefusal(reply) if reply.code in _INTERLOCKS else BoardError(reply)


def other_protocol(port: str, identity: BoardIdentity) -> WrongBoard:
    """Build the error where board and host have different specifications: which side to update, and how."""
    name = identity.board.name.lower()
    ours = ".".join(str(part) for part in FIRMWARE_VERSION)
    theirs = tuple(int(part) for part in identity.firmware.split("."))
    if identity.board is Board.SEQUENCER:
        flash: str = Advice(
            "flash this checkout's firmware:\nmake firmware && ",
            NextStep("flash sequencer", ("--port", port)),
        )
    else:
        flash = (
            f"flash the sketch of this checkout, {_LOGGER_SKETCH}: open it in the Arduino IDE and upload it, or type\n"
            f"arduino-cli compile --upload --fqbn teensy:avr:teensy41 --port {port} {_LOGGER_SKETCH}"
        )
    if theirs == FIRMWARE_VERSION:
        update = Advice(f"Update the {name}: ", flash)
    elif theirs < FIRMWARE_VERSION:
        update = Advice(f"The {name} is the older side ({identity.firmware}): ", flash)
    else:
        update = Advice(
            f"This program is the older side ({ours}): check out tfsat {identity.firmware} and install its "
            f"host package there: python -m pip install .\nOr take the {name} back to {ours}: ",
            flash,
        )
    return WrongBoard(
        what=f"The {name} at {port} runs firmware {identity.firmware} with protocol {identity.protocol_hash}; "
        f"this program, {ours}, speaks {PROTOCOL_HASH.hex()}.",
        meaning="They might misunderstand each other, so nothing was sent.",
        next_step=update,
        code=PortProblem.OTHER_PROTOCOL,
    )
