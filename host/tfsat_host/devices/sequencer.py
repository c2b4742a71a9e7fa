"""What a host asks of the sequencer."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Self

from tfsat_host.devices.client import BoardError, BoardIdentity, Client, board_error
from tfsat_host.devices.transport import Transport
from tfsat_host.errors import TfsatError
from tfsat_host.maneuver import Schedule, TimedStroke
from tfsat_host.protocol.enums import Board, ErrorCode, ManeuverOrigin, SequencerState
from tfsat_host.protocol.framing import crc16
from tfsat_host.protocol.messages import (
    ArmReply,
    ArmRequest,
    DisarmReply,
    DisarmRequest,
    ErrorReply,
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
    SequencerStatusReply,
    SequencerStatusRequest,
)

STORE_POLL_S = 0.02
STORE_TIMEOUT_S = 3.0
"""The EEPROM takes 3.4 ms a byte, a full maneuver 0.4 s."""


class VerifyError(TfsatError):
    """What was read back is not what was sent."""

    code = "verify-failed"


@dataclass(frozen=True, slots=True)
class StoredManeuver:
    """What would fly.

    Attributes:
        origin: Factory or uploaded.
        strokes: (joint, angle_cdeg, start_us) of each, in order.
        speed_cdeg_s: Average joint speed that the schedule assumes, 0.01 deg/s.
        crc: CRC-16/IBM-3740 of the canonical form.
        end_us: When the last stroke ends, after release.
        generation: Uploads that the board has stored.
    """

    origin: ManeuverOrigin
    strokes: tuple[tuple[int, int, int], ...]
    speed_cdeg_s: int
    crc: int
    end_us: int
    generation: int


@dataclass(frozen=True, slots=True)
class UploadResult:
    """A verified upload: `written` is False when the board held the same maneuver already."""

    written: bool
    stored: StoredManeuver


class SequencerClient:
    """The sequencer at the other end of a link."""

    def __init__(self, client: Client, identity: BoardIdentity) -> None:
        self._client = client
        self.identity = identity

    @classmethod
    def connect(cls, transport: Transport) -> Self:
        """Asks who answers. Raises WrongBoard, NoAnswer, PortError."""
        client = Client(transport)
        return cls(client, client.hello(Board.SEQUENCER))

    @classmethod
    def connect_any_protocol(cls, transport: Transport) -> Self:
        """Asks who answers and takes a sequencer of any revision; of the requests, only DISARM is frozen.

        Raises WrongBoard (another kind of board), NoAnswer, PortError.
        """
        client = Client(transport)
        return cls(client, client.identify(Board.SEQUENCER))

    @property
    def port(self) -> str:
        """What a person calls the port."""
        return self._client.transport.name

    def close(self) -> None:
        """Lets go of the port."""
        self._client.close()

    def status(self) -> SequencerStatusReply:
        """The board's state."""
        return self._client.request(SequencerStatusRequest(), SequencerStatusReply)

    def upload(self, schedule: Schedule) -> UploadResult:
        """Sends the maneuver, has it stored, reads it back and compares.

        Nothing replaces the stored maneuver until all of it has arrived and was found valid.

        Raises:
            BoardError: the board refused; its stored maneuver is unchanged.
            VerifyError: the board holds something else than was sent.
        """
        ask = self._client.request
        ask(ManeuverBeginRequest(len(schedule.strokes), schedule.speed_cdeg_s), ManeuverBeginReply)
        for index, stroke in enumerate(schedule.strokes):
            ask(
                ManeuverStrokeRequest(index, stroke.joint, stroke.angle_cdeg, stroke.t_us),
                ManeuverStrokeReply,
            )
        written = self._commit(maneuver_crc(schedule))
        stored = self.read_back()
        wanted = tuple(_row(stroke) for stroke in schedule.strokes)
        if stored.strokes != wanted or stored.speed_cdeg_s != schedule.speed_cdeg_s:
            raise VerifyError(
                what=f"The sequencer holds {stored.strokes}, but {wanted} was sent.",
                meaning="It would fly something else than you asked for. Do not arm it.",
                next_step="Run the same upload again; if it recurs, replace the board.",
            )
        return UploadResult(written=written, stored=stored)

    def _commit(self, crc: int) -> bool:
        """Repeats the commit until the EEPROM holds the maneuver; True when it had to be written."""
        deadline = self._client.transport.now_s() + STORE_TIMEOUT_S
        while True:
            reply = self._client.request(ManeuverCommitRequest(crc), ManeuverCommitReply)
            if reply.stored:
                return bool(reply.written)
            if self._client.transport.now_s() > deadline:
                raise VerifyError(
                    what=f"The sequencer was still writing after {STORE_TIMEOUT_S:g} s.",
                    meaning="Its EEPROM may be worn out. The maneuver from before is still stored.",
                    next_step="Power the board off and on, then run the same upload again.",
                )
            self._client.wait(STORE_POLL_S)

    def read_back(self) -> StoredManeuver:
        """Reads what would fly, stroke by stroke, and checks it against the board's own CRC.

        Raises:
            VerifyError: the strokes read do not have the CRC that the board names.
        """
        info = self._client.request(ManeuverInfoRequest(), ManeuverInfoReply)
        replies = [
            self._client.request(ManeuverReadRequest(index), ManeuverReadReply)
            for index in range(info.stroke_count)
        ]
        strokes = tuple((reply.joint, reply.angle_cdeg, reply.start_us) for reply in replies)
        if _crc(info.speed_cdeg_s, strokes) != info.crc:
            raise VerifyError(
                what="The strokes read from the sequencer do not fit its CRC.",
                meaning="Its memory is damaged. Do not arm it.",
                next_step="Upload the maneuver again; if it recurs, replace the board.",
            )
        return StoredManeuver(info.origin, strokes, info.speed_cdeg_s, info.crc, info.end_us, info.generation)

    def arm(self) -> SequencerState:
        """Arms: from now on the release starts the maneuver. Raises BoardRefusal with the reason."""
        token = self.status().arm_token
        return self._client.request(ArmRequest(token), ArmReply).state

    def disarm(self) -> SequencerState:
        """Back to safe, from any state. Frozen: DISARM has this number and layout in every protocol."""
        return self._client.request(DisarmRequest(), DisarmReply).state


def arm_refusal(status: SequencerStatusReply) -> BoardError | None:
    """What the board would answer to ARM in this state, as far as its status tells; None: nothing against it."""
    if status.state == SequencerState.FAULT:
        code = ErrorCode.FAULT_LATCHED
    elif status.state not in (SequencerState.SAFE, SequencerState.DONE):
        code = ErrorCode.WRONG_STATE
    elif status.switches_open:
        code = ErrorCode.SWITCH_OPEN
    else:
        return None
    return board_error(ErrorReply(ArmRequest.TYPE, code, -1))


def maneuver_crc(schedule: Schedule) -> int:
    """CRC-16/IBM-3740 of the canonical form (protocol reference, maneuver_commit)."""
    return _crc(schedule.speed_cdeg_s, tuple(_row(stroke) for stroke in schedule.strokes))


def _row(stroke: TimedStroke) -> tuple[int, int, int]:
    return stroke.joint, stroke.angle_cdeg, stroke.t_us


def _crc(speed_cdeg_s: int, strokes: tuple[tuple[int, int, int], ...]) -> int:
    canonical = struct.pack("<BH", len(strokes), speed_cdeg_s)
    canonical += b"".join(struct.pack("<BhI", *stroke) for stroke in strokes)
    return crc16(canonical)
