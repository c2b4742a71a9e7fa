"""Emulated drops with a hidden truth, for everything that is evaluated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tfsat_host.calibration.certificate.certificate import Calibration
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.devices.logger_settings import FACTORY
from tfsat_host.devices.sequencer import SequencerClient
from tfsat_host.emulated.certificate import careful_certificate
from tfsat_host.emulated.imperfections import Imperfections
from tfsat_host.emulated.robot import FALL_S, SETTLE_US, US_PER_S, BoardIndex, EmulatedRobot
from tfsat_host.emulated.transport import EmulatedTransport
from tfsat_host.maneuver import Schedule, four_stroke, schedule_maneuver
from tfsat_host.robot import RobotModel
from tfsat_host.sdlog import DropLog, load

FloatArray = NDArray[np.float64]

WAIT_US = 6 * US_PER_S
TRUTH_PERIOD_US = 1000
DLPF_42_HZ, DLPF_5_HZ = 3, 6
MORNING = datetime(2026, 1, 5, 8, 0, tzinfo=UTC)


@dataclass(frozen=True, eq=False)
class Drop:
    """One drop.

    Attributes:
        log: As decoded.
        schedule: What was commanded.
        model: What the robot is thought to be.
        flown: What it is.
        truth: See `EmulatedRobot.truth`, its times after the release.
        landed_s: After the release.
    """

    log: DropLog
    schedule: Schedule
    model: RobotModel
    flown: RobotModel
    imperfections: Imperfections
    truth: FloatArray
    landed_s: float

    def true_turn(self, body: int, from_s: float, until_s: float) -> Rotation:
        """Of body 1 to 4, in its own axes at `from_s`."""
        attitudes = Rotation.from_quat(self.truth[:, 4 * body : 4 * body + 4])
        first, last = (int(np.abs(self.truth[:, 0] - t_s).argmin()) for t_s in (from_s, until_s))
        return attitudes[first].inv() * attitudes[last]

    def true_angles_rad(self, t_s: FloatArray) -> FloatArray:
        """(n, 3) of the joints."""
        return np.column_stack([np.interp(t_s, self.truth[:, 0], self.truth[:, 1 + j]) for j in range(3)])

    @property
    def true_com_offsets_mm(self) -> FloatArray:
        """(9,) of bodies 1 to 3."""
        return np.asarray(1e3 * (self.flown.com_m - self.model.com_m)[:3].ravel())


def drop(
    folder: Path,
    model: RobotModel,
    flown: RobotModel,
    imperfections: Imperfections,
    *,
    seed: int,
    dlpf_cfg: int = DLPF_42_HZ,
    bus_khz: int = FACTORY.bus_khz,
    rate_rad_s: tuple[float, ...] = (0.0, 0.0, 0.0),
    angles_deg: tuple[float, float] = (59.0, 70.0),
    before_drop: Callable[[EmulatedRobot], None] = lambda _: None,
) -> Drop:
    """Uploads, records, arms, drops; the log lies in `folder` as SD.bin."""
    schedule = schedule_maneuver(four_stroke(*angles_deg))
    with EmulatedRobot(flown, imperfections=imperfections, seed=seed, session_seed=seed) as robot:
        robot.advance(SETTLE_US)
        sequencer = SequencerClient.connect(EmulatedTransport(robot, BoardIndex.SEQUENCER))
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        logger.write_settings(replace(FACTORY, dlpf_cfg=dlpf_cfg, bus_khz=bus_khz))
        sequencer.upload(schedule)
        robot.record_truth(TRUTH_PERIOD_US)
        logger.start_recording()
        robot.advance(WAIT_US)
        sequencer.arm()
        for board in BoardIndex:
            robot.set_cable(board, False)
        robot.advance(US_PER_S)
        before_drop(robot)
        robot.drop(rate_rad_s)
        while robot.falling:
            robot.advance(TRUTH_PERIOD_US)
        robot.advance(US_PER_S)
        for board in BoardIndex:
            robot.set_cable(board, True)
        robot.advance(SETTLE_US)
        logger.stop_recording()
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "SD.bin").write_bytes(robot.card())
        truth = robot.truth()
        truth[:, 0] -= robot.released_us / US_PER_S
    return Drop(load(folder / "SD.bin"), schedule, model, flown, imperfections, truth, FALL_S)


def with_com_offsets(model: RobotModel, offsets_m: FloatArray) -> RobotModel:
    """The robot with the centers of mass of bodies 1 to 3 moved by (3, 3)."""
    com = model.com_m.copy()
    com[:3] += offsets_m
    return replace(model, com_m=com)


def calibrated_from_truth(model: RobotModel, truth: Imperfections, seed: int) -> Calibration:
    """A certificate as a careful day on the bench would have it."""
    return careful_certificate(model, truth, seed, MORNING)
