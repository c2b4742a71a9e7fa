"""A drop of the emulated robot after a quiet wait in the releaser, and the biases that its gyros had."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.transport import EmulatedTransport


@cache
def quiet_drop(seed: int, wait_us: int = 14_000_000) -> tuple[bytes, NDArray[np.float64]]:
    """The card, and (4, 3) biases in rad/s."""
    with EmulatedRobot(seed=seed) as robot:
        robot.advance(SETTLE_US)
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        logger.start_recording()
        robot.advance(wait_us)
        robot.drop()
        while robot.falling:
            robot.advance(10_000)
        robot.advance(1_500_000)
        logger.stop_recording()
        return robot.card(), robot.imperfections.gyro_bias_rad_s
