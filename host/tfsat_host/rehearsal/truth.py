"""The hidden truth of a rehearsed drop: drawn before it, and what an evaluation is compared with."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tfsat_host.arrays import FloatArray
from tfsat_host.emulated.imperfections import Imperfections, draw, draw_as_built
from tfsat_host.emulated.imu_part import ImuPart, imperfections_with, load_imu
from tfsat_host.robot import RobotModel

ROBOTS_IMU = "mpu6050"
"""On every body of the drop tower robot (paper, tab. mpu)."""
RESIDUAL_RATE_DEG_S = np.array([-0.73, -0.48, -0.77])
"""Of body 3 about its axes after the paper's release (sec. Result): the robot does not leave the releaser at rest."""
RATE_SPREAD_DEG_S = 0.7
"""Of each of these from robot to robot: they are of that size themselves."""
_COM_STD_M = 0.003
"""Of a coordinate of a center of mass, if the robot's file states none."""
CORRECTED_BODIES = 3
"""Bodies 1 to 3: the paper's correction."""
_SERVO_GAIN_STD = 0.002
_SERVO_OFFSET_STD_RAD = np.deg2rad(0.1)
"""What calibrating a servo leaves (docs/servos.md)."""
_SERVO_OVERSHOOT_DEG = (0.1, 0.5)
"""Between these; assumed, not measured on the robot."""


@dataclass(frozen=True, eq=False)
class Truth:
    """One robot and how it is let go.

    Attributes:
        seed: That it was drawn from; also of noise and contact bounce.
        model: The robot as it is.
        imperfections: Of its sensors, servos and clocks.
        rate_rad_s: (3,) of body 3, its axes, at the release.
        calibrated: Its sensors, servos and clocks on the day of the calibration; None: as now.
        imu: Name of the part on every body; empty: of none, whose noise alone is a MPU-6050's.
    """

    seed: int
    model: RobotModel
    imperfections: Imperfections
    rate_rad_s: FloatArray
    imu: str = ""
    calibrated: Imperfections | None = None


def drawn_truth(filed: RobotModel, seed: int, part: ImuPart | None = None) -> Truth:
    """Draw a robot as it might have been built from its file and calibrated since.

    Centers of mass of bodies 1 to 3, which the evaluation corrects as the paper does, are off as the file's
    table `[uncertainty]` says. Servos are off by what their calibration leaves, and they overshoot. Angle
    sensors and clocks come from `draw_as_built`, gyro errors from the IMU part: gyros get warm, wander, and
    feel gravity while the robot hangs, but not in the fall.
    Masses and inertias stay: they can be weighed and swung.

    `part` are its IMUs; None: the robot's own, `ROBOTS_IMU`.
    """
    # Draws come in a fixed order: new ones get a stream of their own, so that a seed's robot stays itself.
    random = np.random.default_rng([seed, 11])
    std_m = _COM_STD_M if filed.uncertainty is None else filed.uncertainty.com_m
    com_m = filed.com_m.copy()
    # Only the bodies that the evaluation corrects are off; the last one's CoM stays as filed.
    com_m[:CORRECTED_BODIES] += std_m * random.standard_normal((CORRECTED_BODIES, 3))
    model = replace(filed, com_m=com_m)
    joints = filed.n_joints
    imu = part or load_imu(ROBOTS_IMU)
    # Sensors as built, servos as their calibration leaves them: the maneuver flies on calibrated settings.
    imperfections = replace(
        imperfections_with(imu, seed, draw_as_built(seed)),
        servo_gain=1.0 + _SERVO_GAIN_STD * random.standard_normal(joints),
        servo_offset_rad=_SERVO_OFFSET_STD_RAD * random.standard_normal(joints),
        servo_overshoot_rad=_drawn_overshoot_rad(seed, joints),
    )
    rate_deg_s = RESIDUAL_RATE_DEG_S + RATE_SPREAD_DEG_S * random.standard_normal(3)
    return Truth(seed, model, imperfections, np.deg2rad(rate_deg_s), imu.name)


def _drawn_overshoot_rad(seed: int, joints: int) -> FloatArray:
    """Draw the servos' overshoots from a generator of their own.

    A seed's other errors thus stay as they always were.
    """
    return np.deg2rad(np.random.default_rng([seed, 12]).uniform(*_SERVO_OVERSHOOT_DEG, joints))


def truth_as_filed(filed: RobotModel, seed: int) -> Truth:
    """Return a robot exactly as its file says, with exact servos.

    Sensor biases, mountings and noise are drawn from the seed.
    """
    return Truth(seed, filed, draw(seed), np.deg2rad(RESIDUAL_RATE_DEG_S))


def hash_of(seed: int, number: int) -> int:
    """Compute the seed of one of a robot's drops, the same in every process."""
    return int(np.random.SeedSequence([seed, number]).generate_state(1, np.uint64)[0] >> np.uint64(2))
