"""What is not ideal about one emulated robot: drawn from a seed, so that calibration has work to do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

FloatArray = NDArray[np.float64]

_GYRO_NOISE_DEG_S_RTHZ = 0.005  # PS-MPU-6000A rev. 3.4, section 6.1
_ACCEL_NOISE_G_RTHZ = 400e-6  # PS-MPU-6000A rev. 3.4, section 6.2
_STANDARD_GRAVITY_M_S2 = 9.80665


@dataclass(frozen=True, eq=False)
class Imperfections:
    """The hidden truth of one robot's sensors.

    Attributes:
        mounting: (4, 3, 3) rotation of each IMU from where the design puts it, in body axes.
        gyro_bias_rad_s: (4, 3) in sensor axes.
        gyro_scale: (4, 3) reading over truth.
        gyro_noise_rad_s_rthz: White noise density.
        accel_noise_m_s2_rthz: White noise density.
        angle_zero_rad: (6,) added to the design's zero offsets.
        angle_noise_rad: Standard deviation of a reading.
    """

    mounting: FloatArray
    gyro_bias_rad_s: FloatArray
    gyro_scale: FloatArray
    gyro_noise_rad_s_rthz: float
    accel_noise_m_s2_rthz: float
    angle_zero_rad: FloatArray
    angle_noise_rad: float


def ideal() -> Imperfections:
    """Sensors without any error but their resolution."""
    return Imperfections(
        mounting=np.tile(np.eye(3), (4, 1, 1)),
        gyro_bias_rad_s=np.zeros((4, 3)),
        gyro_scale=np.ones((4, 3)),
        gyro_noise_rad_s_rthz=0.0,
        accel_noise_m_s2_rthz=0.0,
        angle_zero_rad=np.zeros(6),
        angle_noise_rad=0.0,
    )


def draw(seed: int) -> Imperfections:
    """A plausible robot: biases of 1 deg/s, mounting errors of 1.5 deg an axis (both standard deviations).

    Scale factors stay exact here: the paper does not calibrate them, and its evaluation starts from that.
    """
    random = np.random.default_rng(seed)
    return Imperfections(
        mounting=Rotation.from_rotvec(np.deg2rad(1.5) * random.standard_normal((4, 3))).as_matrix(),
        gyro_bias_rad_s=np.deg2rad(1.0) * random.standard_normal((4, 3)),
        gyro_scale=np.ones((4, 3)),
        gyro_noise_rad_s_rthz=np.deg2rad(_GYRO_NOISE_DEG_S_RTHZ),
        accel_noise_m_s2_rthz=_ACCEL_NOISE_G_RTHZ * _STANDARD_GRAVITY_M_S2,
        angle_zero_rad=np.deg2rad(5.0) * random.standard_normal(6),
        angle_noise_rad=np.deg2rad(0.05),
    )
