"""What a rehearsal needs before it begins: the robot of a seed, the sequencer's image, its preflight."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tfsat_host.emulated.build import Variant, ensure_built
from tfsat_host.emulated.imu_part import ImuPart, load_imu
from tfsat_host.emulated.sequencer_image import sequencer_hex
from tfsat_host.errors import TfsatError, UsageError
from tfsat_host.maneuver import Schedule
from tfsat_host.plan.facility import load_tower
from tfsat_host.protocol.limits import IMU_COUNT, JOINT_COUNT
from tfsat_host.rehearsal.preflight import Preflight
from tfsat_host.rehearsal.truth import Truth, drawn_truth, truth_as_filed
from tfsat_host.robot import RobotModel, load_robot


@dataclass(frozen=True, slots=True)
class RehearsalOptions:
    """On which robot a drop is rehearsed.

    Attributes:
        sequencer: Its firmware's core on this computer, or the image that is flashed in an emulated ATmega32U4.
        robot: A robot file, or the name of a shipped one; None: the drop tower's.
        as_filed: The robot is exactly what its file says.
        imu: Another IMU on every body, by name or file; None: the robot's own.
        despite_preflight: It is dropped even if the preflight says NO-GO.
    """

    sequencer: Literal["native", "avr"] = "native"
    robot: str | None = None
    as_filed: bool = False
    imu: str | None = None
    despite_preflight: bool = False

    def filed(self) -> RobotModel:
        """The robot by its file.

        Raises:
            TfsatError: it cannot be read, or there are no boards for such a robot.
        """
        robot = load_robot(self.robot)
        if (robot.n_bodies, robot.n_joints, len(robot.imus)) != (IMU_COUNT, JOINT_COUNT, IMU_COUNT):
            raise TfsatError(
                what=f"{robot.name} cannot be rehearsed: its file has {robot.n_bodies} bodies, {robot.n_joints} joints "
                f"and {len(robot.imus)} IMUs, and the boards drop a robot of {IMU_COUNT} bodies with an IMU each and "
                f"{JOINT_COUNT} joints.",
                meaning="Nothing was flown.",
                next_step="Name a file like robots/drop_tower.toml with --robot, or leave it out. What such a robot "
                f"would do is computed by tfsat-host simulate --robot {self.robot}",
            )
        return robot

    def part(self) -> ImuPart | None:
        """The IMU that is wanted; None: the robot's own. Raises UsageError, TfsatError."""
        if self.imu is None:
            return None
        if self.as_filed:
            raise UsageError(
                what="--imu and --as-filed contradict each other: a robot as its file has it has no part's errors.",
                meaning="Nothing was flown.",
                next_step="Leave one of them out.",
            )
        return load_imu(self.imu)

    def truth(self, filed: RobotModel, seed: int) -> Truth:
        """The robot of a seed."""
        part = self.part()
        return truth_as_filed(filed, seed) if self.as_filed else drawn_truth(filed, seed, part)

    def image(self, note: Callable[[str], None]) -> Path | None:
        """The sequencer's image; None for its core. Builds what is missing, and says so."""
        hex_path = sequencer_hex(note) if self.sequencer == "avr" else None
        ensure_built(Variant(avr=hex_path is not None), note)
        return hex_path

    def preflight(self, schedule: Schedule, filed: RobotModel, image: Path | None) -> Preflight:
        """What every rehearsed drop is checked against."""
        return Preflight.of(schedule, filed, load_tower(None), image, despite=self.despite_preflight)
