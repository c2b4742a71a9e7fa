"""What a host asks of the sequencer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Self

from tfsat_host.devices.client import BoardIdentity, Client
from tfsat_host.devices.maneuver_transfer import (
    StoredManeuver,
    UploadResult,
    read_maneuver_back,
    upload_maneuver,
)
from tfsat_host.devices.settings_transfer import (
    SettingsUpload,
    StoredSettings,
    read_settings,
    write_settings,
)
from tfsat_host.devices.stored_record import VerifyError
from tfsat_host.devices.transport import Transport
from tfsat_host.protocol.enums import Board, SequencerState
from tfsat_host.protocol.messages import (
    ArmReply,
    ArmRequest,
    DisarmReply,
    DisarmRequest,
    JointReportReply,
    JointReportRequest,
    RunReportReply,
    RunReportRequest,
    SequencerStatusReply,
    SequencerStatusRequest,
)
from tfsat_host.servo_settings import ServoSettings

if TYPE_CHECKING:
    from tfsat_host.maneuver import Schedule

__all__ = [
    "SequencerClient",
    "SettingsUpload",
    "StoredManeuver",
    "StoredSettings",
    "UploadResult",
    "VerifyError",
]


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

    def run_report(self) -> RunReportReply:
        """The last run since power was switched on, by the board's own timer."""
        return self._client.request(RunReportRequest(), RunReportReply)

    def upload(self, schedule: Schedule) -> UploadResult:
        """Sends the maneuver, has it stored, reads it back and compares.

        Raises:
            BoardError: the board refused; its stored maneuver is unchanged, and not armed any more.
            VerifyError: the board holds something else than was sent.
        """
        return upload_maneuver(self._client, schedule)

    def read_back(self) -> StoredManeuver:
        """Reads what would fly. Raises VerifyError where it does not fit the board's own CRC."""
        return read_maneuver_back(self._client)

    def settings(self) -> StoredSettings:
        """The servo settings in force."""
        return read_settings(self._client)

    def write_settings(self, settings: ServoSettings) -> SettingsUpload:
        """Has the servo settings stored, reads them back and compares.

        Raises:
            BoardError: the board refused; its settings are unchanged.
            VerifyError: the board holds something else than was sent.
        """
        return write_settings(self._client, settings)

    def report_joints(self, joints_cdeg: Sequence[int]) -> bool:
        """Tells the board the measured angles of joints 1 to 3, 0.01 deg; whether all are at the start pose.

        ARM heeds the report while it is fresh (JOINT_REPORT_AGE_MS).
        """
        report = JointReportRequest(tuple(joints_cdeg))
        return bool(self._client.request(report, JointReportReply).at_start_pose)

    def arm(self) -> SequencerState:
        """Arms: from now on the release starts the maneuver. Raises BoardRefusal with the reason."""
        token = self.status().arm_token
        return self._client.request(ArmRequest(token), ArmReply).state

    def disarm(self) -> SequencerState:
        """Back to safe, from any state. Frozen: DISARM has this number and layout in every protocol."""
        return self._client.request(DisarmRequest(), DisarmReply).state
