"""The preflight of a rehearsed day: the checks of `tfsat-host preflight`, asked of the emulated boards."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from tfsat_host.devices.ports import BoardName
from tfsat_host.devices.transport import Transport
from tfsat_host.emulated.robot import BoardIndex
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.errors import TfsatError
from tfsat_host.flashing.image import load_image
from tfsat_host.maneuver import Schedule
from tfsat_host.plan.envelope import envelope_of
from tfsat_host.plan.facility import DropTower
from tfsat_host.plan.tower_checks import Check as FacilityCheck
from tfsat_host.plan.tower_checks import check_maneuver
from tfsat_host.preflight import judge
from tfsat_host.preflight.boards import Expected, ask_boards
from tfsat_host.preflight.evidence import Missing, Reference
from tfsat_host.preflight.trial import Trace
from tfsat_host.rehearsal.checked import Checked
from tfsat_host.rehearsal.day import Day
from tfsat_host.robot import RobotModel

RECORDINGS = 10
"""The card must have room for so many, as for `tfsat-host preflight`."""


@dataclass(frozen=True, eq=False)
class Preflight:
    """What a day's preflight checks the boards against.

    Attributes:
        schedule: What is to be flown.
        filed: The robot as its file has it.
        facility: What the facility says of that maneuver.
        image: The sequencer's; None: its core runs natively, without one.
        despite: The team drops even if it says NO-GO.
    """

    schedule: Schedule
    filed: RobotModel
    facility: tuple[FacilityCheck, ...]
    image: Path | None = None
    despite: bool = False

    @classmethod
    def of(
        cls, schedule: Schedule, filed: RobotModel, tower: DropTower, image: Path | None, *, despite: bool
    ) -> Preflight:
        """For a maneuver in a drop tower. Raises EnvelopeError: its envelope cannot be told."""
        envelope = envelope_of(filed, schedule, until_s=tower.fall_s)
        return cls(schedule, filed, check_maneuver(schedule, filed, tower, envelope), image, despite)

    def made(self, day: Day) -> Checked:
        """Asks both boards; the logger records some seconds onto its card, and removes that again.

        Raises:
            TfsatError: the sequencer is armed or moves.
        """
        boards: dict[BoardName, Transport | TfsatError] = {
            "sequencer": EmulatedTransport(day.robot, BoardIndex.SEQUENCER),
            "logger": EmulatedTransport(day.robot, BoardIndex.LOGGER),
        }
        evidence = ask_boards(boards, self._expected(day), Trace(), day.unix_s)
        return Checked(evidence, judge(evidence))

    def _expected(self, day: Day) -> Expected:
        none_named = Missing("no image was named.", "Name it with --logger-image.")
        image: Reference | Missing = none_named
        if self.image is not None:
            image = Reference(load_image(self.image).crc, str(self.image))
        return Expected(
            robot=self.filed,
            schedule=self.schedule,
            facility=self.facility,
            sequencer_image=image,
            logger_image=none_named,
            certificate=lambda _: (day.calibration, "the rehearsal's calibration"),
            recordings=RECORDINGS,
            newest_file=None,
            now=datetime.fromtimestamp(day.unix_s(), UTC),
        )
