"""A maneuver's way onto the sequencer and back."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tfsat_host.devices.client import Client
from tfsat_host.devices.stored_record import VerifyError, repeat_until_stored
from tfsat_host.protocol.enums import Origin
from tfsat_host.protocol.framing import crc16
from tfsat_host.protocol.messages import (
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
)

if TYPE_CHECKING:
    from tfsat_host.maneuver import Schedule, TimedStroke


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

    origin: Origin
    strokes: tuple[tuple[int, int, int], ...]
    speed_cdeg_s: int
    crc: int
    end_us: int
    generation: int

    @property
    def moves(self) -> tuple[tuple[int, int], ...]:
        """(joint, angle_cdeg) of each stroke, in order."""
        return tuple((joint, angle_cdeg) for joint, angle_cdeg, _ in self.strokes)


@dataclass(frozen=True, slots=True)
class UploadResult:
    """A verified upload: `written` is False when the board held the same maneuver already."""

    written: bool
    stored: StoredManeuver


def upload_maneuver(client: Client, schedule: Schedule) -> UploadResult:
    """Sends the maneuver, has it stored, reads it back and compares.

    Nothing replaces the stored maneuver until all of it has arrived and was found valid; but from the first
    request on the board does not arm until an upload is complete.

    Raises:
        BoardError: the board refused; its stored maneuver is unchanged, and not armed any more.
        VerifyError: the board holds something else than was sent.
    """
    ask = client.request
    ask(ManeuverBeginRequest(len(schedule.strokes), schedule.speed_cdeg_s), ManeuverBeginReply)
    for index, stroke in enumerate(schedule.strokes):
        ask(
            ManeuverStrokeRequest(index, stroke.joint, stroke.angle_cdeg, stroke.t_us),
            ManeuverStrokeReply,
        )
    commit = ManeuverCommitRequest(maneuver_crc(schedule))
    written = repeat_until_stored(
        client,
        lambda: ask(commit, ManeuverCommitReply),
        "The maneuver from before is still stored, and not armed.",
    )
    stored = read_maneuver_back(client)
    wanted = tuple(_row(stroke) for stroke in schedule.strokes)
    if stored.strokes != wanted or stored.speed_cdeg_s != schedule.speed_cdeg_s:
        raise VerifyError(
            what=f"The sequencer holds {stored.strokes}, but {wanted} was sent.",
            meaning="It would fly something else than you asked for. Do not arm it.",
            next_step="Run the same upload again; if it recurs, replace the board.",
        )
    return UploadResult(written=written, stored=stored)


def read_maneuver_back(client: Client) -> StoredManeuver:
    """Reads what would fly, stroke by stroke, and checks it against the board's own CRC.

    Raises:
        VerifyError: the strokes read do not have the CRC that the board names.
    """
    info = client.request(ManeuverInfoRequest(), ManeuverInfoReply)
    replies = [
        client.request(ManeuverReadRequest(index), ManeuverReadReply) for index in range(info.stroke_count)
    ]
    strokes = tuple((reply.joint, reply.angle_cdeg, reply.start_us) for reply in replies)
    if _crc(info.speed_cdeg_s, strokes) != info.crc:
        raise VerifyError(
            what="The strokes read from the sequencer do not fit its CRC.",
            meaning="Its memory is damaged. Do not arm it.",
            next_step="Upload the maneuver again; if it recurs, replace the board.",
        )
    return StoredManeuver(info.origin, strokes, info.speed_cdeg_s, info.crc, info.end_us, info.generation)


def maneuver_crc(schedule: Schedule) -> int:
    """CRC-16/IBM-3740 of the canonical form (protocol reference, maneuver_commit)."""
    return _crc(schedule.speed_cdeg_s, tuple(_row(stroke) for stroke in schedule.strokes))


def _row(stroke: TimedStroke) -> tuple[int, int, int]:
    return stroke.joint, stroke.angle_cdeg, stroke.t_us


def _crc(speed_cdeg_s: int, strokes: tuple[tuple[int, int, int], ...]) -> int:
    canonical = struct.pack("<BH", len(strokes), speed_cdeg_s)
    canonical += b"".join(struct.pack("<BhI", *stroke) for stroke in strokes)
    return crc16(canonical)
