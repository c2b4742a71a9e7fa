"""One step of a calibration as the emulated operator does it: the truth, and what the sensors read of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from tfsat_host.arrays import FloatArray
from tfsat_host.calibration.steps.counts import Counts
from tfsat_host.calibration.steps.step import Step
from tfsat_host.devices.logger import LoggerClient
from tfsat_host.emulated.emulated_operator import EmulatedOperator
from tfsat_host.emulated.emulated_robot import SETTLE_US, BoardIndex, EmulatedRobot
from tfsat_host.emulated.emulated_transport import EmulatedTransport
from tfsat_host.emulated.imperfections import Imperfections, ideal
from tfsat_host.emulated.manual_motion import Operator

TRUTH_US = 2_000


@dataclass(frozen=True, eq=False)
class Performance:
    """Of n rows of truth, one each 2 ms.

    Attributes:
        t_s: (n,) since the step began.
        joints_deg: (n, 3) true joint angles.
        attitudes: Of the four bodies, n each, body to world.
        rates_deg_s: (n, 4, 3) true body rates in body frames.
        counts: What the logger sent meanwhile.
        duration_s: As the operator told it.
    """

    t_s: FloatArray
    joints_deg: FloatArray
    attitudes: tuple[Rotation, ...]
    rates_deg_s: FloatArray
    counts: Counts
    duration_s: float

    def at(self, t_s: float) -> int:
        """Return the row nearest to time `t_s`."""
        # Rows are a step apart: the nearest is good enough.
        return int(np.argmin(np.abs(self.t_s - t_s)))

    def turn_deg(self, body: int, t_s: float) -> FloatArray:
        """(3,) deg, by what a body (1 to 4) has turned since the beginning, in its first frame."""
        # By what it turned since the step began, in its own first axes.
        attitude = self.attitudes[body - 1]
        return np.asarray(np.rad2deg((attitude[0].inv() * attitude[self.at(t_s)]).as_rotvec()))

    def gyros_deg_s(self) -> FloatArray:
        """(m, 4, 3) as read."""
        return np.asarray(self.counts.imu_counts[:, :, 4:7] / self.counts.scales.gyro_lsb_per_deg_s)


def perform(
    step: Step, hands: Operator | None = None, imperfections: Imperfections | None = None
) -> Performance:
    """Perform the step from its beginning until its motion has ended."""
    with EmulatedRobot(imperfections=imperfections or ideal(), seed=1) as robot:
        robot.advance(SETTLE_US)
        logger = LoggerClient.connect(EmulatedTransport(robot, BoardIndex.LOGGER))
        operator = EmulatedOperator(robot, hands)
        duration_s = operator.duration_s(step)
        samples = []
        with logger.live() as scales:
            begun_us = robot.now_us
            operator.begin(step)
            robot.record_truth(TRUTH_US)
            # 0.2 s more than the motion: the last samples are still under way when it ends.
            while robot.now_us < begun_us + round(duration_s * 1e6) + 200_000:
                samples += logger.live_samples()
        truth = robot.truth()
    return Performance(
        # A row of truth: time, 3 joint angles, 4 quaternions, 4 body rates.
        t_s=truth[:, 0] - begun_us * 1e-6,
        joints_deg=np.rad2deg(truth[:, 1:4]),
        attitudes=tuple(Rotation.from_quat(truth[:, 4 + 4 * body : 8 + 4 * body]) for body in range(4)),
        rates_deg_s=np.rad2deg(truth[:, 20:32]).reshape(-1, 4, 3),
        counts=Counts.from_live(samples, scales),
        duration_s=duration_s,
    )
