"""The day of a rehearsed drop while it goes on: the boards, what the team holds, and what faults act on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.sequencer import SequencerClient, StoredManeuver, Upload
from tfsat_host.emulated.robot import US_PER_S, BoardIndex, EmulatedRobot
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.maneuver import Schedule
from tfsat_host.rehearsal.checked import Checked

CALIBRATED = datetime(2026, 1, 5, 8, 0, tzinfo=UTC)
"""When the emulated robot's morning on the bench begins; it is dropped an hour later."""
DROPPED = CALIBRATED + timedelta(hours=1)


@dataclass(eq=False)
class Day:
    """See the module.

    Attributes:
        robot: With its boards.
        schedule: Of the maneuver.
        calibration: That the drop will be evaluated with.
        recordings: Of the morning, by their files' names; those that the calibration names are its raw data.
        sequencer: Its connection.
        logger: Its connection.
        arming: Somebody will arm the robot.
        upload: Of the maneuver; None: it did not come through, or has not yet.
        checked: The preflight's result; None: there was none.
        landed_us: Virtual time of the landing.
        setbacks: What went wrong on the way; a sentence each.
    """

    robot: EmulatedRobot
    schedule: Schedule
    calibration: Calibration
    recordings: Mapping[str, bytes] = field(default_factory=dict)
    sequencer: SequencerClient = field(init=False)
    logger: LoggerClient = field(init=False)
    arming: bool = True
    upload: Upload[StoredManeuver] | None = None
    checked: Checked | None = None
    landed_us: int = 0
    setbacks: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.reconnect()

    def reconnect(self) -> None:
        """As a program that is started anew does."""
        self.sequencer = SequencerClient.connect(EmulatedTransport(self.robot, BoardIndex.SEQUENCER))
        self.logger = LoggerClient.connect(EmulatedTransport(self.robot, BoardIndex.LOGGER))

    def unix_s(self) -> float:
        """The team's clock. Compressed minutes do not count."""
        return DROPPED.timestamp() + self.robot.now_us / US_PER_S
