"""What a host asks of the sequencer: its state, arming, and the maneuver and servo settings that it stores."""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from tfsat_host.devices.board_errors import VerifyError, board_error
from tfsat_host.devices.client import BoardClient
from tfsat_host.maneuver import Maneuver, Schedule, Stroke, TimedStroke
from tfsat_host.protocol import messages as msg
from tfsat_host.protocol.enums import Board, ErrorCode, Origin, SequencerState
from tfsat_host.protocol.framing import crc16
from tfsat_host.protocol.record import Payload
from tfsat_host.servo_settings import ServoSettings
from tfsat_host.units import US_PER_S, deg_from_cdeg, s_from_us

Stored = TypeVar("Stored")

STORE_POLL_S = 0.02
STORE_TIMEOUT_S = 3.0
"""The EEPROM takes 3.4 ms a byte, a full maneuver 0.4 s."""


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
    def timed_strokes(self) -> tuple[TimedStroke, ...]:
        """Each stroke, with its end at the average speed."""
        return tuple(
            TimedStroke(
                start_us,
                joint,
                angle_cdeg,
                # Rounded up, as the board does.
                start_us - (-abs(angle_cdeg) * US_PER_S // self.speed_cdeg_s),
            )
            for joint, angle_cdeg, start_us in self.strokes
        )


@dataclass(frozen=True, slots=True)
class StoredSettings:
    """The servo settings in force.

    Attributes:
        origin: Factory or uploaded.
        generation: Settings that the board has stored.
        settings: What they say.
    """

    origin: Origin
    generation: int
    settings: ServoSettings


@dataclass(frozen=True, slots=True)
class Upload(Generic[Stored]):
    """A verified upload: `written` is False when the board held the same already."""

    written: bool
    stored: Stored


class SequencerClient(BoardClient):
    """The sequencer at the other end of a link."""

    board = Board.SEQUENCER

    def status(self) -> msg.SequencerStatusReply:
        """Read the board's status."""
        return self._client.request(msg.SequencerStatusRequest(), msg.SequencerStatusReply)

    def run_report(self) -> msg.RunReportReply:
        """Read the report of the last run since power was switched on, timed by the board's own timer."""
        return self._client.request(msg.RunReportRequest(), msg.RunReportReply)

    def upload(self, schedule: Schedule) -> Upload[StoredManeuver]:
        """Sends the maneuver, has it stored, reads it back and compares.

        Nothing replaces the stored maneuver until all of it has arrived and was found valid; but from the first
        request on the board does not arm until an upload is complete.

        Raises:
            BoardError: the board refused; its stored maneuver is unchanged, and not armed any more.
            VerifyError: the board holds something else than was sent.
        """
        ask = self._client.request
        rows = _rows(schedule)
        ask(msg.ManeuverBeginRequest(len(rows), schedule.speed_cdeg_s), msg.ManeuverBeginReply)
        # Each stroke carries its index, so a request may be repeated; the commit refuses if one is missing.
        for index, (joint, angle_cdeg, start_us) in enumerate(rows):
            ask(msg.ManeuverStrokeRequest(index, joint, angle_cdeg, start_us), msg.ManeuverStrokeReply)
        # The CRC covers the canonical form, so the board stores this whole maneuver or none.
        commit = msg.ManeuverCommitRequest(maneuver_crc(schedule))
        written = self._until_stored(
            lambda: ask(commit, msg.ManeuverCommitReply),
            "The maneuver from before is still stored, and not armed.",
        )
        # What flies is what is stored: read it back and compare it with what was meant.
        stored = self.read_back()
        if stored.strokes != rows or stored.speed_cdeg_s != schedule.speed_cdeg_s:
            raise _differs(stored.strokes, rows, "It would fly something else than you asked for.")
        return Upload(written, stored)

    def read_back(self) -> StoredManeuver:
        """Reads what would fly, stroke by stroke. Raises VerifyError where it does not fit the board's own CRC."""
        ask = self._client.request
        info = ask(msg.ManeuverInfoRequest(), msg.ManeuverInfoReply)
        replies = [
            ask(msg.ManeuverReadRequest(index), msg.ManeuverReadReply) for index in range(info.stroke_count)
        ]
        strokes = tuple((reply.joint, reply.angle_cdeg, reply.start_us) for reply in replies)
        if _crc(info.speed_cdeg_s, strokes) != info.crc:
            raise VerifyError(
                what="The strokes read from the sequencer do not fit its CRC.",
                meaning="Its memory is damaged. Do not arm it.",
                next_step="Upload the maneuver again; if it recurs, replace the board.",
            )
        return StoredManeuver(info.origin, strokes, info.speed_cdeg_s, info.crc, info.end_us, info.generation)

    def settings(self) -> StoredSettings:
        """Read the servo settings in force."""
        reply = self._client.request(msg.SettingsReadRequest(), msg.SettingsReadReply)
        # Stored by a firmware that knew of no such number, it is 0: one joint at a time.
        settings = ServoSettings(reply.frame_us, reply.servo, max(1, reply.moving_at_once))
        return StoredSettings(reply.origin, reply.generation, settings)

    def insist_on_safe(self, request: type[Payload] = msg.SettingsWriteRequest) -> None:
        """Raises what the board would answer to this request, which it takes only while it is safe."""
        if self.status().state != SequencerState.SAFE:
            raise board_error(msg.ErrorReply(request.TYPE, ErrorCode.WRONG_STATE, -1))

    def write_settings(self, settings: ServoSettings) -> Upload[StoredSettings]:
        """Has the servo settings stored, reads them back and compares.

        Raises:
            BoardError: the board refused; its settings are unchanged.
            VerifyError: the board holds something else than was sent.
        """
        request = msg.SettingsWriteRequest(settings.frame_us, settings.servos, settings.moving_at_once)
        # The generation counts what was stored and so tells whether this upload wrote.
        before = self.settings()
        self._until_stored(
            lambda: self._client.request(request, msg.SettingsWriteReply),
            "The settings from before are still in force.",
        )
        stored = self.settings()
        if stored.settings != settings:
            raise _differs(stored.settings, settings, "Its servos would go elsewhere than you asked for.")
        # The board's own word is about its last request of that content, which may be of an earlier upload.
        return Upload(stored.generation != before.generation, stored)

    def _until_stored(
        self, ask: Callable[[], msg.ManeuverCommitReply | msg.SettingsWriteReply], kept_sentence: str
    ) -> bool:
        """Repeats a request until the EEPROM holds what it is about; True when that had to be written.

        Raises VerifyError, with the sentence `kept_sentence`, if the board is still writing after STORE_TIMEOUT_S.
        """
        deadline = self.now_s() + STORE_TIMEOUT_S
        written = False
        while True:
            reply = ask()
            # The last answer alone does not tell: had it been lost, its repetition finds the record there already.
            written = written or bool(reply.written)
            if reply.stored:
                return written
            if self.now_s() > deadline:
                raise VerifyError(
                    what=f"The sequencer was still writing after {STORE_TIMEOUT_S:g} s.",
                    meaning=f"Its EEPROM may be worn out. {kept_sentence}",
                    next_step="Power the board off and on, then run the same upload again.",
                )
            self.wait(STORE_POLL_S)

    def report_joints(self, joints_cdeg: Sequence[int]) -> bool:
        """Reports the measured angles of joints 1 to 3, 0.01 deg; whether all are at the start pose.

        ARM heeds the report while it is fresh (JOINT_REPORT_AGE_MS).
        """
        report = msg.JointReportRequest(tuple(joints_cdeg))
        return bool(self._client.request(report, msg.JointReportReply).at_start_pose)

    def arm(self) -> SequencerState:
        """Arms: from now on the release starts the maneuver. Raises BoardRefusal with the reason."""
        # The token binds ARM to the state just seen: a copy that arrives late arms nothing.
        token = self.status().arm_token
        return self._client.request(msg.ArmRequest(token), msg.ArmReply).state

    def disarm(self) -> SequencerState:
        """Back to safe, from any state. Frozen: DISARM has this number and layout in every protocol."""
        return self._client.request(msg.DisarmRequest(), msg.DisarmReply).state


def maneuver_crc(schedule: Schedule) -> int:
    """CRC-16/IBM-3740 of the canonical form (protocol reference, maneuver_commit)."""
    return _crc(schedule.speed_cdeg_s, _rows(schedule))


def maneuver_from_board(stored: StoredManeuver, *, name: str = "") -> Maneuver:
    """Convert the maneuver that a board stores, each stroke with its time."""
    strokes = tuple(
        Stroke(joint, deg_from_cdeg(angle_cdeg), float(s_from_us(start_us)))
        for joint, angle_cdeg, start_us in stored.strokes
    )
    return Maneuver(strokes, speed_deg_s=deg_from_cdeg(stored.speed_cdeg_s), name=name)


def _rows(schedule: Schedule) -> tuple[tuple[int, int, int], ...]:
    return tuple((stroke.joint, stroke.angle_cdeg, stroke.t_us) for stroke in schedule.strokes)


def _crc(speed_cdeg_s: int, strokes: tuple[tuple[int, int, int], ...]) -> int:
    # Packed little endian: count and speed, then joint, angle and start of each stroke.
    canonical = struct.pack("<BH", len(strokes), speed_cdeg_s)
    canonical += b"".join(struct.pack("<BhI", *stroke) for stroke in strokes)
    return crc16(canonical)


def _differs(readback: object, sent: object, meaning: str) -> VerifyError:
    return VerifyError(
        what=f"The sequencer holds {readback}, but {sent} was sent.",
        meaning=f"{meaning} Do not arm it.",
        next_step="Run the same upload again; if it recurs, replace the board.",
    )
